// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::capture {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == text.npos) return {};
  text = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
  const bool quoted = text.size() > 1 && text.front() == '"' && text.back() == '"';
  return quoted ? trimmed(text.substr(1, text.size() - 2)) : text;
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == line.npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& file, const std::vector<std::string>& columns)
    : name_(file.string()) {
  constexpr std::uint64_t kMostBytes = 256u << 20;  // a day of 100 Hz
  FileBytes read = read_file(file, kMostBytes, Links::follow);
  if (!read.fault.empty()) throw InputError(name_ + ": " + read.fault);
  content_.assign(read.bytes.begin(), read.bytes.end());
  if (content_.starts_with("\xef\xbb\xbf")) at_ = 3;
  if (!next_line()) throw InputError(name_ + ": is empty; expected a header line");
  columns_ = cells_.size();
  for (const std::string& column : columns) {
    const auto found = std::find_if(cells_.begin(), cells_.end(), [&](std::string_view cell) {
      return lower_case(cell) == column;
    });
    if (found == cells_.end()) fail("has no column \"" + column + "\" in its header line");
    positions_.push_back(static_cast<std::size_t>(found - cells_.begin()));
  }
}

bool CsvReader::next_line() {
  while (at_ < content_.size()) {
    const std::size_t end = std::min(content_.find('\n', at_), content_.size());
    const std::string_view line = trimmed(std::string_view(content_).substr(at_, end - at_));
    at_ = end + 1;
    ++line_number_;
    if (line.empty() || line.starts_with('#')) continue;
    cells_ = split(line);
    const bool torn = end == content_.size() && cells_.size() < columns_;
    return !torn;  // the power went while it was written
  }
  return false;
}

bool CsvReader::next() {
  if (!next_line()) return false;
  for (const std::size_t position : positions_) {
    if (position >= cells_.size()) fail("has too few values");
  }
  return true;
}

std::string_view CsvReader::text(std::size_t column) const { return cells_[positions_[column]]; }

double CsvReader::number(std::size_t column) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::string_view digits = text(column);
  if (digits.empty()) return kNone;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size()) {
    fail("\"" + printable(std::string(digits.substr(0, 40))) + "\" is not a number");
  }
  return error == std::errc() && std::isfinite(value) ? value : kNone;
}

void CsvReader::fail(const std::string& fault) const {
  throw InputError(name_ + ":" + std::to_string(line_number_) + ": " + fault +
                   "; correct the file, or remove it to go without");
}

}  // namespace nadir::capture

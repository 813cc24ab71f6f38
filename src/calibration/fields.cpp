// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "fields.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

// "!!str 5" to "5": what a tag promises is checked by who reads the value.
std::string_view without_tag(std::string_view text) {
  text = trimmed(text);
  if (!text.starts_with('!')) return text;
  const std::size_t end = text.find_first_of(kSpace);
  return end == text.npos ? std::string_view{} : trimmed(text.substr(end));
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string result(trimmed(text).substr(0, kMost));
  std::replace_if(
      result.begin(), result.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  return '"' + result + '"';
}

std::string read_text(const std::filesystem::path& file) {
  constexpr off_t kMostBytes = 1 << 20;  // a calibration has about 1 kB
  const auto fail = [&](const std::string& fault) {
    throw InputError(file.string() + ": " + fault);
  };
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) fail(std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  const bool regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  std::string content;
  if (regular && status.st_size <= kMostBytes) {
    content.resize(static_cast<std::size_t>(status.st_size));
    std::size_t done = 0;
    while (done < content.size()) {
      const ssize_t count = ::read(descriptor, content.data() + done, content.size() - done);
      if (count <= 0) break;
      done += static_cast<std::size_t>(count);
    }
    content.resize(done);
  }
  ::close(descriptor);
  if (!regular) fail("is not a regular file");
  if (status.st_size > kMostBytes) fail("is larger than 1 MB; this is not a calibration file");
  return content;
}

void blank(std::string& text, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < std::min(end, text.size()); ++i) {
    if (text[i] != '\n') text[i] = ' ';
  }
}

// Comments, directives and document marks become blanks, so that lines keep their numbers.
void blank_yaml_comments(std::string& text) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line(text.data() + begin, end - begin);
    if (line.starts_with('%') || line.starts_with("---") || line.starts_with("...")) {
      blank(text, begin, end);
    }
    char quote = 0, before = ' ';
    for (std::size_t i = begin; i < end; ++i) {
      const char c = text[i];
      if (quote == 0 && c == '#' && kSpace.find(before) != kSpace.npos) blank(text, i, end);
      if (quote == 0 ? c == '"' || c == '\'' : c == quote) quote = quote == 0 ? c : char{0};
      before = c;
    }
    begin = end + 1;
  }
}

void blank_xml_comments(std::string& text) {
  constexpr std::string_view kPairs[][2] = {{"<!--", "-->"}, {"<?", "?>"}};
  for (const auto& [open, close] : kPairs) {
    for (std::size_t at = text.find(open); at != text.npos; at = text.find(open, at)) {
      const std::size_t end = text.find(close, at);
      blank(text, at, end == text.npos ? text.size() : end + close.size());
    }
  }
}

std::vector<Field> top_level(std::string_view content, Syntax syntax) {
  std::vector<Field> fields = split_fields(content, 1, syntax);
  if (syntax == Syntax::yaml) return fields;
  if (fields.size() != 1 || fields[0].key != "opencv_storage") {
    throw InputError("1: no <opencv_storage>; this XML was not written by OpenCV");
  }
  return split_fields(fields[0].text, fields[0].line, syntax);
}

}  // namespace

FieldFile::FieldFile(const std::filesystem::path& file)
    : name_(file.string()), content_(read_text(file)) {
  if (content_.starts_with("\xef\xbb\xbf")) content_.erase(0, 3);
  const std::string_view start = trimmed(content_);
  if (start.empty()) throw InputError(name_ + ": is empty");
  if (content_.find('\0') != content_.npos) throw InputError(name_ + ": is not a text file");
  if (start.starts_with('{')) {
    throw InputError(name_ + ": JSON is not read; write OpenCV YAML or XML");
  }
  syntax_ = start.starts_with('<') ? Syntax::xml : Syntax::yaml;
  if (syntax_ == Syntax::xml) {
    blank_xml_comments(content_);
  } else {
    blank_yaml_comments(content_);
  }
  try {
    fields_ = top_level(content_, syntax_);
  } catch (const InputError& error) {
    throw InputError(name_ + ":" + error.what() + "; expected OpenCV YAML or XML");
  }
}

const Field* FieldFile::find(std::string_view key) const {
  const Field* found = nullptr;
  for (const Field& field : fields_) {
    if (field.key != key) continue;
    if (found != nullptr) fail(key, "is given twice", "delete one");
    found = &field;
  }
  return found;
}

const Field& FieldFile::required(std::string_view key) const {
  if (const Field* field = find(key)) return *field;
  constexpr std::size_t kMostNamed = 6;
  std::string keys;
  for (std::size_t i = 0; i < std::min(fields_.size(), kMostNamed); ++i) {
    keys += (i == 0 ? "" : ", ") + std::string(fields_[i].key.substr(0, 40));
  }
  throw InputError(name_ + ": " + std::string(key) +
                   " is missing; add it (found: " + (keys.empty() ? "nothing" : keys) + ")");
}

void FieldFile::fail(std::string_view key, const std::string& fault,
                     const std::string& remedy) const {
  const auto field = std::find_if(fields_.begin(), fields_.end(),
                                  [&](const Field& candidate) { return candidate.key == key; });
  const std::string line = field == fields_.end() ? "" : ":" + std::to_string(field->line);
  throw InputError(name_ + line + ": " + std::string(key) + ": " + fault + "; " + remedy);
}

double FieldFile::parse_number(std::string_view key, std::string_view text) const {
  std::string_view digits = trimmed(text);
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
    fail(key, shown(text) + " is not a finite number", "correct it");
  }
  return value;
}

double FieldFile::number(std::string_view key) const {
  return parse_number(key, without_tag(required(key).text));
}

int FieldFile::integer(std::string_view key) const {
  const double value = number(key);
  constexpr double kLargest = 1e9;
  if (value != std::floor(value) || std::abs(value) > kLargest) {
    fail(key, "is not a whole number", "correct it");
  }
  return static_cast<int>(value);
}

std::string FieldFile::word(std::string_view key) const {
  std::string_view text = without_tag(required(key).text);
  const bool quoted = text.size() > 1 && (text.front() == '"' || text.front() == '\'') &&
                      text.back() == text.front();
  if (quoted) text = text.substr(1, text.size() - 2);
  return std::string(text);
}

std::vector<double> FieldFile::parse_numbers(std::string_view key, std::string_view text) const {
  if (text.starts_with('[') && text.ends_with(']')) text = text.substr(1, text.size() - 2);
  const std::string_view separators = syntax_ == Syntax::xml ? kSpace : ",";
  std::vector<double> numbers;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find_first_of(separators), text.size());
    const std::string_view item = trimmed(text.substr(0, length));
    if (!item.empty()) numbers.push_back(parse_number(key, item));
    text.remove_prefix(std::min(text.size(), length + 1));
  }
  return numbers;
}

Eigen::MatrixXd FieldFile::matrix(std::string_view key) const {
  const char* const kRemedy = "write it as an opencv-matrix with rows, cols and data";
  const Field& field = required(key);
  std::vector<Field> parts;
  try {
    parts = split_fields(field.text, field.line, syntax_);
  } catch (const InputError&) {
    fail(key, "is not a matrix", kRemedy);
  }
  const auto part = [&](std::string_view name) {
    for (const Field& candidate : parts) {
      if (candidate.key == name) return without_tag(candidate.text);
    }
    fail(key, "has no " + std::string(name), kRemedy);
  };
  constexpr double kMostValues = 64;
  const double rows = parse_number(key, part("rows")), columns = parse_number(key, part("cols"));
  if (!(rows >= 1 && columns >= 1 && rows * columns <= kMostValues)) {
    fail(key, "has an impossible size", kRemedy);
  }
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Matrix matrix(static_cast<int>(rows), static_cast<int>(columns));
  const std::vector<double> values = parse_numbers(key, part("data"));
  if (values.size() != static_cast<std::size_t>(matrix.size())) {
    fail(key,
         "has " + std::to_string(values.size()) + " values for " + std::to_string(matrix.rows()) +
             " x " + std::to_string(matrix.cols()),
         kRemedy);
  }
  std::copy(values.begin(), values.end(), matrix.data());
  return matrix;
}

}  // namespace nadir::calibration

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pose_text.hpp"

#include <charconv>
#include <cmath>

#include "file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::capture {
namespace {

constexpr std::string_view kBlank = " \t";

std::string quoted(std::string_view word) {
  return '"' + printable(std::string(word.substr(0, 40))) + '"';
}

}  // namespace

PoseText::PoseText(const std::filesystem::path& file) : name_(file.string()) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    throw InputError(name_ + ": there is no such file; check its name");
  }
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(name_ + ": is not a file; check its name");
  }
  stream_.open(file, std::ios::binary);
  if (!stream_) throw InputError(name_ + ": cannot be opened; check its permissions");
}

bool PoseText::next() {
  if (!std::getline(stream_, line_)) {
    if (stream_.bad()) throw InputError(name_ + ": cannot be read; check the disk");
    return false;
  }
  ++number_;
  if (number_ == 1 && line_.starts_with("\xef\xbb\xbf")) line_.erase(0, 3);
  if (line_.ends_with('\r')) line_.pop_back();
  return true;
}

double PoseText::real(std::string_view word, const char* what) const {
  constexpr double kMost = 1e10;  // beyond lies only a slip
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    fail(quoted(word) + " is not a number, expected " + what, "correct the line or take it out");
  }
  if (!std::isfinite(value) || std::abs(value) > kMost) {
    fail(std::string(what) + " is " + quoted(word), "take the line out");
  }
  return value;
}

Rigid3 PoseText::pose(const Eigen::Quaterniond& rotation,
                      const Eigen::Vector3d& translation) const {
  constexpr double kTolerance = 0.01;  // of figures cut to two decimals
  if (!(std::abs(rotation.norm() - 1) < kTolerance)) {
    fail("the quaternion is not of unit length", "check the order of the line's values");
  }
  return {rotation.normalized(), translation};
}

void PoseText::fail(const std::string& fault, const std::string& remedy) const {
  throw InputError(name_ + ':' + std::to_string(number_) + ": " + fault + "; " + remedy);
}

std::vector<std::string_view> words_of(std::string_view line, std::size_t most) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlank); at != line.npos;) {
    const bool rest = words.size() + 1 == most;
    const std::size_t end =
        rest ? line.find_last_not_of(kBlank) + 1 : line.find_first_of(kBlank, at);
    words.push_back(line.substr(at, end == line.npos ? end : end - at));
    at = rest || end == line.npos ? line.npos : line.find_first_not_of(kBlank, end);
  }
  return words;
}

}  // namespace nadir::capture

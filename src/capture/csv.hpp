// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Comma-separated files with a header line.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace nadir::capture {

/// Seconds either side of zero that are accepted: the difference of two, in nanoseconds, stays
/// within 64 bits.
inline constexpr double kLatest_s = 4.6e9;
inline bool is_time(double seconds) { return std::abs(seconds) < kLatest_s; }

/// Columns are found by name, in any order and letter case; others are ignored, and so are a byte
/// order mark, carriage returns, blanks around a value, quotes around it, blank lines and lines
/// that start with #. Throws InputError "FILE:LINE: fault; remedy".
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& file, const std::vector<std::string>& columns);

  /// To the next row; false at the end.
  bool next();
  /// By position among the columns asked for.
  std::string_view text(std::size_t column) const;
  /// NaN for an empty value, "nan" or "inf"; InputError for what is not a number.
  double number(std::size_t column) const;
  [[noreturn]] void fail(const std::string& fault) const;

 private:
  bool next_line();

  std::string name_;
  std::string content_;
  std::size_t at_ = 0;
  std::size_t columns_ = 0;  ///< of the header line
  int line_number_ = 0;
  std::vector<std::string_view> cells_;
  std::vector<std::size_t> positions_;  ///< of the columns asked for
};

}  // namespace nadir::capture

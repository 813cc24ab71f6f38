// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Text files of poses, read line by line: those of a large survey do not fit a small computer.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "nadir/core/rigid3.hpp"

namespace nadir::capture {

class PoseText {
 public:
  /// Throws InputError when it is not a regular file that can be read.
  explicit PoseText(const std::filesystem::path& file);

  /// To the next line, whatever it holds; false at the end.
  bool next();
  /// Without a carriage return at its end.
  std::string_view line() const { return line_; }
  int number() const { return number_; }

  /// The word as a finite number within 1e10, or InputError naming `what` it should be.
  double real(std::string_view word, const char* what) const;
  /// A rotation and translation; quaternions must be of unit length within 1 %.
  Rigid3 pose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) const;
  /// "FILE:LINE: fault; remedy"
  [[noreturn]] void fail(const std::string& fault, const std::string& remedy) const;

 private:
  std::string name_;
  std::ifstream stream_;
  std::string line_;
  int number_ = 0;
};

/// What blanks and tabs separate; at most so many words, the last of which takes the rest.
std::vector<std::string_view> words_of(std::string_view line,
                                       std::size_t most = std::string_view::npos);

}  // namespace nadir::capture

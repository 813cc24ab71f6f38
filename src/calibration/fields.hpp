// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Reading values out of a calibration file's tree without trusting it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "field.hpp"

namespace nadir::calibration {

/// A mapping within a file: a view, valid as long as its Field. Every failure is an InputError
/// "FILE:LINE: KEY: fault; remedy"; a key given twice is refused when it is looked at.
class Fields {
 public:
  /// path: the mapping's own key, with a point at its end, when it is not the root.
  Fields(const Field& mapping, std::string file, std::string path = "");

  /// The root element's name in XML; empty in YAML.
  const std::string& name() const { return mapping_->key; }
  /// Refuses XML that is not FileStorage's.
  void require_opencv() const;
  bool has(std::string_view key) const { return find(key) != nullptr; }
  /// Whether some key begins so; that key, or empty.
  std::string key_starting_with(std::string_view prefix) const;
  bool is_mapping(std::string_view key) const;
  bool is_sequence(std::string_view key) const;

  double number(std::string_view key) const;
  /// Zero when it is not there.
  double number_or_zero(std::string_view key) const { return has(key) ? number(key) : 0; }
  int integer(std::string_view key) const;
  std::string word(std::string_view key) const;
  /// An opencv-matrix, a list of numbers (a column), or a list of rows: at most 64 finite numbers.
  Eigen::MatrixXd matrix(std::string_view key) const;
  /// The same row by row, of exactly this many.
  std::vector<double> numbers(std::string_view key, std::size_t count) const;
  Fields inside(std::string_view key) const;
  /// The mappings of a sequence, or all the mappings in this one that bear this key (XML).
  std::vector<Fields> list(std::string_view key) const;

  [[noreturn]] void fail(std::string_view key, const std::string& fault,
                         const std::string& remedy) const;

 private:
  const Field* find(std::string_view key) const;
  const Field& required(std::string_view key) const;
  double parse_number(std::string_view key, const Field& field) const;
  double parse_number(std::string_view key, std::string_view text) const;
  std::vector<double> parse_numbers(std::string_view key, const Field& field) const;
  Eigen::MatrixXd opencv_matrix(std::string_view key, const Field& field) const;

  const Field* mapping_;
  std::string file_, path_;
};

}  // namespace nadir::calibration

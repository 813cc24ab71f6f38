// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The part of YAML and XML that OpenCV's FileStorage writes, read without trusting the file.
// OpenCV's own parser is not used: it crashes on damaged files (stack overflow at deep nesting,
// wild reads in XML).
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace nadir::calibration {

enum class Syntax { yaml, xml };

/// A key and its value as it stands in the text, nested values included.
struct Field {
  std::string_view key;
  std::string_view text;
  int line = 1;
};

/// The keys of a block of YAML mapping or of the content of an XML element, one level deep.
/// Throws InputError with the line, but no file name, when the text is neither.
std::vector<Field> split_fields(std::string_view text, int first_line, Syntax syntax);

/// A file of keys, read whole. Every failure is an InputError "FILE:LINE: KEY: fault; remedy".
class FieldFile {
 public:
  /// Takes regular files of at most 1 MB.
  explicit FieldFile(const std::filesystem::path& file);
  FieldFile(const FieldFile&) = delete;  // fields_ looks into content_
  FieldFile& operator=(const FieldFile&) = delete;

  bool has(std::string_view key) const { return find(key) != nullptr; }
  double number(std::string_view key) const;
  int integer(std::string_view key) const;
  std::string word(std::string_view key) const;
  /// An opencv-matrix of finite numbers, at most 64 of them.
  Eigen::MatrixXd matrix(std::string_view key) const;

  [[noreturn]] void fail(std::string_view key, const std::string& fault,
                         const std::string& remedy) const;

 private:
  const Field* find(std::string_view key) const;
  const Field& required(std::string_view key) const;
  double parse_number(std::string_view key, std::string_view text) const;
  std::vector<double> parse_numbers(std::string_view key, std::string_view text) const;

  std::string name_;
  std::string content_;
  Syntax syntax_ = Syntax::yaml;
  std::vector<Field> fields_;  ///< views of content_
};

}  // namespace nadir::calibration

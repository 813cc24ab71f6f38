// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A calibration file as a tree of keys and values, the same whether it was YAML or XML. yaml-cpp
// and pugixml read the text; what they would let a hostile file do is bounded here. OpenCV's own
// parser is not used: it crashes on damaged files.
#pragma once

#include <string>
#include <vector>

namespace nadir::calibration {

struct Field {
  enum class Kind { scalar, sequence, mapping, alias };
  Kind kind = Kind::scalar;
  std::string key;   ///< empty in a sequence; an XML attribute's begins with '@'
  std::string text;  ///< of a scalar
  bool quoted = false;
  int line = 1;  ///< of the key, from 1
  std::vector<Field> items;
};

/// No real calibration is nested deeper; keeps what walks the tree off the end of the stack.
constexpr int kDeepest = 64;
/// No real calibration has more values; bounds the memory that 1 MB of brackets can ask for.
constexpr int kMostFields = 100'000;

/// The first document of a text. Its directives are ignored: OpenCV's "%YAML:1.0" is malformed. An
/// alias stays an alias: none is ever followed. The root is a mapping, or a scalar or sequence that
/// the caller refuses. Throws InputError "LINE: fault", without a file name.
Field parse_yaml(const std::string& text);

/// The root element of a text. Entities of a DTD are not expanded. Throws as parse_yaml.
Field parse_xml(const std::string& text);

/// Either, by its first character. expected: what the file should have been, said when it is not.
/// Throws InputError naming file, line, fault and what was expected; also for JSON.
Field parse_fields(const std::string& text, const std::string& file, const std::string& expected);

}  // namespace nadir::calibration

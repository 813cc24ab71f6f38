// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "fields.hpp"
#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

[[noreturn]] void malformed(int line, const std::string& fault) {
  throw InputError(std::to_string(line) + ": " + fault);
}

int lines_in(std::string_view text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

std::string_view first_line_of(std::string_view text) { return text.substr(0, text.find('\n')); }

// Length of "key" when the line reads "  key: value"; npos when it does not.
std::size_t key_length(std::string_view line) {
  for (std::size_t colon = line.find(':'); colon != line.npos; colon = line.find(':', colon + 1)) {
    if (colon + 1 == line.size() || kSpace.find(line[colon + 1]) != kSpace.npos) return colon;
  }
  return line.npos;
}

bool is_tag_or_blank(std::string_view text) {
  const std::size_t at = text.find_first_not_of(kSpace);
  return at == text.npos || text[at] == '!';
}

// Entries start at the indentation of the first; what is indented deeper belongs to the one before,
// and so do the dashes of a list.
std::vector<Field> split_yaml(std::string_view text, int line_number) {
  std::vector<Field> fields;
  std::size_t indentation = std::string_view::npos;
  while (!text.empty()) {
    const std::string_view line = first_line_of(text);
    const std::size_t start = line.find_first_not_of(kSpace);
    const bool blank = start == line.npos;
    if (!blank && indentation == line.npos) indentation = start;
    if (!blank && start < indentation) malformed(line_number, "wrong indentation");
    if (!blank && start == indentation && line[start] != '-') {
      const std::size_t colon = key_length(line);
      if (colon == line.npos) malformed(line_number, "expected \"key: value\"");
      fields.push_back({line.substr(start, colon - start), line.substr(colon + 1), line_number});
    } else if (!fields.empty()) {
      std::string_view& value = fields.back().text;
      value = {value.data(), static_cast<std::size_t>(line.data() + line.size() - value.data())};
    } else if (!blank) {
      malformed(line_number, "expected \"key: value\"");
    }
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    ++line_number;
  }
  return fields;
}

struct XmlTag {
  std::size_t begin = 0, end = 0;  ///< from '<' to after '>'
  std::string_view name;
  bool opens = true, closes = false;
};

XmlTag next_tag(std::string_view text, std::size_t from, int line_number) {
  XmlTag tag;
  tag.begin = text.find('<', from);
  if (tag.begin == text.npos) {
    tag.end = text.npos;
    return tag;
  }
  const std::size_t close = text.find('>', tag.begin);
  if (close == text.npos) malformed(line_number, "a tag without an end");
  tag.end = close + 1;
  std::string_view inside = text.substr(tag.begin + 1, close - tag.begin - 1);
  if (inside.starts_with('/')) {
    tag.opens = false;
    tag.closes = true;
    inside.remove_prefix(1);
  } else if (inside.ends_with('/')) {
    tag.closes = true;
    inside.remove_suffix(1);
  }
  tag.name = inside.substr(0, inside.find_first_of(kSpace));
  return tag;
}

std::vector<Field> split_xml(std::string_view text, int line_number) {
  std::vector<Field> fields;
  std::size_t at = 0;
  while (true) {
    const XmlTag open = next_tag(text, at, line_number);
    if (open.begin == text.npos) return fields;
    line_number += lines_in(text.substr(at, open.begin - at));
    if (!open.opens || open.name.empty()) malformed(line_number, "an end tag without its start");
    XmlTag close = open;
    int depth = open.closes ? 0 : 1;
    while (depth > 0) {
      close = next_tag(text, close.end, line_number);
      if (close.begin == text.npos) {
        malformed(line_number, "no </" + std::string(open.name.substr(0, 40)) + ">");
      }
      if (close.name == open.name && close.opens != close.closes) depth += close.opens ? 1 : -1;
    }
    const std::size_t length = open.closes ? 0 : close.begin - open.end;
    fields.push_back({open.name, text.substr(open.end, length), line_number});
    line_number += lines_in(text.substr(open.begin, close.end - open.begin));
    at = close.end;
  }
}

}  // namespace

std::vector<Field> split_fields(std::string_view text, int first_line, Syntax syntax) {
  if (syntax == Syntax::xml) return split_xml(text, first_line);
  // A nested value starts on the line of its key, where only a tag may stand.
  const std::string_view head = first_line_of(text);
  if (is_tag_or_blank(head)) {
    text.remove_prefix(std::min(text.size(), head.size() + 1));
    ++first_line;
  }
  return split_yaml(text, first_line);
}

}  // namespace nadir::calibration

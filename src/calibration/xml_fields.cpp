// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <pugixml.hpp>

#include "field.hpp"
#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

class TreeBuilder {
 public:
  explicit TreeBuilder(const std::string& text) : text_(text) {}

  int line(std::ptrdiff_t offset) const {
    const auto end = text_.begin() + std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text_));
    return 1 + static_cast<int>(std::count(text_.begin(), end, '\n'));
  }

  [[noreturn]] void malformed(std::ptrdiff_t offset, const std::string& fault) const {
    throw InputError(std::to_string(line(offset)) + ": " + fault);
  }

  // Elements come in the order of the text: their lines are counted onwards from the last.
  Field field(const pugi::xml_node& element, int depth) {
    const std::ptrdiff_t offset = element.offset_debug();
    if (depth > kDeepest) malformed(offset, "nested too deep");
    if (++count_ > kMostFields) malformed(offset, "too many values");
    Field field;
    field.key = element.name();
    field.line = next_line(offset);
    for (const pugi::xml_attribute& attribute : element.attributes()) {
      Field item;
      item.key = std::string("@") + attribute.name();
      item.text = attribute.value();
      item.line = field.line;
      field.items.push_back(std::move(item));
    }
    for (const pugi::xml_node& child : element.children()) {
      if (child.type() == pugi::node_element) {
        field.items.push_back(this->field(child, depth + 1));
      } else if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
        field.text += child.value();
      }
    }
    const bool blank = field.text.find_first_not_of(" \t\r\n") == std::string::npos;
    if (blank && !field.items.empty()) field.kind = Field::Kind::mapping;
    return field;
  }

 private:
  int next_line(std::ptrdiff_t offset) {
    if (offset > counted_) {
      line_ += static_cast<int>(std::count(text_.begin() + counted_, text_.begin() + offset, '\n'));
      counted_ = offset;
    }
    return line_;
  }

  const std::string& text_;
  std::ptrdiff_t counted_ = 0;
  int line_ = 1;
  int count_ = 0;
};

}  // namespace

Field parse_xml(const std::string& text) {
  TreeBuilder tree(text);
  pugi::xml_document document;
  const pugi::xml_parse_result result =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result) tree.malformed(result.offset, result.description());
  const pugi::xml_node root = document.document_element();
  for (pugi::xml_node other = root.next_sibling(); other; other = other.next_sibling()) {
    if (other.type() == pugi::node_element) {
      tree.malformed(other.offset_debug(), "a second root element");
    }
  }
  return tree.field(root, 1);
}

}  // namespace nadir::calibration

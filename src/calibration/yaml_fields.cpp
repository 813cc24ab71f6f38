// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <utility>

#include "field.hpp"
#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

[[noreturn]] void malformed(const YAML::Mark& mark, const std::string& fault) {
  throw InputError(std::to_string(std::max(mark.line, 0) + 1) + ": " + fault);
}

// yaml-cpp's events become the tree here, so that nothing is followed, copied or merged, and the
// depth is refused before yaml-cpp recurses that deep itself.
class TreeBuilder : public YAML::EventHandler {
 public:
  Field take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override {
    add(mark, leaf(Field::Kind::scalar, mark));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    add(mark, leaf(Field::Kind::alias, mark));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                const std::string& value) override {
    Field field = leaf(Field::Kind::scalar, mark);
    field.text = value;
    field.quoted = tag == "!";  // yaml-cpp's tag of what stands in quotes
    add(mark, std::move(field));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open(mark, Field::Kind::sequence);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    open(mark, Field::Kind::mapping);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    Field field;
    bool has_key = false;
    std::string key;  ///< whose value comes next, in a mapping
    int key_line = 1;
  };

  static Field leaf(Field::Kind kind, const YAML::Mark& mark) {
    Field field;
    field.kind = kind;
    field.line = std::max(mark.line, 0) + 1;
    return field;
  }

  void open(const YAML::Mark& mark, Field::Kind kind) {
    if (!open_.empty() && expects_key(open_.back())) malformed(mark, "a key that is not a word");
    if (open_.size() >= kDeepest) malformed(mark, "nested too deep");
    count(mark);
    open_.push_back({leaf(kind, mark), false, {}, 1});
  }

  void close() {
    Field field = std::move(open_.back().field);
    open_.pop_back();
    place(std::move(field));
  }

  void add(const YAML::Mark& mark, Field field) {
    count(mark);
    if (open_.empty() || !expects_key(open_.back())) return place(std::move(field));
    Open& mapping = open_.back();
    if (field.kind != Field::Kind::scalar) malformed(mark, "a key that is not a word");
    mapping.has_key = true;
    mapping.key = std::move(field.text);
    mapping.key_line = field.line;
  }

  void place(Field field) {
    if (open_.empty()) {
      root_ = std::move(field);
      return;
    }
    Open& parent = open_.back();
    if (parent.field.kind == Field::Kind::mapping) {
      field.key = std::exchange(parent.key, {});
      field.line = parent.key_line;
      parent.has_key = false;
    }
    parent.field.items.push_back(std::move(field));
  }

  void count(const YAML::Mark& mark) {
    if (++count_ > kMostFields) malformed(mark, "too many values");
  }

  static bool expects_key(const Open& open) {
    return open.field.kind == Field::Kind::mapping && !open.has_key;
  }

  Field root_;
  std::vector<Open> open_;
  int count_ = 0;
};

// Blanks, so that lines keep their numbers.
void blank_directives(std::string& text) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const char first = text[begin];
    if (first == '%') std::fill(text.begin() + long(begin), text.begin() + long(end), ' ');
    if (first != '%' && first != '#' && first != '\r' && first != '\n') return;
    begin = end + 1;
  }
}

}  // namespace

Field parse_yaml(const std::string& text) {
  std::string content = text;
  blank_directives(content);
  std::istringstream stream(content);
  TreeBuilder tree;
  try {
    YAML::Parser(stream).HandleNextDocument(tree);
  } catch (const YAML::Exception& error) {
    malformed(error.mark, error.msg);
  }
  Field root = tree.take();
  const bool nothing = root.kind == Field::Kind::scalar && root.text.empty() && !root.quoted;
  if (nothing) root.kind = Field::Kind::mapping;
  return root;
}

}  // namespace nadir::calibration

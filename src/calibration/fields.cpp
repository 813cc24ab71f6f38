// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "fields.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

using Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::size_t kMostValues = 64;
constexpr const char* kMatrixRemedy = "write it as an opencv-matrix with rows, cols and data";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::string printable(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string result(text.substr(0, kMost));
  std::replace_if(
      result.begin(), result.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  return result;
}

const Field* first_named(const Field& field, std::string_view key) {
  const auto item = std::find_if(field.items.begin(), field.items.end(),
                                 [&](const Field& candidate) { return candidate.key == key; });
  return item == field.items.end() ? nullptr : &*item;
}

std::string_view shape_of(const Field& field) {
  switch (field.kind) {
    case Field::Kind::sequence:
      return "a list";
    case Field::Kind::mapping:
      return "a mapping";
    case Field::Kind::alias:
      return "a YAML alias";
    case Field::Kind::scalar:
      break;
  }
  return "text in quotes";
}

}  // namespace

Field parse_fields(const std::string& text, const std::string& file, const std::string& expected) {
  const std::string_view start = trimmed(text);
  if (start.starts_with('{') || start.starts_with('[')) {
    throw InputError(file + ": JSON is not read; write OpenCV YAML or XML");
  }
  try {
    Field root = start.starts_with('<') ? parse_xml(text) : parse_yaml(text);
    if (root.kind == Field::Kind::mapping || start.starts_with('<')) return root;
    throw InputError(std::to_string(root.line) + ": expected \"key: value\"");
  } catch (const InputError& error) {
    throw InputError(file + ":" + error.what() + "; expected " + expected);
  }
}

Fields::Fields(const Field& mapping, std::string file, std::string path)
    : mapping_(&mapping), file_(std::move(file)), path_(std::move(path)) {}

const Field* Fields::find(std::string_view key) const {
  const Field* found = nullptr;
  for (const Field& field : mapping_->items) {
    if (field.key != key) continue;
    if (found != nullptr) fail(key, "is given twice", "delete one");
    found = &field;
  }
  return found;
}

const Field& Fields::required(std::string_view key) const {
  if (const Field* field = find(key)) return *field;
  constexpr std::size_t kMostNamed = 6;
  std::string keys;
  for (std::size_t i = 0; i < std::min(mapping_->items.size(), kMostNamed); ++i) {
    keys += (i == 0 ? "" : ", ") + printable(mapping_->items[i].key);
  }
  const std::string line = path_.empty() ? "" : ":" + std::to_string(mapping_->line);
  throw InputError(file_ + line + ": " + path_ + std::string(key) +
                   " is missing; add it (found: " + (keys.empty() ? "nothing" : keys) + ")");
}

void Fields::fail(std::string_view key, const std::string& fault, const std::string& remedy) const {
  const Field* field = first_named(*mapping_, key);
  const bool known = field != nullptr || !path_.empty();
  const std::string line =
      known ? ":" + std::to_string(field != nullptr ? field->line : mapping_->line) : "";
  throw InputError(file_ + line + ": " + path_ + std::string(key) + ": " + fault + "; " + remedy);
}

std::string Fields::key_starting_with(std::string_view prefix) const {
  const auto item = std::find_if(mapping_->items.begin(), mapping_->items.end(),
                                 [&](const Field& field) { return field.key.starts_with(prefix); });
  return item == mapping_->items.end() ? std::string() : item->key;
}

void Fields::require_opencv() const {
  if (name().empty() || name() == "opencv_storage") return;
  throw InputError(
      file_ + ":" + std::to_string(mapping_->line) + ": <" + printable(name()) +
      ">: this XML was not written by OpenCV or Metashape; export it from one of them");
}

bool Fields::is_mapping(std::string_view key) const {
  const Field* field = find(key);
  return field != nullptr && field->kind == Field::Kind::mapping;
}

bool Fields::is_sequence(std::string_view key) const {
  const Field* field = find(key);
  return field != nullptr && field->kind == Field::Kind::sequence;
}

double Fields::parse_number(std::string_view key, std::string_view text) const {
  std::string_view digits = trimmed(text);
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
    fail(key, '"' + printable(trimmed(text)) + "\" is not a finite number", "correct it");
  }
  return value;
}

double Fields::parse_number(std::string_view key, const Field& field) const {
  if (field.kind != Field::Kind::scalar || field.quoted) {
    fail(key, std::string(shape_of(field)) + " is not a finite number", "correct it");
  }
  return parse_number(key, field.text);
}

double Fields::number(std::string_view key) const { return parse_number(key, required(key)); }

int Fields::integer(std::string_view key) const {
  const double value = number(key);
  constexpr double kLargest = 1e9;
  if (value != std::floor(value) || std::abs(value) > kLargest) {
    fail(key, "is not a whole number", "correct it");
  }
  return static_cast<int>(value);
}

std::string Fields::word(std::string_view key) const {
  const Field& field = required(key);
  if (field.kind != Field::Kind::scalar) {
    fail(key, std::string(shape_of(field)) + " where a word is expected", "correct it");
  }
  return std::string(trimmed(field.text));
}

std::vector<double> Fields::parse_numbers(std::string_view key, const Field& field) const {
  std::vector<double> numbers;
  if (field.kind == Field::Kind::scalar && !field.quoted) {  // XML separates them by spaces
    std::string_view text = trimmed(field.text);
    while (!text.empty() && numbers.size() <= kMostValues) {
      const std::string_view item = text.substr(0, text.find_first_of(kSpace));
      numbers.push_back(parse_number(key, item));
      text = trimmed(text.substr(item.size()));
    }
    return numbers;
  }
  if (field.kind != Field::Kind::sequence) fail(key, "is not a list of numbers", "correct it");
  for (const Field& item : field.items) {
    numbers.push_back(parse_number(key, item));
    if (numbers.size() > kMostValues) break;
  }
  return numbers;
}

MatrixXd Fields::opencv_matrix(std::string_view key, const Field& field) const {
  const auto part = [&](std::string_view name) -> const Field& {
    if (const Field* found = first_named(field, name)) return *found;
    fail(key, "has no " + std::string(name), kMatrixRemedy);
  };
  const double rows = parse_number(key, part("rows")), columns = parse_number(key, part("cols"));
  if (!(rows >= 1 && columns >= 1 && rows * columns <= double(kMostValues))) {
    fail(key, "has an impossible size", kMatrixRemedy);
  }
  RowMajor matrix(static_cast<int>(rows), static_cast<int>(columns));
  const std::vector<double> values = parse_numbers(key, part("data"));
  if (values.size() != static_cast<std::size_t>(matrix.size())) {
    fail(key,
         "has " + std::to_string(values.size()) + " values for " + std::to_string(matrix.rows()) +
             " x " + std::to_string(matrix.cols()),
         kMatrixRemedy);
  }
  std::copy(values.begin(), values.end(), matrix.data());
  return matrix;
}

MatrixXd Fields::matrix(std::string_view key) const {
  const Field& field = required(key);
  if (field.kind == Field::Kind::mapping) return opencv_matrix(key, field);
  if (field.kind != Field::Kind::sequence) fail(key, "is not a matrix", kMatrixRemedy);
  const bool has_rows = !field.items.empty() && field.items.front().kind == Field::Kind::sequence;
  if (!has_rows) {
    const std::vector<double> column = parse_numbers(key, field);
    if (column.size() > kMostValues) fail(key, "has an impossible size", kMatrixRemedy);
    return Eigen::Map<const Eigen::VectorXd>(column.data(), std::ssize(column));
  }
  const std::size_t columns = field.items.front().items.size();
  if (columns == 0 || field.items.size() * columns > kMostValues) {
    fail(key, "has an impossible size", kMatrixRemedy);
  }
  RowMajor matrix(std::ssize(field.items), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < field.items.size(); ++i) {
    const std::vector<double> row = parse_numbers(key, field.items[i]);
    if (row.size() != columns) fail(key, "has rows of different length", kMatrixRemedy);
    std::copy(row.begin(), row.end(), matrix.row(static_cast<Eigen::Index>(i)).data());
  }
  return matrix;
}

std::vector<double> Fields::numbers(std::string_view key, std::size_t count) const {
  const RowMajor values = matrix(key);
  if (values.size() != static_cast<Eigen::Index>(count)) {
    fail(key, "has " + std::to_string(values.size()) + " values, expected " + std::to_string(count),
         "correct it");
  }
  return {values.data(), values.data() + values.size()};
}

Fields Fields::inside(std::string_view key) const {
  const Field& field = required(key);
  if (field.kind != Field::Kind::mapping) fail(key, "is not a mapping", "correct it");
  return {field, file_, path_ + std::string(key) + "."};
}

std::vector<Fields> Fields::list(std::string_view key) const {
  std::vector<Fields> mappings;
  const auto add = [&](const Field& item) {
    const std::string name = std::string(key) + "[" + std::to_string(mappings.size()) + "]";
    if (item.kind != Field::Kind::mapping) fail(key, name + " is not a mapping", "correct it");
    mappings.emplace_back(item, file_, path_ + name + ".");
  };
  for (const Field& field : mapping_->items) {
    if (field.key != key) continue;
    if (field.kind != Field::Kind::sequence) {
      add(field);
    } else {
      for (const Field& item : field.items) add(item);
    }
  }
  return mappings;
}

}  // namespace nadir::calibration

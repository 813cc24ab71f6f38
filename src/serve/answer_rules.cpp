// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "answer_rules.hpp"

#include <algorithm>
#include <charconv>

namespace nadir::serve {
namespace {

std::optional<std::uint64_t> number(std::string_view digits) {
  std::uint64_t value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<Part> part_of(std::string_view range, std::uint64_t size) {
  constexpr std::string_view kUnit = "bytes=";
  const Part whole{0, size};
  if (!range.starts_with(kUnit)) return whole;
  range.remove_prefix(kUnit.size());
  const std::size_t dash = range.find('-');
  if (dash == std::string_view::npos) return whole;
  const std::string_view from = range.substr(0, dash), to = range.substr(dash + 1);
  const auto first = number(from), last = number(to);
  if ((!from.empty() && !first) || (!to.empty() && !last) || (!first && !last)) return whole;
  if (!first) {  // the last so many
    if (*last == 0 || size == 0) return std::nullopt;
    return Part{size - std::min(*last, size), size};
  }
  if (last && *last < *first) return whole;
  if (*first >= size) return std::nullopt;
  return Part{*first, last ? std::min(*last, size - 1) + 1 : size};
}

bool is_unchanged(std::string_view if_range, std::string_view tag) {
  return if_range.empty() || (!tag.empty() && if_range == '"' + std::string(tag) + '"');
}

std::string attachment(std::string_view name) {
  std::string plain(name);
  std::ranges::replace_if(
      plain,
      [](char c) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        return !letter && !(c >= '0' && c <= '9') && c != '.' && c != '_' && c != '-';
      },
      '_');
  return "attachment; filename=\"" + plain + '"';
}

std::string error_json(std::string_view reason) {
  return "{\"error\":\"" + std::string(reason) + "\"}";
}

}  // namespace nadir::serve

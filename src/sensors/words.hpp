// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Lists in a setting.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

namespace nadir::sensors {

/// What stands between spaces and tabs.
inline std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view kSpaces = " \t";
  std::vector<std::string_view> words;
  for (std::size_t at = text.find_first_not_of(kSpaces); at != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpaces, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpaces, end);
  }
  return words;
}

}  // namespace nadir::sensors

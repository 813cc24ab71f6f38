// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Numbers for people.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace nadir {

inline std::string rounded(double value, int digits = 1) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

}  // namespace nadir

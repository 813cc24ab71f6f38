// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a check of the equipment found, for a diver to read.
#pragma once

#include <cstdint>
#include <string>

namespace nadir {

enum class Verdict : std::uint8_t {
  good,
  doubtful,  ///< the dive can go on
  bad,       ///< no map, or a wrong one
  absent,    ///< there is nothing to check
};

struct Finding {
  Verdict verdict{};
  std::string item;   ///< "camera"
  std::string found;  ///< "10.0 images a second"
  std::string remedy{};
  bool operator==(const Finding&) const = default;
};

}  // namespace nadir

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A point somebody wants to find again.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "nadir/core/time.hpp"

namespace nadir {

struct Mark {
  std::uint64_t id = 0;
  Time time = 0;
  std::optional<std::uint64_t> image{};                ///< that shows it, kept as its photograph
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< survey frame, metres or survey units
  bool removed = false;
  std::string note{};
};

}  // namespace nadir

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nadir::reference {

/// Metres per map unit, by one source.
struct ScaleMeasure {
  double ratio = 1;
  double sigma = 0;          ///< relative, 1 sigma, with what no number of images takes away
  std::uint32_t images = 0;  ///< measured
};

}  // namespace nadir::reference

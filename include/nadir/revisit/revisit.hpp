// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Known ground seen again: key frames are matched against earlier ones that should overlap, or that
// look alike in another sub-map; the map is then adjusted as a pose graph, at the end as a bundle.
// Settled key frames also tell whether the calibration fits.
// The paper (3.2) has no such stage: errors of its poses only grow, and a lost sub-map stays apart.
#pragma once

#include <cstdint>
#include <memory>

#include "nadir/core/revision.hpp"

namespace nadir::revisit {

struct Config {
  bool enabled = true;
  int gap = 8;               ///< key frames between two that count as a revisit
  int candidates = 3;        ///< earlier key frames tried for each new one
  int max_adjusted = 400;    ///< key frames in the final bundle adjustment; beyond, pose graph only
  double max_tilt_deg = 12;  ///< between two images of the same ground, where verticals are known
  /// Enabled or not: by a self-calibration where residuals call for it, a second of a desktop
  /// processor, up to four times in a dive.
  bool check_calibration = true;

  /// Throws InputError naming the key, its value and the allowed range.
  void check() const;
};

class Revisit {
 public:
  explicit Revisit(Config config);
  Revisit(Revisit&&) noexcept;
  Revisit& operator=(Revisit&&) noexcept;
  ~Revisit();

  /// Exactly one Revision per Settlement, in order. The last also adjusts every map that was seen
  /// again.
  Revision process(const Settlement& settlement);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::revisit

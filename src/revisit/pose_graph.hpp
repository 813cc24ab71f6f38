// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Poses and scales of key frames that agree best with what is known between pairs of them
// (Strasdat et al. 2010: seven degrees of freedom, because one camera's scale drifts).
#pragma once

#include <vector>

#include "nadir/core/rigid3.hpp"

namespace nadir::revisit {

struct Edge {
  int first = 0, second = 0;  ///< indices of poses
  Similarity3 second_from_first;
  double sigma_rotation = 1;     ///< radians
  double sigma_translation = 1;  ///< lengths of the second
  double sigma_scale = 1;        ///< relative
  bool robust = false;           ///< may be wrong altogether
};

/// poses: map_from_camera. Those in `fixed` stay. False, and nothing changed, when no solution is
/// better than the start.
bool optimise(std::vector<Similarity3>& poses, const std::vector<Edge>& edges,
              const std::vector<int>& fixed);

}  // namespace nadir::revisit

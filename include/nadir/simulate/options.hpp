// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What to simulate.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace nadir::simulate {

enum class SceneKind {
  pool,      ///< concrete floor with contrast plates and boxes, one strip
  transect,  ///< gravel, starfish, urchins; slow and dense as from a video; laser dots
  reef,      ///< hills and coral heads, passes of 14 m with turns
  wreck,     ///< amphorae on rippled sand, one strip, dark
};

std::string_view to_string(SceneKind scene);
/// None for a name that is not one of pool, transect, reef, wreck.
std::optional<SceneKind> scene_from(std::string_view name);

struct Options {
  SceneKind scene = SceneKind::pool;
  int images = 0;  ///< or pairs; 0: as many as the scene usually has
  bool stereo = false;
  std::uint64_t seed = 1;
  double image_scale = 1;  ///< of the camera's pixels per side, 0.1 to 4: small images for tests
  bool clear = false;      ///< no drifting particles, no sensor noise: for tests of geometry

  /// Throws InputError naming the value that cannot be simulated.
  void check() const;
};

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/simulate/options.hpp"

#include <array>
#include <string>

#include "nadir/core/check.hpp"

namespace nadir::simulate {
namespace {

constexpr std::array<std::string_view, 4> kNames{"pool", "transect", "reef", "wreck"};

}  // namespace

std::string_view to_string(SceneKind scene) { return kNames[static_cast<std::size_t>(scene)]; }

std::optional<SceneKind> scene_from(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return static_cast<SceneKind>(i);
  }
  return std::nullopt;
}

void Options::check() const {
  if (images < 0 || images > 10000) {
    throw InputError("simulate: " + std::to_string(images) +
                     " images cannot be made; give a number from 1 to 10000");
  }
  if (!(image_scale >= 0.1 && image_scale <= 4)) {
    throw InputError("simulate: image scale " + std::to_string(image_scale) +
                     " is outside 0.1 to 4; 1 is the scene's usual size");
  }
}

}  // namespace nadir::simulate

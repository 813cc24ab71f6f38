// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Scale from a length that somebody typed in: two places of an image whose distance on the ground
// is known.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "nadir/core/window.hpp"
#include "nadir/reference/scale_measure.hpp"

namespace nadir::reference {

struct KnownLength {
  std::uint64_t image = 0;
  std::array<Eigen::Vector2d, 2> pixels;  ///< of the processed image
  double metres = 0;
};

/// "IMAGE X1 Y1 X2 Y2 METRES"; none when the text is empty. Throws InputError saying what is wrong.
std::optional<KnownLength> parse_known_length(const std::string& text);

class TypedScale {
 public:
  explicit TypedScale(const KnownLength& length) : length_(length) {}

  /// Measures as soon as the image has a pose, again when that moves.
  void observe(const Orientation& orientation);

  std::optional<ScaleMeasure> estimate(std::uint32_t submap) const;

  /// Why there is no measure; empty when there is one.
  std::string fault() const;

 private:
  KnownLength length_;
  std::shared_ptr<const CameraRig> rig_;  ///< of the image, once it was seen
  bool posed_ = false;
  std::optional<std::uint32_t> submap_;
  ScaleMeasure measure_;
};

}  // namespace nadir::reference

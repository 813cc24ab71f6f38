// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/known_length.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "ground.hpp"
#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector3d;

constexpr double kPointed_px = 1;   // how well a finger finds an end, per axis
constexpr double kRuler = 0.003;    // relative, of what was typed
constexpr double kSurface = 0.005;  // relative, of the ground between tie points

}  // namespace

std::optional<KnownLength> parse_known_length(const std::string& text) {
  if (text.find_first_not_of(' ') == std::string::npos) return std::nullopt;
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  KnownLength length;
  std::string more;
  auto& [first, second] = length.pixels;
  std::int64_t image = -1;
  words >> image >> first.x() >> first.y() >> second.x() >> second.y() >> length.metres;
  length.image = static_cast<std::uint64_t>(image);
  if (!words || image < 0 || (words >> more) || !first.allFinite() || !second.allFinite()) {
    throw InputError("reference.known_length must be \"IMAGE X1 Y1 X2 Y2 METRES\", not \"" + text +
                     '"');
  }
  if (!(length.metres > 0 && length.metres <= 1000)) {
    throw InputError("reference.known_length: its metres must be more than 0, up to 1000");
  }
  constexpr double kShortest_px = 20;
  if ((first - second).norm() < kShortest_px) {
    throw InputError("reference.known_length: its ends must lie 20 px apart or more");
  }
  return length;
}

void TypedScale::observe(const Orientation& orientation) {
  if (orientation.shot && orientation.shot->image == length_.image && orientation.shot->frame) {
    rig_ = orientation.shot->frame->rig;
  }
  const auto pose = std::ranges::find(orientation.poses, length_.image, &ImagePose::image);
  if (pose == orientation.poses.end() || !rig_) return;
  posed_ = true;
  if (!orientation.window || orientation.window->submap != pose->submap) return;
  const std::vector<Seen> seen = seen_by(*pose, orientation.window->tie_points);
  std::array<Vector3d, 2> ends;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto ray = rig_->left.unproject(length_.pixels[i]);
    const auto inverse_depth = ray ? surface_at(*ray, seen) : std::nullopt;
    if (!inverse_depth) return;
    ends[i] = ray->homogeneous() / *inverse_depth;
  }
  const double length_px = (length_.pixels[0] - length_.pixels[1]).norm();
  submap_ = pose->submap;
  measure_ = {length_.metres / (ends[0] - ends[1]).norm(),
              std::hypot(std::sqrt(2.0) * kPointed_px / length_px, std::hypot(kRuler, kSurface)),
              1};
}

std::optional<ScaleMeasure> TypedScale::estimate(std::uint32_t submap) const {
  return submap_ == submap ? std::optional(measure_) : std::nullopt;
}

std::string TypedScale::fault() const {
  const std::string image = "image " + std::to_string(length_.image);
  if (submap_) return {};
  if (!rig_) return image + " was not there";
  return posed_ ? "its ends in " + image + " are not among tie points" : image + " has no pose";
}

}  // namespace nadir::reference

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace nadir::calibration {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kWidestFisheye = 240 * kDegree;

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

std::optional<Doubt> doubt(std::string fault, std::string remedy, bool about_rotation = false) {
  return Doubt{std::move(fault), std::move(remedy), about_rotation};
}

// How far the principal point is from the centre of the image, in parts of its sides.
double off_centre(const CameraModel& camera, int width, int height) {
  return std::max(std::abs(camera.cx / width - 0.5), std::abs(camera.cy / height - 0.5));
}

// Along the longer side, distortion aside.
double field_of_view(const CameraModel& camera) {
  const double half = std::max(camera.width / camera.fx, camera.height / camera.fy) / 2;
  return camera.lens == LensModel::kannala_brandt ? 2 * half : 2 * std::atan(half);
}

struct Interval {
  double from = 1, to = 0;  // empty
};

// Distances from the principal point, in focal lengths, where a fisheye images rays from the side
// and from behind, each of them once. CameraModel has no name for such rays (x/z), so these pixels
// are not used, but nothing is wrong with the calibration. At most a sixth of an image is so.
Interval radii_behind(const CameraModel& camera) {
  constexpr double kStep = kDegree / 4, kSide = 88 * kDegree, kFarthest = kWidestFisheye / 2;
  const auto& k = camera.distortion;
  const auto radius = [&](double theta) {
    const double t2 = theta * theta;
    return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  };
  double to = 0;
  for (double theta = kStep; theta <= kFarthest && radius(theta) > to; theta += kStep) {
    to = radius(theta);
  }
  return {radius(kSide), to};
}

}  // namespace

std::optional<Doubt> doubt_about_pinhole(const CameraModel& camera) {
  const auto& [fx, fy] = std::pair(camera.fx, camera.fy);
  if (!(fx > 0 && fy > 0)) {
    return doubt("focal lengths " + text(fx) + " and " + text(fy) + " px, must be positive",
                 "calibrate again");
  }
  constexpr double kMostStretched = 2;  // anamorphic video has 4 : 3
  if (fx > kMostStretched * fy || fy > kMostStretched * fx) {
    return doubt("focal lengths " + text(fx) + " and " + text(fy) + " px differ too much",
                 "calibrate again");
  }
  const bool inside = camera.cx > 0 && camera.cx < camera.width - 1 && camera.cy > 0 &&
                      camera.cy < camera.height - 1;
  if (!inside) {
    return doubt("principal point (" + text(camera.cx) + ", " + text(camera.cy) +
                     ") outside the image of " + std::to_string(camera.width) + " x " +
                     std::to_string(camera.height) + " px",
                 "check the image size, or calibrate again");
  }
  constexpr double kFar = 0.25, kNear = 0.1;  // real cameras at hand: at most 0.18, by a crop
  if (off_centre(camera, camera.width, camera.height) > kFar &&
      off_centre(camera, camera.height, camera.width) < kNear) {
    return doubt("principal point (" + text(camera.cx) + ", " + text(camera.cy) +
                     ") is that of an image of " + std::to_string(camera.height) + " x " +
                     std::to_string(camera.width) + " px, not of " + std::to_string(camera.width) +
                     " x " + std::to_string(camera.height),
                 "swap width and height");
  }
  constexpr double kNarrowest = 10 * kDegree, kWidest = 170 * kDegree;
  const double field = field_of_view(camera);
  const bool fisheye = camera.lens == LensModel::kannala_brandt;
  if (field < kNarrowest || field > (fisheye ? kWidestFisheye : kWidest)) {
    return doubt("a field of view of " + text(field / kDegree) + " degrees",
                 "check the image size and the focal length, both in px");
  }
  return std::nullopt;
}

std::optional<Doubt> doubt_about_lens(const CameraModel& camera) {
  // Polynomials often fold in the last corner, where no board was seen; more than that is wrong.
  constexpr int kCells = 32;
  constexpr double kMostFolded = 0.05;
  const bool fisheye = camera.lens == LensModel::kannala_brandt;
  const Interval behind = fisheye ? radii_behind(camera) : Interval{};
  int folded = 0;
  for (int row = 0; row <= kCells; ++row) {
    for (int column = 0; column <= kCells; ++column) {
      const Eigen::Vector2d pixel(column * (camera.width - 1.) / kCells,
                                  row * (camera.height - 1.) / kCells);
      if (camera.unproject(pixel)) continue;
      const double radius =
          std::hypot((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
      folded += radius >= behind.from && radius <= behind.to ? 0 : 1;
    }
  }
  const double share = folded / double((kCells + 1) * (kCells + 1));
  if (share <= kMostFolded) return std::nullopt;
  return doubt("the lens model has no inverse on " + text(100 * share) + " % of the image",
               "calibrate again, with images of the board up to the corners");
}

std::optional<Doubt> doubt_about_pair(const Rigid3& right_from_left) {
  constexpr double kShortest = 0.001, kLongest = 10;  // metres
  const double baseline = right_from_left.translation.norm();
  if (!(baseline >= kShortest && baseline <= kLongest)) {
    return doubt("a baseline of " + text(baseline) + " m", "give the translation in metres");
  }
  constexpr double kMostConvergent = 60 * kDegree;
  const double angle =
      std::acos(std::clamp((right_from_left.rotation * Eigen::Vector3d::UnitZ()).z(), -1., 1.));
  if (angle > kMostConvergent) {
    return doubt("the cameras look " + text(angle / kDegree) + " degrees apart",
                 "calibrate the pair again", true);
  }
  const Eigen::Vector3d right_in_left = right_from_left.inverse().translation;
  Eigen::Index axis = 0;
  right_in_left.cwiseAbs().maxCoeff(&axis);
  if (axis == 0 && right_in_left.x() < 0) {
    return doubt("the right camera lies left of the left one",
                 "the transform maps from left to right: invert it, or swap the cameras");
  }
  return std::nullopt;
}

}  // namespace nadir::calibration

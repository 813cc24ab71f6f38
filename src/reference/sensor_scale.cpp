// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/sensor_scale.hpp"

#include <algorithm>
#include <cmath>

#include "ground.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kMinImages = 5;

// What no number of images takes away: the speed of sound and what a wide beam calls the ground;
// where the altimeter sits. A pressure gauge's slope and the water's density.
constexpr double kAltitudeFloor = 0.02, kLeverArm_m = 0.05;
constexpr double kDepthFloor = 0.01;
constexpr double kUsefulSigma = 0.05;

// Neighbours in time are alike (relief, waves): so many count as one.
constexpr double kAlike = 5;

// A long dive's newest say it as well.
constexpr std::size_t kRemembered = 4096;

template <class T>
void remember(std::vector<T>& values, const T& value) {
  if (values.size() == kRemembered) values.erase(values.begin());
  values.push_back(value);
}

double independent(std::size_t values) {
  return std::max(1.0, static_cast<double>(values) / kAlike);
}

}  // namespace

// The beam looks along the vehicle's down axis.
std::optional<double> SensorScale::along_beam(const ImagePose& pose, const Frame& frame) const {
  const Vector3d beam = frame.rig->body_from_camera.conjugate() * Vector3d::UnitZ();
  if (!(beam.z() > 0.5)) return std::nullopt;  // not where the camera looks
  const Vector2d ray = beam.head<2>() / beam.z();
  const auto inverse_depth = surface_at(ray, seen_by(pose, ground_->tie_points));
  if (!inverse_depth) return std::nullopt;
  return ray.homogeneous().norm() / *inverse_depth;
}

void SensorScale::observe(const Orientation& orientation) {
  if (const Window* window = orientation.window.get()) {
    ground_ = Ground{window->submap, window->axes, window->tie_points};
  }
  const Frame* frame = orientation.shot ? orientation.shot->frame.get() : nullptr;
  if (!frame || !ground_ || !(frame->altitude || frame->depth)) return;
  const auto pose = std::ranges::find(orientation.poses, frame->image, &ImagePose::image);
  if (pose == orientation.poses.end() || pose->submap != ground_->submap) return;
  if (frame->altitude && *frame->altitude > 0) {
    if (const auto distance = along_beam(*pose, *frame)) {
      remember(altitudes_[pose->submap], {*frame->altitude + altimeter_below_camera_, *distance});
    }
  }
  if (frame->depth && ground_->axes == SurveyAxes::attitude) {
    remember(depths_[pose->submap], {*frame->depth, pose->survey_from_camera.translation.z()});
  }
}

std::optional<ScaleMeasure> SensorScale::by_altitude(std::uint32_t submap) const {
  const auto known = altitudes_.find(submap);
  if (known == altitudes_.end() || known->second.size() < kMinImages) return std::nullopt;
  const std::vector<Altitude>& altitudes = known->second;
  const auto is_first = [&](const Altitude& a) { return a.metres == altitudes.front().metres; };
  if (std::ranges::all_of(altitudes, is_first)) return std::nullopt;  // it hangs
  std::vector<double> logs, residuals, metres;
  for (const Altitude& a : altitudes) {
    if (!(a.metres > 0)) continue;
    logs.push_back(std::log(a.metres / a.distance));
    metres.push_back(a.metres);
  }
  if (logs.size() < kMinImages) return std::nullopt;
  const double middle = median(logs);
  residuals.reserve(logs.size());
  for (const double value : logs) residuals.push_back(std::abs(value - middle));
  const double spread = 1.4826 * median(residuals);
  const double floor = std::hypot(kAltitudeFloor, kLeverArm_m / median(metres));
  return ScaleMeasure{std::exp(middle),
                      std::hypot(floor, 1.25 * spread / std::sqrt(independent(logs.size()))),
                      static_cast<std::uint32_t>(logs.size())};
}

// Depth = constant - ratio z: a line through what agrees.
std::optional<ScaleMeasure> SensorScale::by_depth(std::uint32_t submap) const {
  const auto known = depths_.find(submap);
  if (known == depths_.end() || known->second.size() < kMinImages) return std::nullopt;
  const std::vector<Depth>& depths = known->second;
  std::vector<double> weights(depths.size(), 1), residuals(depths.size());
  double slope = 0, sigma = 0;
  for (int iteration = 0; iteration < 10; ++iteration) {
    double weight = 0, mean_z = 0, mean_depth = 0, squares = 0, product = 0, noise = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      weight += weights[i];
      mean_z += weights[i] * depths[i].z;
      mean_depth += weights[i] * depths[i].metres;
    }
    if (!(weight > 2)) return std::nullopt;
    mean_z /= weight;
    mean_depth /= weight;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const double z = depths[i].z - mean_z;
      squares += weights[i] * z * z;
      product += weights[i] * z * (depths[i].metres - mean_depth);
    }
    if (!(squares > 0)) return std::nullopt;
    slope = product / squares;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      residuals[i] = std::abs(depths[i].metres - mean_depth - slope * (depths[i].z - mean_z));
      noise += weights[i] * residuals[i] * residuals[i];
    }
    sigma = std::sqrt(noise / (weight - 2) / squares * kAlike);
    const double spread = std::max(1.4826 * median(residuals), 1e-9);
    for (std::size_t i = 0; i < depths.size(); ++i) {
      weights[i] = agreement_of(residuals[i], spread);
    }
  }
  if (!(slope < 0) || !(sigma < kUsefulSigma * -slope)) return std::nullopt;
  return ScaleMeasure{-slope, std::hypot(kDepthFloor, sigma / -slope),
                      static_cast<std::uint32_t>(depths.size())};
}

}  // namespace nadir::reference

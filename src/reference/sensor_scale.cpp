// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/sensor_scale.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ground.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kMinImages = 5;

// Before a sensor is called faulty: so many images, over which they moved by so much of their
// distance to the ground.
constexpr std::size_t kFaultImages = 15;
constexpr double kMoved = 0.1;
constexpr double kCoarse_m = 0.15;        // more than a sounder that tells tenths rounds away
constexpr double kAltitudeScatter = 0.2;  // relative; relief under a wide beam makes less
constexpr double kDepthScatter_m = 0.5;   // waves above a gauge make less

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

double mean_z(const std::vector<TiePoint>& points) {
  double sum = 0;
  for (const TiePoint& point : points) sum += point.x_in_survey.z();
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

double spread_about_median(const std::vector<double>& values) {
  const double middle = median(values);
  std::vector<double> residuals;
  residuals.reserve(values.size());
  for (const double value : values) residuals.push_back(std::abs(value - middle));
  return 1.4826 * median(std::move(residuals));
}

struct Line {
  double slope = 0, sigma = 0;  ///< sigma: of the slope
  double scatter = 0;           ///< of y about it, root mean square of what agrees
};

// Through what agrees.
std::optional<Line> fit_line(const std::vector<Vector2d>& points) {
  std::vector<double> weights(points.size(), 1), residuals(points.size());
  Line line;
  for (int iteration = 0; iteration < 10; ++iteration) {
    double weight = 0, squares = 0, product = 0, noise = 0;
    Vector2d mean = Vector2d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      weight += weights[i];
      mean += weights[i] * points[i];
    }
    if (!(weight > 2)) return std::nullopt;
    mean /= weight;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d from = points[i] - mean;
      squares += weights[i] * from.x() * from.x();
      product += weights[i] * from.x() * from.y();
    }
    if (!(squares > 0)) return std::nullopt;
    line.slope = product / squares;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d from = points[i] - mean;
      residuals[i] = std::abs(from.y() - line.slope * from.x());
      noise += weights[i] * residuals[i] * residuals[i];
    }
    line.scatter = std::sqrt(noise / (weight - 2));
    line.sigma = line.scatter * std::sqrt(kAlike / squares);
    const double spread = std::max(1.4826 * median(residuals), 1e-9);
    for (std::size_t i = 0; i < points.size(); ++i) {
      weights[i] = agreement_of(residuals[i], spread);
    }
  }
  return line;
}

template <class T>
std::size_t equal_at_the_end(const std::vector<T>& values) {
  const auto other = std::find_if(values.rbegin(), values.rend(), [&](const T& value) {
    return value.metres != values.back().metres;
  });
  return static_cast<std::size_t>(other - values.rbegin());
}

// Without the outermost tenths.
double range(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t tenth = values.size() / 10;
  return values[values.size() - 1 - tenth] - values[tenth];
}

// One of the newest `count` values.
template <class T>
std::vector<double> newest(const std::vector<T>& values, std::size_t count, double T::*what) {
  std::vector<double> taken;
  taken.reserve(count);
  for (std::size_t i = values.size() - count; i < values.size(); ++i) {
    taken.push_back(values[i].*what);
  }
  return taken;
}

std::string rounded(double value, int decimals) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
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
    ground_ = Ground{window->submap, window->axes, window->tie_points, mean_z(window->tie_points)};
  }
  const Frame* frame = orientation.shot ? orientation.shot->frame.get() : nullptr;
  if (!frame || !ground_ || !(frame->altitude || frame->depth)) return;
  const auto pose = std::ranges::find(orientation.poses, frame->image, &ImagePose::image);
  if (pose == orientation.poses.end() || pose->submap != ground_->submap) return;
  if (frame->altitude) without_echo_ = *frame->altitude > 0 ? 0 : without_echo_ + 1;
  if (frame->altitude && *frame->altitude > 0) {
    if (const auto distance = along_beam(*pose, *frame)) {
      remember(altitudes_[pose->submap], {*frame->altitude + altimeter_below_camera_, *distance});
    }
  }
  if (frame->depth && ground_->axes == SurveyAxes::attitude) {
    const double z = pose->survey_from_camera.translation.z();
    remember(depths_[pose->submap], {*frame->depth, z, z - ground_->z});
  }
}

std::optional<ScaleMeasure> SensorScale::by_altitude(std::uint32_t submap) const {
  const auto known = altitudes_.find(submap);
  if (altimeter_fails_) return std::nullopt;
  if (known == altitudes_.end() || known->second.size() < kMinImages) return std::nullopt;
  const std::vector<Altitude>& altitudes = known->second;
  if (equal_at_the_end(altitudes) == altitudes.size()) return std::nullopt;  // it hangs
  std::vector<double> logs, metres;
  for (const Altitude& a : altitudes) {
    if (!(a.metres > 0)) continue;
    logs.push_back(std::log(a.metres / a.distance));
    metres.push_back(a.metres);
  }
  if (logs.size() < kMinImages) return std::nullopt;
  const double sigma = 1.25 * spread_about_median(logs) / std::sqrt(independent(logs.size()));
  if (!(sigma < kUsefulSigma)) return std::nullopt;
  const double floor = std::hypot(kAltitudeFloor, kLeverArm_m / median(metres));
  return ScaleMeasure{std::exp(median(logs)), std::hypot(floor, sigma),
                      static_cast<std::uint32_t>(logs.size())};
}

// Depth = constant - ratio z.
std::optional<ScaleMeasure> SensorScale::by_depth(std::uint32_t submap) const {
  const auto known = depths_.find(submap);
  if (depth_fails_) return std::nullopt;
  if (known == depths_.end() || known->second.size() < kMinImages) return std::nullopt;
  std::vector<Vector2d> points;
  points.reserve(known->second.size());
  for (const Depth& d : known->second) points.emplace_back(d.z, d.metres);
  const auto line = fit_line(points);
  if (!line || !(line->slope < 0) || !(line->sigma < kUsefulSigma * -line->slope))
    return std::nullopt;
  return ScaleMeasure{-line->slope, std::hypot(kDepthFloor, line->sigma / -line->slope),
                      static_cast<std::uint32_t>(points.size())};
}

std::optional<SensorFault> SensorScale::altimeter_fault(std::uint32_t submap) const {
  static const std::vector<Altitude> kNone;
  const auto known = altitudes_.find(submap);
  const std::vector<Altitude>& altitudes = known == altitudes_.end() ? kNone : known->second;
  const std::string remedy =
      "check the altimeter, its clock and unit (metres); it gives the map no scale";
  if (without_echo_ >= kFaultImages) {
    return SensorFault{"altitude.csv: 0 m for " + std::to_string(without_echo_) + " images",
                       remedy};
  }
  const std::size_t same = equal_at_the_end(altitudes);
  if (same >= kFaultImages) {
    const auto distances = newest(altitudes, same, &Altitude::distance);
    const double moved = range(distances) / median(distances);
    if (!(moved > kMoved || moved * altitudes.back().metres > kCoarse_m)) return std::nullopt;
    return SensorFault{"altitude.csv: the same value in " + std::to_string(same) +
                           " images, whose distance to the ground changed by " +
                           rounded(100 * moved, 0) + " %",
                       remedy};
  }
  if (altitudes.size() < kFaultImages) return std::nullopt;
  std::vector<double> logs;
  for (std::size_t i = altitudes.size() - kFaultImages; i < altitudes.size(); ++i) {
    if (altitudes[i].metres > 0)
      logs.push_back(std::log(altitudes[i].metres / altitudes[i].distance));
  }
  const double scatter = logs.empty() ? 0 : spread_about_median(logs);
  if (!(scatter > kAltitudeScatter) || by_altitude(submap)) return std::nullopt;
  return SensorFault{"altitude.csv: scatters by " + rounded(100 * scatter, 0) +
                         " % about the distance to the ground that the images see",
                     remedy};
}

std::optional<SensorFault> SensorScale::depth_fault(std::uint32_t submap) const {
  const auto known = depths_.find(submap);
  if (known == depths_.end()) return std::nullopt;
  const std::vector<Depth>& depths = known->second;
  const std::string remedy =
      "check the depth sensor, its clock and unit (metres, positive down); it gives the map no "
      "scale";
  const std::size_t same = equal_at_the_end(depths);
  if (same >= kFaultImages) {
    const double moved = range(newest(depths, same, &Depth::z)) /
                         std::abs(median(newest(depths, same, &Depth::height)));
    if (!(moved > kMoved)) return std::nullopt;
    return SensorFault{"depth.csv: the same value in " + std::to_string(same) +
                           " images, which rose and sank by " + rounded(100 * moved, 0) +
                           " % of their distance to the ground",
                       remedy};
  }
  if (depths.size() < kFaultImages) return std::nullopt;
  std::vector<Vector2d> points;
  for (std::size_t i = depths.size() - kFaultImages; i < depths.size(); ++i) {
    points.emplace_back(depths[i].z, depths[i].metres);
  }
  const auto line = fit_line(points);
  if (!line || !(line->scatter > kDepthScatter_m) || by_depth(submap)) return std::nullopt;
  return SensorFault{"depth.csv: scatters by " + rounded(line->scatter, 1) +
                         " m about what the images see of rising and sinking",
                     remedy};
}

std::vector<SensorFault> SensorScale::new_faults(std::uint32_t submap) {
  std::vector<SensorFault> faults;
  const auto tell = [&](const auto& fault, bool& told) {
    if (!fault) return;
    faults.push_back(*fault);
    told = true;
  };
  if (!altimeter_fails_) tell(altimeter_fault(submap), altimeter_fails_);
  if (!depth_fails_) tell(depth_fault(submap), depth_fails_);
  return faults;
}

}  // namespace nadir::reference

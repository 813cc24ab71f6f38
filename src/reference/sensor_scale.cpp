// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/sensor_scale.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ground.hpp"
#include "nadir/core/rounded.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kMinImages = 5;

// Before a sensor is called faulty: so many images over so long, for those of a film are an
// instant.
constexpr std::size_t kFaultImages = 15;
constexpr Time kFaultTime = 5'000'000'000;
constexpr double kAltitudeScatter = 0.2;  // relative; relief under a wide beam makes less
constexpr double kDepthScatter_m = 0.5;   // waves above a gauge make less

// What no number of images takes away: the speed of sound and what a wide beam calls the ground;
// where the altimeter sits. A pressure gauge's slope and the water's density.
constexpr double kAltitudeFloor = 0.02, kLeverArm_m = 0.05;
constexpr double kDepthFloor = 0.01;
constexpr double kUsefulSigma = 0.05;
// Between these a camera sees ground under water: nearer than its focus and its housing, farther
// than the clearest water.
constexpr double kNearest_m = 0.1, kFarthest_m = 100;

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

double median_distance(const ImagePose& pose, const std::vector<TiePoint>& tie_points) {
  std::vector<double> distances;
  for (const Seen& point : seen_by(pose, tie_points)) distances.push_back(1 / point.inverse_depth);
  return distances.empty() ? 0 : median(std::move(distances));
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

// Value = constant + slope (z + tilt . (x, y)), through what agrees. An AHRS mounted askew and
// drift tilt the map; on a way along a slope nothing tells that from another scale.
std::optional<Line> fit_line(const std::vector<Vector3d>& positions,
                             const std::vector<double>& values) {
  // 1 sigma: 2 degrees, as an AHRS is mounted and as sheets of tie points bend.
  constexpr double kTilt = 0.035;
  std::vector<double> weights(values.size(), 1), residuals(values.size());
  Line line;
  double prior = 1e12;  // weight of there being no tilt; at first all of it
  for (int iteration = 0; iteration < 10; ++iteration) {
    double weight = 0, mean_value = 0, noise = 0;
    Vector3d mean = Vector3d::Zero();
    for (std::size_t i = 0; i < values.size(); ++i) {
      weight += weights[i];
      mean += weights[i] * positions[i];
      mean_value += weights[i] * values[i];
    }
    if (!(weight > 4)) return std::nullopt;
    mean /= weight;
    mean_value /= weight;
    Eigen::Matrix3d information = Vector3d(prior, prior, 0).asDiagonal();
    Vector3d products = Vector3d::Zero();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Vector3d from = positions[i] - mean;
      information += weights[i] * from * from.transpose();
      products += weights[i] * (values[i] - mean_value) * from;
    }
    if (!(information(2, 2) > 0)) return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix3d> solver(information);
    const Vector3d slopes = solver.solve(products);
    for (std::size_t i = 0; i < values.size(); ++i) {
      residuals[i] = std::abs(values[i] - mean_value - slopes.dot(positions[i] - mean));
      noise += weights[i] * residuals[i] * residuals[i];
    }
    line.slope = slopes.z();
    line.scatter = std::sqrt(noise / (weight - 4));
    line.sigma = line.scatter * std::sqrt(kAlike * solver.solve(Vector3d::UnitZ()).z());
    prior = kAlike * std::pow(std::max(line.scatter, 1e-6) / (kTilt * line.slope), 2);
    if (!std::isfinite(prior)) return std::nullopt;
    const double spread = std::max(1.4826 * median(residuals), 1e-9);
    for (std::size_t i = 0; i < values.size(); ++i) {
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

// The newest of them, as few as tell of a fault; none when there are not so many.
template <class T>
std::vector<T> just_enough(const std::vector<T>& values) {
  std::size_t count = std::min(kFaultImages, values.size());
  while (count > 0 && count < values.size() &&
         values.back().time - values[values.size() - count].time < kFaultTime) {
    ++count;
  }
  if (count < kFaultImages || values.back().time - values[values.size() - count].time < kFaultTime)
    return {};
  return {values.end() - static_cast<std::ptrdiff_t>(count), values.end()};
}

// The newest that are equal, while a map's drift adds up to little: 60 images, of a film 10 s.
template <class T>
std::vector<T> hanging_of(const std::vector<T>& values) {
  constexpr std::size_t kLongest = 60;
  constexpr Time kLongestTime = 10'000'000'000;
  const std::size_t same = equal_at_the_end(values);
  std::size_t count = std::min(same, kLongest);
  while (count < same &&
         values.back().time - values[values.size() - count - 1].time <= kLongestTime) {
    ++count;
  }
  if (count < kFaultImages || values.back().time - values[values.size() - count].time < kFaultTime)
    return {};
  return {values.end() - static_cast<std::ptrdiff_t>(count), values.end()};
}

// Without the outermost tenths.
double range(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t tenth = values.size() / 10;
  return values[values.size() - 1 - tenth] - values[tenth];
}

template <class T, class Value>
std::vector<Value> all_of(const std::vector<T>& values, Value T::*what) {
  std::vector<Value> taken;
  taken.reserve(values.size());
  for (const T& value : values) taken.push_back(value.*what);
  return taken;
}

// Heights without the slope that they have over the ground: a map that is tilted has one, by an
// offset of the AHRS or its mounting, or by drift. Of a vehicle that only rises, a bounded one.
std::vector<double> heave(const std::vector<Vector3d>& positions, double distance) {
  constexpr double kSteepest = 0.5;
  constexpr double kStill = 0.01;  // of the distance; less motion over the ground has no slope
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& x : positions) mean += x / static_cast<double>(positions.size());
  Eigen::Matrix2d squares = Eigen::Matrix2d::Identity() * static_cast<double>(positions.size()) *
                            std::pow(kStill * distance, 2);
  Vector2d products = Vector2d::Zero();
  for (const Vector3d& x : positions) {
    const Vector3d from = x - mean;
    squares += from.head<2>() * from.head<2>().transpose();
    products += from.z() * from.head<2>();
  }
  Vector2d slope = squares.ldlt().solve(products);
  if (slope.norm() > kSteepest) slope *= kSteepest / slope.norm();
  std::vector<double> heights;
  heights.reserve(positions.size());
  for (const Vector3d& x : positions) heights.push_back(x.z() - slope.dot((x - mean).head<2>()));
  return heights;
}

// What it gave at two images differs by nothing, or by this at least; interpolated values by less.
template <class T>
double resolution(const std::vector<T>& values) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i].metres - values[i - 1].metres);
    if (step > 1e-9) smallest = std::min(smallest, step);
  }
  return std::isfinite(smallest) ? smallest : 0;
}

// So much that a gauge must have told of it; a map without metres leaves more in doubt.
bool has_moved(double heave, double distance, bool metric, double resolution) {
  constexpr double kMoved = 0.1, kMovedUnscaled = 0.25;  // of the distance to the ground
  constexpr double kMoved_m = 0.5, kSteps = 3;
  if (!(distance > 0)) return false;
  if (!metric) return heave > kMovedUnscaled * distance;
  return heave > kMoved * distance && heave > std::max(kMoved_m, kSteps * resolution);
}

// How much depth grows with each unit upwards, when it surely does: of a gauge that counts the
// other way. Looked at now and then, for it takes all of the dive's values.
template <class Depths>
std::optional<double> upward(const Depths& depths) {
  constexpr double kSure = 10;       // sigma; waves and pitch make values alike for long
  constexpr double kLeast_m = 0.25;  // that the gauge has told
  constexpr double kLeastMetric = 0.5;
  if (depths.size() % kFaultImages != 0 || just_enough(depths).empty()) return std::nullopt;
  const auto positions = all_of(depths, &Depths::value_type::position);
  const auto line = fit_line(positions, all_of(depths, &Depths::value_type::metres));
  if (!line || !(line->slope > kSure * line->sigma)) return std::nullopt;
  const double distance = median(all_of(depths, &Depths::value_type::distance));
  const double moved = range(heave(positions, distance));
  const bool metric = depths.back().metric;
  const double steps = resolution(depths);
  if (!has_moved(moved, distance, metric, steps)) return std::nullopt;
  if (!(line->slope * moved > kLeast_m) || (metric && line->slope < kLeastMetric))
    return std::nullopt;
  return line->slope;
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
    ground_ = Ground{window->submap, window->axes, window->tie_points,
                     window->scale.source != ScaleSource::none};
  }
  const Frame* frame = orientation.shot ? orientation.shot->frame.get() : nullptr;
  if (!frame || !ground_ || !(frame->altitude || frame->depth)) return;
  const auto pose = std::ranges::find(orientation.poses, frame->image, &ImagePose::image);
  if (pose == orientation.poses.end() || pose->submap != ground_->submap) return;
  if (frame->altitude) hear(*frame->altitude > 0, frame->time);
  if (frame->altitude && *frame->altitude > 0) {
    if (const auto distance = along_beam(*pose, *frame)) {
      remember(altitudes_[pose->submap],
               {*frame->altitude + altimeter_below_camera_, *distance, frame->time});
    }
  }
  if (frame->depth && ground_->axes == SurveyAxes::attitude && !without_vertical_) {
    remember(depths_[pose->submap],
             {*frame->depth, pose->survey_from_camera.translation,
              median_distance(*pose, ground_->tie_points), ground_->metric, frame->time});
  }
}

void SensorScale::hear(bool echo, Time time) {
  if (echo) {
    without_echo_ = 0;
    return;
  }
  if (without_echo_++ == 0) silent_since_ = time;
  silent_ = time - silent_since_;
}

void SensorScale::forget_vertical() {
  without_vertical_ = true;
  depths_.clear();
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
  const double height = median(metres), told = height - altimeter_below_camera_;
  if (!(sigma < kUsefulSigma) || !(told > kNearest_m && told < kFarthest_m)) return std::nullopt;
  const double floor = std::hypot(kAltitudeFloor, kLeverArm_m / height);
  return ScaleMeasure{std::exp(median(logs)), std::hypot(floor, sigma),
                      static_cast<std::uint32_t>(logs.size())};
}

// Depth = constant - ratio z.
std::optional<ScaleMeasure> SensorScale::by_depth(std::uint32_t submap) const {
  const auto known = depths_.find(submap);
  if (depth_fails_) return std::nullopt;
  if (known == depths_.end() || known->second.size() < kMinImages) return std::nullopt;
  const auto line =
      fit_line(all_of(known->second, &Depth::position), all_of(known->second, &Depth::metres));
  if (!line || !(line->slope < 0) || !(line->sigma < kUsefulSigma * -line->slope))
    return std::nullopt;
  return ScaleMeasure{-line->slope, std::hypot(kDepthFloor, line->sigma / -line->slope),
                      static_cast<std::uint32_t>(known->second.size())};
}

std::optional<SensorFault> SensorScale::altimeter_fault(std::uint32_t submap) const {
  constexpr double kCoarse_m = 0.15;  // more than a sounder that tells tenths rounds away
  constexpr double kSlight = 0.03;    // relief under a beam changes as much
  const auto known = altitudes_.find(submap);
  if (known == altitudes_.end()) return std::nullopt;
  const std::vector<Altitude>& altitudes = known->second;
  const auto fault = [](std::string message) {
    return SensorFault{
        ScaleSource::altitude, "altitude.csv: " + std::move(message),
        "check the altimeter, its clock and unit (metres); it gives no scale from here on"};
  };
  if (const auto hanging = hanging_of(altitudes); !hanging.empty()) {
    const auto distances = all_of(hanging, &Altitude::distance);
    const double moved = range(distances) / median(distances);
    if (!(moved * altitudes.back().metres > kCoarse_m && moved > kSlight)) return std::nullopt;
    return fault("the same value in " + std::to_string(hanging.size()) +
                 " images, whose distance to the ground changed by " + rounded(100 * moved, 0) +
                 " %");
  }
  std::vector<double> logs, metres;
  for (const Altitude& a : just_enough(altitudes)) {
    if (!(a.metres > 0)) continue;
    logs.push_back(std::log(a.metres / a.distance));
    metres.push_back(a.metres);
  }
  if (const double height = metres.empty() ? 1 : median(metres) - altimeter_below_camera_;
      !(height > kNearest_m && height < kFarthest_m)) {
    return fault(rounded(height, height < 1 ? 3 : 0) +
                 " m to the ground, of which images under water would show nothing");
  }
  const double scatter = logs.empty() ? 0 : spread_about_median(logs);
  if (!(scatter > kAltitudeScatter) || by_altitude(submap)) return std::nullopt;
  return fault("scatters by " + rounded(100 * scatter, 0) +
               " % about the distance to the ground that the images see");
}

std::optional<SensorFault> SensorScale::depth_fault(std::uint32_t submap) const {
  const auto known = depths_.find(submap);
  if (known == depths_.end()) return std::nullopt;
  const std::vector<Depth>& depths = known->second;
  const auto fault = [](std::string message) {
    return SensorFault{ScaleSource::depth, "depth.csv: " + std::move(message),
                       "check the depth sensor, its clock and unit (metres, positive down); it "
                       "gives no scale from here on"};
  };
  if (const auto hanging = hanging_of(depths); !hanging.empty()) {
    const double distance = median(all_of(hanging, &Depth::distance));
    const double moved = range(heave(all_of(hanging, &Depth::position), distance));
    if (!has_moved(moved, distance, hanging.back().metric, resolution(depths))) return std::nullopt;
    return fault("the same value in " + std::to_string(hanging.size()) +
                 " images, which rose and sank by " + rounded(100 * moved / distance, 0) +
                 " % of their distance to the ground");
  }
  if (const auto slope = upward(depths)) {
    return fault("grows while the images rise, by " + rounded(*slope, 2) +
                 " m for each unit of the map");
  }
  const auto newest = just_enough(depths);
  const auto line = fit_line(all_of(newest, &Depth::position), all_of(newest, &Depth::metres));
  if (!line || !(line->scatter > kDepthScatter_m) || by_depth(submap)) return std::nullopt;
  return fault("scatters by " + rounded(line->scatter, 1) +
               " m about what the images see of rising and sinking");
}

// Altitudes of 0 condemn none: far from the ground a good altimeter tells them too.
std::optional<SensorFault> SensorScale::echo_fault() const {
  if (without_echo_ < kFaultImages || silent_ < kFaultTime) return std::nullopt;
  return SensorFault{ScaleSource::none,
                     "altitude.csv: 0 m for " + std::to_string(without_echo_) + " images",
                     "check the altimeter, its range and where it looks; it gives no scale until "
                     "it hears the ground"};
}

std::vector<SensorFault> SensorScale::new_faults(std::uint32_t submap) {
  std::vector<SensorFault> faults;
  const auto tell = [&](const std::optional<SensorFault>& fault, bool& told) {
    if (!fault) return;
    faults.push_back(*fault);
    told = true;
  };
  if (!echo_told_) tell(echo_fault(), echo_told_);
  if (!altimeter_fails_) tell(altimeter_fault(submap), altimeter_fails_);
  if (!depth_fails_) tell(depth_fault(submap), depth_fails_);
  return faults;
}

}  // namespace nadir::reference

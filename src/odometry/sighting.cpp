// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sighting.hpp"

#include <algorithm>
#include <cmath>

#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d, Eigen::Vector3d;

constexpr double kMinCorrelation = 0.80;
constexpr double kSure = 0.92;                    // no search around the expected place is needed
constexpr double kMinEpipolarCorrelation = 0.80;  // no pose speaks for the place along the line
constexpr double kAmbiguous = 0.93;               // of the best correlation
constexpr int kMaxSteps = 800;

}  // namespace

std::optional<Matrix2d> local_affine(const CameraModel& host, const Rigid3& host_from_map,
                                     const Vector2d& host_pixel, const Vector3d& x_in_map,
                                     const Vector3d& normal_in_map, const CameraModel& target,
                                     const Rigid3& target_from_map) {
  constexpr double kStep = 4.0;  // px
  const Vector3d normal = host_from_map.rotation * normal_in_map;
  const double offset = normal.dot(host_from_map * x_in_map);
  const Rigid3 target_from_host = target_from_map * host_from_map.inverse();
  const auto centre = target.project(target_from_map * x_in_map);
  if (!centre) return std::nullopt;
  Matrix2d affine;
  for (int axis = 0; axis < 2; ++axis) {
    const auto ray = host.unproject(host_pixel + kStep * Vector2d::Unit(axis));
    if (!ray) return std::nullopt;
    const double depth = offset / normal.dot(ray->homogeneous());
    if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
    const auto pixel = target.project(target_from_host * (depth * ray->homogeneous()));
    if (!pixel) return std::nullopt;
    affine.col(axis) = (*pixel - *centre) / kStep;
  }
  return affine;
}

std::optional<Sight> sight(const Map& map, const MapPoint& point, const Looking& image, int radius,
                           std::optional<Vector2d> start) {
  const KeyFrame& host = map.key_frame(point.host);
  const auto affine =
      local_affine(map.rig->left, host.camera_from_map, point.host_pixel.cast<double>(), point.x,
                   point.normal, image.camera, image.camera_from_map);
  if (!affine) return std::nullopt;
  if (!start) start = image.camera.project(image.camera_from_map * point.x);
  if (!start) return std::nullopt;
  const auto wanted = warp_patch(point.patch, *affine);
  if (!wanted) return std::nullopt;
  auto near = refine(*wanted, image.grey, *start);
  if (near && near->correlation > kSure) return near;
  const Sight coarse = search(*wanted, image.grey, *start, radius);
  if (coarse.correlation < kMinCorrelation - 0.2) return std::nullopt;
  auto fine = refine(*wanted, image.grey, coarse.pixel);
  if (!fine || fine->correlation < kMinCorrelation) return std::nullopt;
  return fine;
}

std::optional<Placed> search_epipolar_line(const Unplaced& point, const CameraModel& host,
                                           const CameraModel& target,
                                           const Rigid3& target_from_host, const cv::Mat& grey,
                                           int across) {
  const Vector3d far = target_from_host.rotation * point.ray.homogeneous();
  const auto place = [&](double inverse_depth) {
    return target.project(far + inverse_depth * target_from_host.translation);
  };
  const double middle = 0.5 * (point.inverse_depth_min + point.inverse_depth_max);
  const auto affine = local_affine(host, {}, point.pixel, point.ray.homogeneous() / middle,
                                   point.normal_in_host, target, target_from_host);
  if (!affine) return std::nullopt;
  const auto wanted = warp_patch(point.patch, *affine);
  const auto one = place(point.inverse_depth_min), other = place(point.inverse_depth_max);
  if (!wanted || !one || !other) return std::nullopt;
  const double length = (*other - *one).norm();
  if (!(length < kMaxSteps)) return std::nullopt;
  const int steps = static_cast<int>(length) + 2;
  const Vector2d side =
      length > 1 ? Vector2d(-(*other - *one).y(), (*other - *one).x()) / length : Vector2d(0, 1);
  std::vector<float> correlations;
  Sight best{{}, -1};
  int best_step = 0;
  for (int i = 0; i <= steps; ++i) {
    const double inverse_depth =
        point.inverse_depth_min +
        (point.inverse_depth_max - point.inverse_depth_min) * i / static_cast<double>(steps);
    const auto pixel = place(inverse_depth);
    correlations.push_back(-1);
    if (!pixel) continue;
    for (int k = -across; k <= across; ++k) {
      const Vector2d at = *pixel + k * side;
      const float c = correlation(*wanted, grey, static_cast<int>(std::lround(at.x())),
                                  static_cast<int>(std::lround(at.y())));
      correlations.back() = std::max(correlations.back(), c);
      if (c > best.correlation) best = {{std::round(at.x()), std::round(at.y())}, c}, best_step = i;
    }
  }
  if (best.correlation < kMinEpipolarCorrelation - 0.2) return std::nullopt;
  for (int i = 0; i <= steps; ++i) {
    if (std::abs(i - best_step) > 4 &&
        correlations[static_cast<std::size_t>(i)] > kAmbiguous * best.correlation)
      return std::nullopt;
  }
  const auto fine = refine(*wanted, grey, best.pixel);
  if (!fine || fine->correlation < kMinEpipolarCorrelation) return std::nullopt;
  const auto ray = target.unproject(fine->pixel);
  if (!ray) return std::nullopt;
  return Placed{*fine, *ray,
                point.inverse_depth_min + (point.inverse_depth_max - point.inverse_depth_min) *
                                              best_step / static_cast<double>(steps)};
}

}  // namespace nadir::odometry

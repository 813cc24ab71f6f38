// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "resection.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <utility>

#include "matching.hpp"
#include "nadir/odometry/bundle_adjustment.hpp"
#include "relative_orientation.hpp"
#include "sighting.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kMinFeatures = 60;
constexpr int kMinCoarse = 12;     // points of a rough pose
constexpr int kSureCoarse = 25;    // corners that make a relative orientation worth a try
constexpr int kMinLengths = 6;     // points that agree on the distance between two images
constexpr int kSureRelative = 40;  // corners that make fewer tie points enough
constexpr int kMinTiePointsOfRelative = 8;
constexpr int kMinTiePointsOfBlobs = 12;
constexpr int kMinTiePoints = 20;       // sub-pixel, of an accepted pose
constexpr double kMinShareSeen = 0.15;  // of the expected ones, where the motion so far leads
constexpr double kMinShareFar = 0.5;    // far from there, or after a loss
constexpr double kCoarseTolerance_px = 4.0;
constexpr double kFineTolerance_px = 2.0;
constexpr double kRatio = 0.85;

struct Rough {
  Rigid3 camera_from_map;
  int inliers = 0;
  int corners = 0;  ///< that agree on the relative orientation to a key frame
  int blobs = 0;    ///< or so many
};

Rough resect_points(const std::vector<Vector3d>& points, const Rays& rays,
                    const CameraModel& camera) {
  Rough rough;
  if (static_cast<int>(points.size()) < kMinCoarse) return rough;
  std::vector<cv::Point3d> x;
  std::vector<cv::Point2d> u;
  x.reserve(points.size());
  u.reserve(rays.size());
  for (const auto& p : points) x.emplace_back(p.x(), p.y(), p.z());
  for (const auto& r : rays) u.emplace_back(r.x(), r.y());
  cv::Mat rotation, translation, matrix;
  std::vector<int> inliers;
  const bool found =
      cv::solvePnPRansac(x, u, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotation, translation,
                         false, 400, static_cast<float>(kCoarseTolerance_px / camera.mean_focal()),
                         0.999, inliers, cv::SOLVEPNP_AP3P);
  if (!found || static_cast<int>(inliers.size()) < kMinCoarse) return rough;
  cv::Rodrigues(rotation, matrix);
  Eigen::Matrix3d r;
  cv::cv2eigen(matrix, r);
  Rigid3 pose{Eigen::Quaterniond(r).normalized(), {}};
  cv::cv2eigen(translation, pose.translation);
  if (!pose.is_finite()) return rough;

  Adjustment a;
  a.images = {{pose, false}};
  for (const int i : inliers) {
    const auto k = static_cast<std::size_t>(i);
    a.observations.push_back({0, static_cast<int>(a.points.size()), false, rays[k]});
    a.points.push_back({points[k], true});
  }
  CameraRig rig;
  rig.left = camera;
  if (!adjust(a, rig, {2.0, 10, 1e-5}).usable) return rough;
  rough.camera_from_map = a.images[0].camera_from_map;
  rough.inliers = static_cast<int>(
      std::count_if(a.observations.begin(), a.observations.end(),
                    [](const auto& o) { return o.error_px < kCoarseTolerance_px; }));
  return rough;
}

Rough resect_pairs(const Map& map, const std::vector<int>& points, const Pairs& pairs,
                   const View& view) {
  std::vector<Vector3d> x;
  Rays rays;
  for (const auto& [i, k] : pairs) {
    x.push_back(map.point(points[static_cast<std::size_t>(i)]).x);
    rays.push_back(view.features.rays[static_cast<std::size_t>(k)]);
  }
  return resect_points(x, rays, view.camera());
}

cv::Mat descriptors_of(const Map& map, const std::vector<int>& points) {
  cv::Mat rows(static_cast<int>(points.size()), 32, CV_8U);
  for (int i = 0; i < rows.rows; ++i) {
    const auto& d = map.point(points[static_cast<std::size_t>(i)]).descriptor;
    std::copy(d.begin(), d.end(), rows.ptr(i));
  }
  return rows;
}

// Tie points near where the motion so far puts them.
Rough by_prediction(const Map& map, const View& view, const Rigid3& predicted) {
  constexpr double kRadius = 0.06;  // of the image width
  constexpr int kMaxDistance = 64;  // bits of 256
  std::vector<int> points;
  std::vector<Vector2d> places;
  for (const auto& e : expected_points(map, predicted, 600)) {
    points.push_back(e.point);
    places.push_back(e.pixel);
  }
  if (points.empty()) return {};
  const auto pairs = match_near(descriptors_of(map, points), places, view.features,
                                kRadius * view.camera().width, kMaxDistance);
  return resect_pairs(map, points, pairs, view);
}

// Tie points of the reference key frames wherever they are.
Rough by_descriptors(const Map& map, const View& view, std::span<const int> references) {
  std::vector<int> points;
  for (const int k : references) {
    points.insert(points.end(), map.key_frame(k).points.begin(), map.key_frame(k).points.end());
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  const auto pairs =
      match_descriptors(descriptors_of(map, points), view.features.descriptors, kRatio);
  return resect_pairs(map, points, pairs, view);
}

// The distance between two cameras of known relative orientation from points of known depth in the
// first: median of each point's own answer, with the number of points that agree within a fifth.
std::pair<double, int> length_of(const Rigid3& direction, const std::vector<Vector3d>& x_in_first,
                                 const Rays& second) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < x_in_first.size(); ++i) {
    const Vector3d ray = second[i].homogeneous();
    const Vector3d across = direction.translation.cross(ray);
    const double length =
        -(direction.rotation * x_in_first[i]).cross(ray).dot(across) / across.squaredNorm();
    if (std::isfinite(length) && length > 0) lengths.push_back(length);
  }
  if (lengths.empty()) return {0, 0};
  std::sort(lengths.begin(), lengths.end());
  const double length = lengths[lengths.size() / 2];
  const auto agree = std::count_if(lengths.begin(), lengths.end(),
                                   [&](double l) { return std::abs(l - length) < 0.2 * length; });
  return {length, static_cast<int>(agree)};
}

// All features of a reference key frame give the relative orientation; its tie points the length.
std::vector<Rough> by_relative_orientation(const Map& map, const KeyFrame& reference,
                                           const Features& of_reference, const Features& of_view,
                                           const CameraModel& camera) {
  constexpr double kNear_px = 30;
  std::vector<Rough> found;
  const auto matched = correspond(of_reference, of_view, camera);
  if (static_cast<int>(matched.pairs.size()) < kSureCoarse) return found;
  std::vector<Vector2d> tie_points;
  for (const int i : reference.points) {
    tie_points.push_back((reference.camera_from_map * map.point(i).x).hnormalized());
  }
  const DepthPrior prior = depth_prior(map, reference);
  Rays first, second, second_of_known;
  std::vector<Vector3d> known;
  for (const auto& [i, k] : matched.pairs) {
    const Vector2d& ray = of_reference.rays[static_cast<std::size_t>(i)];
    first.push_back(ray);
    second.push_back(of_view.rays[static_cast<std::size_t>(k)]);
    const bool near = std::any_of(tie_points.begin(), tie_points.end(), [&](const Vector2d& t) {
      return (t - ray).norm() * camera.mean_focal() < kNear_px;
    });
    if (!near || !prior.known()) continue;
    known.emplace_back(ray.homogeneous() / prior.at(ray).inverse_depth);
    second_of_known.push_back(second.back());
  }
  const double sigma = corner_sigma(camera);
  for (const auto& o : relative_orientations(first, second, camera, sigma)) {
    const auto [length, agree] = length_of(o.second_from_first, known, second_of_known);
    if (agree < kMinLengths) continue;
    Rigid3 step = o.second_from_first;
    step.translation *= length;
    found.push_back({step * reference.camera_from_map, o.inliers, o.inliers});
  }
  return found;
}

Adjustment pose_only(const Map& map, const Rigid3& start, const std::vector<Seen>& seen) {
  Adjustment a;
  a.images = {{start, false}};
  for (const Seen& s : seen) {
    a.observations.push_back({0, static_cast<int>(a.points.size()), false, s.ray});
    a.points.push_back({map.point(s.point).x, true});
  }
  return a;
}

std::optional<Resection> measure(const Map& map, const View& view, const Rigid3& rough, int radius,
                                 int points) {
  Resection result;
  const Looking image{view.frame->grey, view.camera(), rough};
  const auto expected = expected_points(map, rough, points);
  result.expected = static_cast<int>(expected.size());
  for (const auto& e : expected) {
    const auto found = sight(map, map.point(e.point), image, radius, e.pixel);
    if (!found) continue;
    const auto ray = view.camera().unproject(found->pixel);
    if (ray) result.seen.push_back({e.point, found->pixel, *ray});
  }
  if (static_cast<int>(result.seen.size()) < kMinTiePointsOfRelative) return std::nullopt;
  Adjustment a = pose_only(map, rough, result.seen);
  const auto summary = adjust(a, *map.rig, {1.0, 15, 1e-5});
  if (!summary.usable) return std::nullopt;
  std::vector<Seen> kept;
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    if (a.observations[i].error_px < kFineTolerance_px) kept.push_back(result.seen[i]);
  }
  result.seen = std::move(kept);
  result.camera_from_map = a.images[0].camera_from_map;
  result.rms_px = summary.rms_px;
  return result;
}

// Other ground may look alike in a part of the image: the farther a pose is from the predicted one,
// the more of what it should see must be seen. Poses of one piece see half and more even there.
double share_needed(const Map& map, const Resection& r, const std::optional<Rigid3>& predicted,
                    Effort effort) {
  constexpr double kNear = 0.15, kFar = 0.35;  // of the distance to the ground
  if (!predicted) return effort == Effort::thorough ? kMinShareFar : kMinShareSeen;
  const Vector3d step = r.camera_from_map.inverse().translation - predicted->inverse().translation;
  const double away = step.norm() / map.last().depth;
  const double part = std::clamp((away - kNear) / (kFar - kNear), 0.0, 1.0);
  return kMinShareSeen + part * (kMinShareFar - kMinShareSeen);
}

bool acceptable(const Resection& r, const Rough& rough, double min_share) {
  const int wanted = rough.corners >= kSureRelative ? kMinTiePointsOfRelative
                     : rough.blobs >= kSureRelative ? kMinTiePointsOfBlobs
                                                    : kMinTiePoints;
  return static_cast<int>(r.seen.size()) >= wanted &&
         static_cast<double>(r.seen.size()) >= min_share * r.expected;
}

std::optional<Resection> sharpen(const Map& map, const View& view, const Rough& rough,
                                 const std::optional<Rigid3>& predicted, const Config& config,
                                 Effort effort) {
  if (rough.inliers < kMinCoarse) return std::nullopt;
  // The wide search only has to bring the pose within the narrow one.
  constexpr int kFew = 100;
  constexpr std::size_t kEnough = 40;  // twice what an accepted pose needs
  auto result = measure(map, view, rough.camera_from_map, 6, std::max(kFew, config.tie_points / 3));
  if (!result || result->seen.size() < kEnough)
    result = measure(map, view, rough.camera_from_map, 6, config.tie_points);
  if (!result) return result;
  auto again = measure(map, view, result->camera_from_map, 2, config.tie_points);
  if (!again || !acceptable(*again, rough, share_needed(map, *again, predicted, effort)))
    return std::nullopt;
  return again;
}

}  // namespace

Sigmas sigmas_of(const Map& map, const Resection& resection) {
  Adjustment a = pose_only(map, resection.camera_from_map, resection.seen);
  constexpr double kRobust_px = 1;
  if (!adjust(a, *map.rig, {kRobust_px, 2, 1e-5}).usable) return {};
  const auto covariance = PoseCovariance::of(a, *map.rig, kRobust_px);
  return covariance ? sigmas_of(covariance->of_image(0)) : Sigmas{};
}

bool is_blank(const View& view) { return view.features.size() < kMinFeatures; }

LossReason reason_without_matches(const View& view) {
  // Variance of the Laplacian of white noise of 2 grey levels, halved by the averaging of 2 x 2
  // pixels: 20 (2 / 2)^2. Blinded images have 3 to 16, the dimmest seabed tracked so far 60.
  constexpr double kOfNoise = 20;
  const bool nothing = is_blank(view) || view.sharpness < kOfNoise;
  return nothing ? LossReason::blank_image : LossReason::too_large_motion;
}

ResectionResult resect(const Map& map, const View& view, std::optional<Rigid3> predicted,
                       std::span<const int> references, const Config& config, Effort effort) {
  ResectionResult result;
  if (is_blank(view)) {
    result.reason = LossReason::blank_image;
    return result;
  }
  Rough best;
  const auto attempt = [&](const Rough& rough) {
    best.inliers = std::max(best.inliers, rough.inliers);
    result.resection = sharpen(map, view, rough, predicted, config, effort);
    return result.resection.has_value();
  };
  if (predicted && attempt(by_prediction(map, view, *predicted))) return result;
  if (attempt(by_descriptors(map, view, references))) return result;
  for (const int k : references) {
    const KeyFrame& reference = map.key_frame(k);
    for (const Rough& rough : by_relative_orientation(map, reference, reference.features,
                                                      view.features, view.camera())) {
      if (attempt(rough)) return result;
    }
  }
  if (const KeyFrame& last = map.last(); effort == Effort::thorough && last.view) {
    const Features of_last = describe_blobs(last.view->frame->grey, view.camera());
    const Features of_view = describe_blobs(view.frame->grey, view.camera());
    for (Rough rough : by_relative_orientation(map, last, of_last, of_view, view.camera())) {
      rough.blobs = std::exchange(rough.corners, 0);
      if (attempt(rough)) return result;
    }
  }
  result.reason =
      best.inliers >= kMinCoarse ? LossReason::too_few_matches : reason_without_matches(view);
  return result;
}

}  // namespace nadir::odometry

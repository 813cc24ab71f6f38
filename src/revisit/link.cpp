// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "link.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "nadir/odometry/bundle_adjustment.hpp"
#include "nadir/odometry/correspondence.hpp"

namespace nadir::revisit {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kMinPairs = 25;
constexpr int kMinInliers = 20;
constexpr double kTolerance_px = 4;  // a corner's own error, and that of its guessed depth
constexpr double kMinSpread = 0.06;  // of the image's sides, standard deviation of the corners
// Other ground may hold the same thing, a print or a tile: links by one have 0.2 to 0.44, others
// from 0.46 on and nearly all above 0.6.
constexpr double kMinCoverage = 0.5;
constexpr double kMaxScaleSpread = 0.08;  // median deviation of the corners' scales

struct Common {
  std::vector<Vector2d> first;  // rays
  std::vector<Vector3d> x_in_first;
  std::vector<Vector2d> rays;  // in the second
};

Common common_features(const Node& first, const Features& of_first, const Features& of_second) {
  Common common;
  for (const auto& [i, k] : odometry::correspond(of_first, of_second, first.rig->left).pairs) {
    const Vector2d& ray = of_first.rays[static_cast<std::size_t>(i)];
    common.first.push_back(ray);
    common.x_in_first.emplace_back(ray.homogeneous() / first.prior.at(ray).inverse_depth);
    common.rays.push_back(of_second.rays[static_cast<std::size_t>(k)]);
  }
  return common;
}

std::optional<Rigid3> rough_pose(const Common& common, double focal) {
  std::vector<cv::Point3d> x;
  std::vector<cv::Point2d> u;
  x.reserve(common.x_in_first.size());
  u.reserve(common.rays.size());
  for (const auto& p : common.x_in_first) x.emplace_back(p.x(), p.y(), p.z());
  for (const auto& r : common.rays) u.emplace_back(r.x(), r.y());
  cv::Mat rotation, translation, matrix, inliers;
  const bool found = cv::solvePnPRansac(
      x, u, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotation, translation, false, 300,
      static_cast<float>(kTolerance_px / focal), 0.999, inliers, cv::SOLVEPNP_AP3P);
  if (!found || inliers.rows < kMinInliers) return std::nullopt;
  cv::Rodrigues(rotation, matrix);
  Eigen::Matrix3d r;
  cv::cv2eigen(matrix, r);
  Rigid3 pose{Eigen::Quaterniond(r).normalized(), {}};
  cv::cv2eigen(translation, pose.translation);
  return pose.is_finite() ? std::optional(pose) : std::nullopt;
}

// The second camera from the first, in the first's lengths; keeps in `common` what agrees.
std::optional<Rigid3> refined_pose(const Rigid3& rough, const Node& second, Common& common) {
  odometry::Adjustment a;
  a.images = {{rough, false}};
  for (std::size_t i = 0; i < common.rays.size(); ++i) {
    a.points.push_back({common.x_in_first[i], true});
    a.observations.push_back({0, static_cast<int>(i), false, common.rays[i]});
  }
  CameraRig rig;
  rig.left = second.rig->left;
  if (!odometry::adjust(a, rig, {2.0, 15, 1e-5}).usable) return std::nullopt;
  Common kept;
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    if (!(a.observations[i].error_px < kTolerance_px)) continue;
    kept.first.push_back(common.first[i]);
    kept.x_in_first.push_back(common.x_in_first[i]);
    kept.rays.push_back(common.rays[i]);
  }
  common = std::move(kept);
  return a.images[0].camera_from_map;
}

bool is_spread(const std::vector<Vector2d>& rays, const CameraModel& camera) {
  Vector2d mean = Vector2d::Zero(), squares = Vector2d::Zero();
  for (const auto& r : rays) mean += r / static_cast<double>(rays.size());
  for (const auto& r : rays) squares += (r - mean).cwiseAbs2() / static_cast<double>(rays.size());
  return std::sqrt(squares.x()) > kMinSpread * camera.width / camera.fx &&
         std::sqrt(squares.y()) > kMinSpread * camera.height / camera.fy;
}

// How much of the ground that both images should show the common features cover, as a ratio of what
// as many would if they lay anywhere on it.
double coverage(const Node& first, const Rigid3& second_from_first, const CameraModel& second,
                const Common& common) {
  constexpr int kCells = 8;  // across and down
  const CameraModel& camera = first.rig->left;
  std::array<char, std::size_t{kCells} * kCells> shared{}, covered{};
  const auto cell_of = [&](const Vector2d& pixel) {
    const auto part = [](double at, int size) {
      return static_cast<std::size_t>(std::clamp(at * kCells / size, 0.0, kCells - 1.0));
    };
    return part(pixel.y(), camera.height) * kCells + part(pixel.x(), camera.width);
  };
  for (int i = 0; i < kCells * kCells; ++i) {
    const int row = i / kCells, column = i % kCells;
    const Vector2d centre((column + 0.5) * camera.width / kCells,
                          (row + 0.5) * camera.height / kCells);
    const auto ray = camera.unproject(centre);
    if (!ray) continue;
    const Vector3d x = ray->homogeneous() / first.prior.at(*ray).inverse_depth;
    const auto seen = second.project(second_from_first * x);
    if (seen && seen->x() > 0 && seen->y() > 0 && seen->x() < second.width &&
        seen->y() < second.height)
      shared[cell_of(centre)] = 1;
  }
  for (const Vector2d& ray : common.first) {
    const auto pixel = camera.project(ray.homogeneous());
    if (pixel) covered[cell_of(*pixel)] = 1;
  }
  double all = 0, hit = 0;
  for (std::size_t i = 0; i < shared.size(); ++i) {
    all += shared[i];
    hit += shared[i] * covered[i];
  }
  if (all == 0) return 0;
  const double anywhere =
      all * (1 - std::pow(1 - 1 / all, static_cast<double>(common.first.size())));
  return hit / anywhere;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The second's lengths over the first's, from the depths both expect; none when they disagree.
std::optional<double> scale_of(const Rigid3& second_from_first, const Node& second,
                               const Common& common) {
  std::vector<double> logs;
  for (const Vector3d& x : common.x_in_first) {
    const Vector3d in_second = second_from_first * x;
    const auto guess = second.prior.at(in_second.hnormalized());
    if (in_second.z() > 0) logs.push_back(-std::log(guess.inverse_depth * in_second.z()));
  }
  if (static_cast<int>(logs.size()) < kMinInliers) return std::nullopt;
  const double middle = median(logs);
  for (double& l : logs) l = std::abs(l - middle);
  if (median(logs) > kMaxScaleSpread) return std::nullopt;
  return std::exp(middle);
}

// Tie points begin at corners; in later images they lie beside one.
int tie_point_at(const Vector2d& corner, const Node& node) {
  constexpr double kBeside_px = 4;
  double nearest = kBeside_px / node.rig->left.fx;
  int found = -1;
  for (std::size_t i = 0; i < node.observations.size(); ++i) {
    const double distance = (node.observations[i].ray - corner).norm();
    if (distance < nearest) nearest = distance, found = static_cast<int>(i);
  }
  return found;
}

void tell_common(const Node& first, const Rigid3& second_from_first, const Common& common,
                 Link& link) {
  const Rigid3 camera_from_survey = first.live.inverse();
  for (std::size_t i = 0; i < common.first.size(); ++i) {
    const Vector2d& corner = common.first[i];
    const int o = tie_point_at(corner, first);
    if (o < 0) {
      link.corners.push_back({corner, common.rays[i], common.x_in_first[i]});
      continue;
    }
    // The tie point lies beside the corner, in both images alike.
    const Vector3d tie_point =
        camera_from_survey * first.observations[static_cast<std::size_t>(o)].x_in_survey;
    const Vector2d beside = (second_from_first * tie_point).hnormalized() -
                            (second_from_first * common.x_in_first[i]).hnormalized();
    link.sightings.push_back({o, common.rays[i] + beside});
  }
}

}  // namespace

namespace {

std::optional<Link> link(const std::vector<Node>& nodes, int first, int second,
                         const Features& of_first, const Features& of_second) {
  const Node& a = nodes[static_cast<std::size_t>(first)];
  const Node& b = nodes[static_cast<std::size_t>(second)];
  if (!a.prior.known() || !b.prior.known()) return std::nullopt;
  Common common = common_features(a, of_first, of_second);
  if (static_cast<int>(common.first.size()) < kMinPairs) return std::nullopt;
  const auto rough = rough_pose(common, b.rig->left.fx);
  if (!rough) return std::nullopt;
  const auto pose = refined_pose(*rough, b, common);
  if (!pose || static_cast<int>(common.first.size()) < kMinInliers) return std::nullopt;
  if (!is_spread(common.rays, b.rig->left)) return std::nullopt;
  if (coverage(a, *pose, b.rig->left, common) < kMinCoverage) return std::nullopt;
  const auto scale = scale_of(*pose, b, common);
  if (!scale) return std::nullopt;
  Link link{first, second, {*scale, {pose->rotation, *scale * pose->translation}}, 0, {}, {}};
  link.inliers = static_cast<int>(common.first.size());
  tell_common(a, *pose, common, link);
  return link;
}

}  // namespace

std::optional<Link> link(const std::vector<Node>& nodes, int first, int second) {
  return link(nodes, first, second, nodes[static_cast<std::size_t>(first)].features,
              nodes[static_cast<std::size_t>(second)].features);
}

std::optional<Link> link_by_blobs(std::vector<Node>& nodes, int first, int second) {
  return link(nodes, first, second, nodes[static_cast<std::size_t>(first)].find_blobs(),
              nodes[static_cast<std::size_t>(second)].find_blobs());
}

}  // namespace nadir::revisit

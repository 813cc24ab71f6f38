// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "relative_orientation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "nadir/odometry/bundle_adjustment.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

constexpr int kMinPoints = 12;
constexpr double kConfidence = 0.999;
constexpr std::size_t kAdjustedPoints = 250;       // enough for five unknowns
constexpr double kMinParallax = 0.3 * M_PI / 180;  // a pure rotation shows less

std::vector<cv::Point2d> to_points(const Rays& rays) {
  std::vector<cv::Point2d> points;
  for (const auto& r : rays) points.emplace_back(r.x(), r.y());
  return points;
}

Matrix3d to_matrix(const cv::Mat& m) {
  Matrix3d e;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) e(r, c) = m.at<double>(r, c);
  }
  return e;
}

// Second from first, empty when there is none. OpenCV 4.6 finds a tenth of those that fit when
// coordinates are as small as those of rays, and takes its time: hence in units of sigma.
cv::Mat find_homography(std::vector<cv::Point2d> first, std::vector<cv::Point2d> second,
                        double sigma, cv::OutputArray inliers) {
  for (auto* points : {&first, &second}) {
    for (cv::Point2d& point : *points) point /= sigma;
  }
  constexpr double kTolerated = 6;
  constexpr int kIterations = 1000;
  const cv::Mat h = cv::findHomography(first, second, cv::USAC_MAGSAC, kTolerated, inliers,
                                       kIterations, kConfidence);
  if (h.rows != 3) return {};
  const cv::Matx33d in_sigmas = h;
  const auto to_sigmas = cv::Matx33d::diag({1 / sigma, 1 / sigma, 1});
  return cv::Mat(cv::Matx33d::diag({sigma, sigma, 1}) * in_sigmas * to_sigmas);
}

Rigid3 unit_motion(const Matrix3d& rotation, const Vector3d& translation) {
  return {Eigen::Quaterniond(rotation).normalized(), translation.normalized()};
}

std::vector<Rigid3> candidates(const cv::Mat& essential, const cv::Mat& homography) {
  std::vector<Rigid3> motions;
  if (essential.rows == 3) {
    cv::Mat a, b, t;
    cv::decomposeEssentialMat(essential, a, b, t);
    const Vector3d direction(t.at<double>(0), t.at<double>(1), t.at<double>(2));
    for (const cv::Mat& r : {a, b}) {
      motions.push_back(unit_motion(to_matrix(r), direction));
      motions.push_back(unit_motion(to_matrix(r), -direction));
    }
  }
  if (!homography.empty()) {
    std::vector<cv::Mat> r, t, n;
    cv::decomposeHomographyMat(homography, cv::Mat::eye(3, 3, CV_64F), r, t, n);
    for (std::size_t i = 0; i < r.size(); ++i) {
      const Vector3d direction(t[i].at<double>(0), t[i].at<double>(1), t[i].at<double>(2));
      if (direction.norm() > 1e-6) motions.push_back(unit_motion(to_matrix(r[i]), direction));
    }
  }
  std::erase_if(motions, [](const Rigid3& m) { return !m.is_finite(); });
  return motions;
}

struct Intersections {
  std::vector<int> indices;
  std::vector<Vector3d> points;
  double parallax = 0;
};

Intersections intersect(const Rigid3& motion, const Rays& first, const Rays& second,
                        double tolerance) {
  Intersections found;
  std::vector<double> angles;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::array<Bearing, 2> bearings{{{{}, first[i]}, {motion, second[i]}}};
    const auto x = triangulate(bearings);
    if (!x) continue;
    const auto a = ray_of(*x), b = ray_of(motion * *x);
    if (!a || !b || (*a - first[i]).norm() > tolerance || (*b - second[i]).norm() > tolerance)
      continue;
    found.indices.push_back(static_cast<int>(i));
    found.points.push_back(*x);
    angles.push_back(parallax({}, motion, *x));
  }
  if (angles.empty()) return found;
  std::nth_element(angles.begin(), angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2),
                   angles.end());
  found.parallax = angles[angles.size() / 2];
  return found;
}

// Least squares over a spread subset; the homography's answer is exact for a plane only.
Rigid3 improve(const Rigid3& motion, const Rays& first, const Rays& second,
               const CameraModel& camera, double sigma) {
  Intersections near = intersect(motion, first, second, 10 * sigma);
  Adjustment a;
  a.images = {{{}, true, false}, {motion, false, true}};
  const std::size_t step = 1 + near.indices.size() / kAdjustedPoints;
  for (std::size_t k = 0; k < near.indices.size(); k += step) {
    const auto i = static_cast<std::size_t>(near.indices[k]);
    const int point = static_cast<int>(a.points.size());
    a.points.push_back({near.points[k], false});
    a.observations.push_back({0, point, false, first[i]});
    a.observations.push_back({1, point, false, second[i]});
  }
  if (static_cast<int>(a.points.size()) < kMinPoints) return motion;
  CameraRig rig;
  rig.left = camera;
  if (!adjust(a, rig).usable) return motion;
  Rigid3 improved = a.images[1].camera_from_map;
  const double length = improved.translation.norm();
  if (!(length > 1e-9)) return motion;
  improved.translation /= length;
  return improved;
}

bool alike(const Rigid3& a, const Rigid3& b) {
  return a.rotation.angularDistance(b.rotation) < 0.01 &&
         (a.translation - b.translation).norm() < 0.05;
}

}  // namespace

Agreement verify(const Rays& first, const Rays& second, double sigma) {
  // On a homography lie some points of any common ground: 11 at least in 436 pairs of images with
  // 25 points on epipolar lines and more, 6 at least in 69 pairs with 15 and more. In 567 pairs
  // with fewer it was 6 at most three times in four, and for those the essential matrix takes all
  // its 30 ms.
  constexpr int kFewest = 7;
  Agreement agreement;
  if (static_cast<int>(first.size()) < kMinPoints) return agreement;
  const auto a = to_points(first), b = to_points(second);
  cv::Mat by_essential, by_homography;
  const cv::Mat h = find_homography(a, b, sigma, by_homography);
  if (h.empty() || cv::countNonZero(by_homography) < kFewest) return agreement;
  agreement.homography = to_matrix(h);
  cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::USAC_MAGSAC, kConfidence, 3 * sigma,
                       1000, by_essential);
  for (int i = 0; i < static_cast<int>(first.size()); ++i) {
    const bool on_line = !by_essential.empty() && by_essential.at<std::uint8_t>(i) != 0;
    const bool on_plane = by_homography.at<std::uint8_t>(i) != 0;
    if (on_line || on_plane) agreement.inliers.push_back(i);
  }
  return agreement;
}

std::vector<RelativeOrientation> relative_orientations(const Rays& first, const Rays& second,
                                                       const CameraModel& camera, double sigma) {
  std::vector<RelativeOrientation> found;
  if (static_cast<int>(first.size()) < kMinPoints) return found;
  const auto a = to_points(first), b = to_points(second);
  const cv::Mat unit = cv::Mat::eye(3, 3, CV_64F);
  const cv::Mat e = cv::findEssentialMat(a, b, unit, cv::USAC_MAGSAC, kConfidence, 3 * sigma, 2000);
  const cv::Mat h = find_homography(a, b, sigma, cv::noArray());
  for (const Rigid3& start : candidates(e, h)) {
    const Intersections rough = intersect(start, first, second, 10 * sigma);
    if (rough.indices.size() * 2 < first.size() || !(rough.parallax > kMinParallax)) continue;
    const Rigid3 motion = improve(start, first, second, camera, sigma);
    const Intersections seen = intersect(motion, first, second, 3 * sigma);
    const RelativeOrientation orientation{motion, static_cast<int>(seen.indices.size()),
                                          seen.parallax};
    if (orientation.inliers < kMinPoints || !(orientation.parallax > kMinParallax)) continue;
    const bool known = std::any_of(found.begin(), found.end(), [&](const auto& f) {
      return alike(f.second_from_first, motion);
    });
    if (!known) found.push_back(orientation);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& x, const auto& y) { return x.inliers > y.inliers; });
  std::erase_if(found, [&](const auto& f) { return f.inliers * 10 < found.front().inliers * 7; });
  return found;
}

}  // namespace nadir::odometry

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/plane/plane_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "nadir/core/check.hpp"
#include "ransac_plane.hpp"

namespace nadir::plane {
namespace {

using Eigen::Vector3d;

constexpr int kPlanesToCalm = 5;  // in a row until the next refusal is news again

Fit none(std::string why) { return {std::nullopt, std::move(why)}; }

std::vector<Vector3d> trusted_points(std::span<const TiePoint> tie_points, const Config& config) {
  std::vector<Vector3d> points;
  points.reserve(tie_points.size());
  for (const TiePoint& p : tie_points) {
    if (p.x_in_survey.allFinite() && static_cast<int>(p.images) >= config.min_images &&
        p.rms_px <= config.max_reprojection_px) {
      points.push_back(p.x_in_survey);
    }
  }
  return points;
}

double median_distance(const std::vector<Vector3d>& points, const Vector3d& camera) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Vector3d& x : points) distances.push_back((x - camera).norm());
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle;
}

void turn_towards(Plane& plane, const Vector3d& camera) {
  if (plane.distance(camera) >= 0) return;
  plane.normal = -plane.normal;
  plane.offset = -plane.offset;
}

double tilt_deg(const Plane& plane, const Rigid3& survey_from_camera) {
  const double cosine = -plane.normal.dot(survey_from_camera.rotation * Vector3d::UnitZ());
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

std::string percent_line(const char* format, double ratio, double limit) {
  char line[160];
  std::snprintf(line, sizeof line, format, 100 * ratio, 100 * limit);
  return line;
}

std::string refusal(const Plane& plane, std::span<const ImagePose> images, const Config& config) {
  if (plane.inlier_ratio < config.min_inlier_ratio) {
    return percent_line("only %.0f %% of the tie points agree on a plane, %.0f %% are needed",
                        plane.inlier_ratio, config.min_inlier_ratio);
  }
  const Rigid3& central = images[images.size() / 2].survey_from_camera;
  if (!(tilt_deg(plane, central) <= config.max_tilt_deg)) {
    return "the plane is seen edge-on by the central image";
  }
  const auto behind = [&](const ImagePose& image) {
    return !(plane.distance(image.survey_from_camera.translation) > 0);
  };
  if (std::ranges::any_of(images, behind)) return "a camera of the window lies behind the plane";
  return {};
}

}  // namespace

void Config::check() const {
  require_setting(min_images >= 1, "plane.min_images", "at least 1");
  require_setting(max_reprojection_px > 0, "plane.max_reprojection_px", "above 0");
  require_setting(inlier_distance > 0 && inlier_distance < 1, "plane.inlier_distance",
                  "between 0 and 1 (a ratio of the viewing distance)");
  require_setting(min_inlier_ratio > 0 && min_inlier_ratio <= 1, "plane.min_inlier_ratio",
                  "above 0 and at most 1");
  require_setting(max_tilt_deg > 0 && max_tilt_deg < 90, "plane.max_tilt_deg", "between 0 and 90");
  require_setting(max_iterations >= 1 && max_iterations <= 100000, "plane.max_iterations",
                  "1 to 100000");
}

Fit fit_plane(std::span<const TiePoint> tie_points, std::span<const ImagePose> images,
              const Config& config) {
  const bool posed = std::ranges::all_of(
      images, [](const ImagePose& image) { return image.survey_from_camera.is_finite(); });
  if (images.empty() || !posed) return none("the window has no valid poses");
  const std::vector<Vector3d> points = trusted_points(tie_points, config);
  if (points.size() < 3) return none("fewer than 3 tie points are well observed");

  const Vector3d& camera = images[images.size() / 2].survey_from_camera.translation;
  const double threshold = config.inlier_distance * median_distance(points, camera);
  std::optional<Plane> plane = ransac_plane(points, threshold, config.max_iterations);
  if (!plane) return none("the tie points do not span a plane");
  turn_towards(*plane, camera);
  std::string why_not = refusal(*plane, images, config);
  if (!why_not.empty()) return none(std::move(why_not));
  return {std::move(plane), {}};
}

Surface PlaneFit::process(std::shared_ptr<const Orientation> orientation) {
  Surface surface;
  surface.orientation = std::move(orientation);
  if (const Window* window = surface.window()) {
    Fit fit = fit_plane(window->tie_points, window->images, config_);
    surface.plane = std::move(fit.plane);
    surface.why_not = std::move(fit.why_not);
    watch(surface);
  }
  return surface;
}

void PlaneFit::watch(Surface& surface) {
  if (surface.plane) {
    if (++planes_in_a_row_ >= kPlanesToCalm) warned_ = false;
    return;
  }
  planes_in_a_row_ = 0;
  if (warned_) return;
  warned_ = true;
  const ImagePose& central = surface.window()->central_pose();
  surface.alerts.push_back({central.time, central.image, AlertKind::not_planar,
                            "no plane fits the seabed: " + surface.why_not,
                            "the sparse cloud goes on; fly higher or over flatter ground for "
                            "mosaic and planar cloud"});
}

}  // namespace nadir::plane

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/mosaicker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "light.hpp"
#include "nadir/core/check.hpp"
#include "restart_rule.hpp"

namespace nadir::mosaic2d {
namespace {

View view_of(const Surface& surface, const Config& config) {
  const Window& window = *surface.window();
  View view;
  view.camera = window.central->rig->left;
  view.survey_from_camera = window.central_pose().survey_from_camera;
  view.plane = *surface.plane;
  view.max_range = config.max_range * view.plane.distance(view.survey_from_camera.translation);
  return view;
}

bool too_steep(const Plane& plane, const Config& config) {
  return !(plane.normal.z() >= std::cos(config.max_slope_deg * std::numbers::pi / 180));
}

// Two significant digits, upwards: 0.001873 becomes 0.0019.
double rounded(double distance) {
  const double unit = std::pow(10, std::floor(std::log10(distance)) - 1);
  return std::ceil(distance / unit - 1e-9) * unit;
}

// The finer of what the settings ask and the canvas allows.
double sampling_distance(const Footprint& seen, const Config& config) {
  const double wanted = config.ground_sampling_distance > 0 ? config.ground_sampling_distance
                                                            : rounded(seen.sampling_distance);
  const Eigen::Vector2d size = seen.most - seen.least;
  double allowed = std::sqrt(size.x() * size.y() / (config.max_megapixels * 1e6));
  allowed = std::max(allowed, std::max(size.x(), size.y()) / 16384);
  return wanted > 1.05 * allowed ? wanted : rounded(1.05 * allowed);
}

MosaicGrid grid_of(std::uint32_t number, const Stand& stand, const Config& config) {
  MosaicGrid grid;
  grid.mosaic = number;
  grid.submap = stand.submap;
  grid.plane = stand.plane;
  const double gsd = sampling_distance(stand.footprint, config);
  grid.ground_sampling_distance = gsd;
  grid.world.a = gsd;
  grid.world.e = -gsd;
  grid.world.c = std::round(stand.footprint.centre.x() / gsd) * gsd;
  grid.world.f = std::round(stand.footprint.centre.y() / gsd) * gsd;
  return grid;
}

Alert alert(const Surface& surface, AlertKind kind, std::string message, std::string remedy) {
  const ImagePose& central = surface.window()->central_pose();
  return {central.time, central.image, kind, std::move(message), std::move(remedy)};
}

void require(bool good, const char* setting, const char* range) {
  if (!good) throw InputError(std::string(setting) + " must be " + range + "; correct the setting");
}

}  // namespace

struct Mosaicker::State {
  std::optional<Mosaic> mosaic;
  std::optional<RestartRule> rule;
  LampPattern lamps;
  bool warned_of_slope = false;

  void begin(const Stand& stand, const Config& config) {
    const std::uint32_t number = mosaic ? mosaic->grid().mosaic + 1 : 0;
    mosaic.emplace(grid_of(number, stand, config));
    rule.emplace(config, stand);
  }
};

void Config::check() const {
  require(ground_sampling_distance >= 0 && ground_sampling_distance < 1e6,
          "mosaic2d.ground_sampling_distance", "0 (automatic) or a length per pixel");
  require(max_megapixels >= 0.1 && max_megapixels <= 64, "mosaic2d.max_megapixels", "0.1 to 64");
  require(max_range > 1 && max_range <= 100, "mosaic2d.max_range",
          "above 1 and at most 100 (a ratio of the distance to the plane)");
  require(max_slope_deg > 0 && max_slope_deg < 90, "mosaic2d.max_slope_deg", "between 0 and 90");
  require(restart_angle_deg > 0 && restart_angle_deg <= 180, "mosaic2d.restart_angle_deg",
          "above 0 and at most 180");
  require(restart_offset > 0, "mosaic2d.restart_offset", "above 0");
  require(restart_rms > 1, "mosaic2d.restart_rms", "above 1");
  require(restart_zoom > 1, "mosaic2d.restart_zoom", "above 1");
  require(restart_after >= 1, "mosaic2d.restart_after", "at least 1");
}

Mosaicker::Mosaicker(const Config& config) : config_(config), state_(std::make_unique<State>()) {}
Mosaicker::~Mosaicker() = default;

MosaicUpdate Mosaicker::process(std::shared_ptr<const Surface> source) {
  MosaicUpdate update;
  update.surface = std::move(source);
  const Surface& surface = *update.surface;
  if (!surface.plane) return update;
  if (too_steep(*surface.plane, config_)) {
    if (!std::exchange(state_->warned_of_slope, true)) {
      update.alerts.push_back(alert(surface, AlertKind::not_planar,
                                    "the seabed is too steep for a mosaic seen from above",
                                    "the planar cloud and the sparse cloud go on"));
    }
    return update;
  }
  state_->warned_of_slope = false;
  const View view = view_of(surface, config_);
  const std::optional<Footprint> seen = footprint(view);
  if (!seen) return update;

  const Stand stand{surface.window()->submap, *surface.plane, *seen};
  const double max_pixels = config_.max_megapixels * 1e6;
  std::string why = state_->rule ? state_->rule->reason(stand) : std::string{};
  std::optional<cv::Rect> pixels;
  if (state_->mosaic && why.empty()) {
    pixels = raster(*seen, state_->mosaic->grid(), max_pixels);
    if (!pixels) why = "the image outgrew the mosaic's raster";
  }
  if (!pixels) {
    state_->begin(stand, config_);
    pixels = raster(*seen, state_->mosaic->grid(), max_pixels);
    if (!pixels) return update;
  }
  if (!why.empty()) {
    update.alerts.push_back(alert(surface, AlertKind::mosaic_restarted,
                                  "a new mosaic began: " + why,
                                  "both are kept and lie in the same survey coordinates"));
  }
  const cv::Mat& colour = surface.window()->central->colour;
  Mosaic& mosaic = *state_->mosaic;
  ProjectedImage image = project_image(config_.even_light ? state_->lamps.flatten(colour) : colour,
                                       view, mosaic.grid(), *pixels);
  image.image = surface.window()->central_pose().image;
  if (config_.even_light) {
    apply_gain(image.bgra, mosaic.gain_to_match(image));
  }
  update.tiles = mosaic.add(image);
  update.grid = mosaic.grid();
  update.projected = std::move(image);
  return update;
}

}  // namespace nadir::mosaic2d

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

constexpr double kLongestSide = 16384;  // px of a projected image; viewers' textures end there

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
  const double scale = std::pow(10, 1 - std::floor(std::log10(distance)));
  return std::ceil(distance * scale - 1e-9) / scale;
}

// What the settings ask, or as coarse as the canvas demands.
double sampling_distance(const Footprint& seen, const Config& config, double coarser) {
  const double wanted =
      coarser * (config.ground_sampling_distance > 0 ? config.ground_sampling_distance
                                                     : rounded(seen.sampling_distance));
  const Eigen::Vector2d size = seen.most - seen.least;
  double allowed = std::sqrt(size.x() * size.y() / (config.max_megapixels * 1e6));
  allowed = 1.05 * std::max(allowed, size.maxCoeff() / kLongestSide);
  return wanted > allowed ? wanted : rounded(allowed);
}

MosaicGrid grid_of(std::uint32_t number, const Stand& stand, const Config& config, double coarser) {
  MosaicGrid grid;
  grid.mosaic = number;
  grid.submap = stand.submap;
  grid.plane = stand.plane;
  const double gsd = sampling_distance(stand.footprint, config, coarser);
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

Alert steep_alert(const Surface& surface) {
  return alert(surface, AlertKind::not_planar,
               "the seabed is too steep for a mosaic seen from above",
               "the planar cloud and the sparse cloud go on");
}

Alert restart_alert(const Surface& surface, const std::string& why) {
  return alert(surface, AlertKind::mosaic_restarted, "a new mosaic began: " + why,
               "nothing to do: both mosaics are kept and share the survey's coordinates");
}

}  // namespace

struct Mosaicker::State {
  std::optional<Mosaic> mosaic;
  bool finished = false;
  std::optional<RestartRule> rule;
  LampPattern lamps;
  bool warned_of_slope = false;
  double coarser = 1, mosaic_coarser = 1;  ///< as wanted, and of the mosaic

  void begin(const Stand& stand, const Config& config) {
    const std::uint32_t number = mosaic ? mosaic->grid().mosaic + 1 : 0;
    mosaic.emplace(grid_of(number, stand, config, coarser));
    mosaic_coarser = coarser;
    rule.emplace(config, stand);
  }

  // Where the image lies in its mosaic's raster, a new mosaic's if the rule or the canvas says so;
  // then `why` says it.
  std::optional<cv::Rect> place(const Stand& stand, const Config& config, std::string& why) {
    const double max_pixels = config.max_megapixels * 1e6;
    if (mosaic) {
      why = rule->reason(stand);
      if (coarser != mosaic_coarser) why = "the load asks for another resolution";
      const auto pixels = raster(stand.footprint, mosaic->grid(), max_pixels);
      if (why.empty() && pixels) return pixels;
      if (why.empty()) why = "the image outgrew the mosaic's raster";
    }
    begin(stand, config);
    return raster(stand.footprint, mosaic->grid(), max_pixels);
  }

  ProjectedImage project(const Window& window, const View& view, const cv::Rect& pixels,
                         bool even_light) {
    const cv::Mat& colour = window.central->colour;
    ProjectedImage image =
        project_image(even_light ? lamps.flatten(colour) : colour, view, mosaic->grid(), pixels);
    image.image = window.central_pose().image;
    if (even_light) apply_gain(image.bgra, mosaic->gain_to_match(image));
    for (const Disc& disc : window.central->hidden) hide(image, view, disc);
    return image;
  }
};

void Config::check() const {
  require_setting(ground_sampling_distance == 0 ||
                      (ground_sampling_distance >= 1e-6 && ground_sampling_distance < 1e6),
                  "mosaic2d.ground_sampling_distance",
                  "0 (automatic) or a length per pixel, 1e-6 or more");
  require_setting(max_megapixels >= 0.1 && max_megapixels <= 64, "mosaic2d.max_megapixels",
                  "0.1 to 64");
  require_setting(max_range > 1 && max_range <= 100, "mosaic2d.max_range",
                  "above 1 and at most 100 (a ratio of the distance to the plane)");
  require_setting(max_slope_deg > 0 && max_slope_deg < 90, "mosaic2d.max_slope_deg",
                  "between 0 and 90");
  require_setting(restart_angle_deg > 0 && restart_angle_deg <= 180, "mosaic2d.restart_angle_deg",
                  "above 0 and at most 180");
  require_setting(restart_offset > 0, "mosaic2d.restart_offset", "above 0");
  require_setting(restart_rms > 1, "mosaic2d.restart_rms", "above 1");
  require_setting(restart_zoom > 1, "mosaic2d.restart_zoom", "above 1");
  require_setting(restart_after >= 1, "mosaic2d.restart_after", "at least 1");
}

Mosaicker::Mosaicker(const Config& config) : config_(config), state_(std::make_unique<State>()) {}
Mosaicker::~Mosaicker() = default;

void Mosaicker::coarsen(double factor) { state_->coarser = factor; }

void Mosaicker::finish() {
  state_->finished = true;
  state_->mosaic.reset();
}

MosaicUpdate Mosaicker::process(std::shared_ptr<const Surface> source) {
  NADIR_CHECK(!state_->finished);
  MosaicUpdate update;
  update.surface = std::move(source);
  const Surface& surface = *update.surface;
  if (!surface.plane) return update;
  const bool steep = too_steep(*surface.plane, config_);
  if (steep && !state_->warned_of_slope) update.alerts.push_back(steep_alert(surface));
  state_->warned_of_slope = steep;
  if (steep) return update;

  const View view = view_of(surface, config_);
  const std::optional<Footprint> seen = footprint(view);
  if (!seen) return update;
  std::string why;
  const Stand stand{surface.window()->submap, *surface.plane, *seen};
  const std::optional<cv::Rect> pixels = state_->place(stand, config_, why);
  if (!why.empty()) update.alerts.push_back(restart_alert(surface, why));
  if (!pixels) return update;

  update.projected = state_->project(*surface.window(), view, *pixels, config_.even_light);
  update.tiles = state_->mosaic->add(*update.projected);
  update.grid = state_->mosaic->grid();
  return update;
}

}  // namespace nadir::mosaic2d

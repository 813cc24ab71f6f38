// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/alert.hpp"

#include "nadir/core/window.hpp"

namespace nadir {

std::string_view to_string(AlertKind kind) {
  switch (kind) {
    case AlertKind::tracking_lost:
      return "tracking_lost";
    case AlertKind::tracking_recovered:
      return "tracking_recovered";
    case AlertKind::submap_started:
      return "submap_started";
    case AlertKind::submap_joined:
      return "submap_joined";
    case AlertKind::not_planar:
      return "not_planar";
    case AlertKind::mosaic_restarted:
      return "mosaic_restarted";
    case AlertKind::scale_conflict:
      return "scale_conflict";
    case AlertKind::calibration_suspect:
      return "calibration_suspect";
    case AlertKind::stereo_skew:
      return "stereo_skew";
    case AlertKind::camera_lost:
      return "camera_lost";
    case AlertKind::camera_back:
      return "camera_back";
    case AlertKind::image_rejected:
      return "image_rejected";
    case AlertKind::images_dropped:
      return "images_dropped";
    case AlertKind::sensor_stale:
      return "sensor_stale";
    case AlertKind::storage:
      return "storage";
    case AlertKind::clock:
      return "clock";
    case AlertKind::storage_back:
      return "storage_back";
    case AlertKind::load:
      return "load";
  }
  return "unknown";
}

std::string_view to_string(Weakness weakness) {
  switch (weakness) {
    case Weakness::few_tie_points:
      return "few_tie_points";
    case Weakness::one_sided:
      return "one_sided";
    case Weakness::short_tracks:
      return "short_tracks";
    case Weakness::large_residuals:
      return "large_residuals";
    case Weakness::blurred:
      return "blurred";
    case Weakness::dark:
      return "dark";
    case Weakness::bright:
      return "bright";
  }
  return "unknown";
}

std::string_view to_string(TrackingState state) {
  switch (state) {
    case TrackingState::waiting:
      return "waiting";
    case TrackingState::initialising:
      return "initialising";
    case TrackingState::tracking:
      return "tracking";
    case TrackingState::lost:
      return "lost";
  }
  return "unknown";
}

std::string_view to_string(SurveyAxes axes) {
  switch (axes) {
    case SurveyAxes::none:
      return "none";
    case SurveyAxes::first_plane:
      return "first_plane";
    case SurveyAxes::attitude:
      return "attitude";
    case SurveyAxes::first_camera:
      return "first_camera";
    case SurveyAxes::poses:
      return "poses";
    case SurveyAxes::doubtful:
      return "doubtful";
  }
  return "unknown";
}

std::string_view to_string(ScaleSource source) {
  switch (source) {
    case ScaleSource::none:
      return "none";
    case ScaleSource::stereo:
      return "stereo";
    case ScaleSource::laser:
      return "laser";
    case ScaleSource::typed:
      return "typed";
    case ScaleSource::altitude:
      return "altitude";
    case ScaleSource::depth:
      return "depth";
    case ScaleSource::poses:
      return "poses";
  }
  return "unknown";
}

std::string_view in_words(ScaleSource source) {
  switch (source) {
    case ScaleSource::none:
      return "nothing";
    case ScaleSource::stereo:
      return "the pair of cameras";
    case ScaleSource::laser:
      return "the lasers";
    case ScaleSource::typed:
      return "the known length";
    case ScaleSource::altitude:
      return "the altimeter";
    case ScaleSource::depth:
      return "changes of depth";
    case ScaleSource::poses:
      return "the given poses";
  }
  return "unknown";
}

}  // namespace nadir

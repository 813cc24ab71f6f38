// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The table: every setting's name, field and meaning, in the order of the dump.
#include <sstream>
#include <utility>

#include "config.hpp"
#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

template <class T>
T converted(const Value& value) {
  if constexpr (std::is_same_v<T, bool>) {
    if (const bool* v = std::get_if<bool>(&value)) return *v;
    throw InputError("wants true or false");
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (const auto* v = std::get_if<std::string>(&value)) return *v;
    throw InputError("wants a text in quotes");
  } else if constexpr (std::is_integral_v<T>) {
    const auto* v = std::get_if<std::int64_t>(&value);
    if (!v) throw InputError("wants a whole number");
    if (!std::in_range<T>(*v)) throw InputError("wants a smaller number");
    return static_cast<T>(*v);
  } else {
    if (const auto* v = std::get_if<double>(&value)) return static_cast<T>(*v);
    if (const auto* v = std::get_if<std::int64_t>(&value)) return static_cast<T>(*v);
    throw InputError("wants a number");
  }
}

template <class T>
Value shown(const T& field) {
  if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, std::string>) {
    return field;
  } else if constexpr (std::is_integral_v<T>) {
    return static_cast<std::int64_t>(field);
  } else {
    return static_cast<double>(field);
  }
}

// room: the member of Config; field: the member of the room's Config.
template <class Room, class T>
Setting setting(std::string key, Room Config::*room, T Room::*field, std::string meaning) {
  return {std::move(key), std::move(meaning),
          [=](const Config& config) { return shown(config.*room.*field); },
          [=](Config& config, const Value& value) { config.*room.*field = converted<T>(value); }};
}

template <class Room, class T>
Setting choice(std::string key, Room Config::*room, T Room::*field,
               std::vector<std::pair<std::string, T>> choices, std::string meaning) {
  const auto get = [=](const Config& config) -> Value {
    for (const auto& [name, value] : choices) {
      if (value == config.*room.*field) return name;
    }
    return std::string("?");
  };
  const auto set = [=](Config& config, const Value& given) {
    std::string names;
    for (const auto& [name, value] : choices) {
      if (given == Value(name)) {
        config.*room.*field = value;
        return;
      }
      names += (names.empty() ? "" : ", ") + name;
    }
    throw InputError("wants one of: " + names);
  };
  return {std::move(key), std::move(meaning), get, set};
}

// A list of names is one text in the file.
Setting names(std::string key, std::vector<std::string> serve::Config::*field,
              std::string meaning) {
  const auto get = [=](const Config& config) -> Value {
    std::string joined;
    for (const std::string& name : config.serve.*field)
      joined += (joined.empty() ? "" : ",") + name;
    return joined;
  };
  const auto set = [=](Config& config, const Value& value) {
    (config.serve.*field).clear();
    std::istringstream joined(converted<std::string>(value));
    for (std::string name; std::getline(joined, name, ',');) (config.serve.*field).push_back(name);
  };
  return {std::move(key), std::move(meaning), get, set};
}

std::vector<Setting> make_settings() {
  return {
      setting("capture.scale", &Config::capture, &capture::Config::scale,
              "processed size per side: 1, 0.5 or 0.25"),
      setting(
          "capture.mounting_roll_deg", &Config::capture, &capture::Config::mounting_roll_deg,
          "of the camera in the vehicle, from looking down, image top forward: right side down,"),
      setting("capture.mounting_pitch_deg", &Config::capture, &capture::Config::mounting_pitch_deg,
              "looking ahead,"),
      setting("capture.mounting_yaw_deg", &Config::capture, &capture::Config::mounting_yaw_deg,
              "turned clockwise seen from above"),
      setting("capture.rate_hz", &Config::capture, &capture::Config::rate_hz,
              "images a second taken from a video or a camera; 0: all"),
      setting("capture.camera", &Config::capture, &capture::Config::camera,
              "live camera, of a pair the left one: its path in /dev/v4l/by-path or by-id, its "
              "serial number, bus or card; or \"auto\", the only USB camera"),
      setting("capture.camera_right", &Config::capture, &capture::Config::camera_right,
              "the right one of a pair; empty: a single camera"),
      setting("capture.calibration", &Config::capture, &capture::Config::calibration,
              "of the live camera or pair; lasers.yml lies beside it"),
      setting("capture.exposure_ms", &Config::capture, &capture::Config::exposure_ms,
              "fixed exposure of live cameras; 0: steered by light and speed"),
      setting("capture.gain", &Config::capture, &capture::Config::gain,
              "fixed gain in the camera's unit; -1: likewise"),
      setting("capture.focus", &Config::capture, &capture::Config::focus,
              "fixed focus in the camera's unit; -1: as it is; never automatic"),
      setting("capture.max_blur_px", &Config::capture, &capture::Config::max_blur_px,
              "full-size pixels that motion may smear; a steered exposure keeps to it"),
      setting("capture.max_skew_ms", &Config::capture, &capture::Config::max_skew_ms,
              "between the images of a live pair, before it is told"),
      setting("sensors.inputs", &Config::sensors, &sensors::Config::inputs,
              "of live sensors, with spaces between: nmea or mavlink, then :serial:DEVICE:BAUD, "
              ":udp:PORT or :tcp:HOST:PORT; or iio:device:NAME:HZ, a pressure sensor or a "
              "BNO055 on the board"),
      setting("sensors.attitude_delay_s", &Config::sensors, &sensors::Config::attitude_delay_s,
              "how late roll, pitch and heading arrive"),
      setting("sensors.depth_delay_s", &Config::sensors, &sensors::Config::depth_delay_s,
              "how late depth arrives"),
      setting("sensors.altitude_delay_s", &Config::sensors, &sensors::Config::altitude_delay_s,
              "how late altitude arrives"),
      setting("sensors.surface_pressure_hpa", &Config::sensors,
              &sensors::Config::surface_pressure_hpa, "of the air, for depth by pressure"),
      setting("sensors.water_density", &Config::sensors, &sensors::Config::water_density,
              "kg/m3, likewise; lakes and pools 1000"),
      setting("sensors.magnetic_variation_deg", &Config::sensors,
              &sensors::Config::magnetic_variation_deg,
              "true minus magnetic north, east positive, while no sensor tells it; 0 with "
              "reference.origin: by the magnetic model"),
      setting("sensors.outputs", &Config::sensors, &sensors::Config::outputs,
              "where live poses and covered ground are sent, with spaces between: json, mavlink or "
              "nmea, then :udp:ADDRESS:PORT"),
      setting("sensors.mavlink_system", &Config::sensors, &sensors::Config::mavlink_system,
              "the vehicle's number in MAVLink"),
      setting("odometry.initial_images", &Config::odometry, &odometry::Config::initial_images,
              "key images that start a single camera's map; 3 of pairs and where no more see its "
              "ground"),
      setting("odometry.window", &Config::odometry, &odometry::Config::window,
              "key frames adjusted together: 3, 5 or more"),
      setting("odometry.features", &Config::odometry, &odometry::Config::features,
              "corners described per image"),
      setting("odometry.tie_points", &Config::odometry, &odometry::Config::tie_points,
              "wanted per key frame"),
      setting("odometry.key_frame_shift", &Config::odometry, &odometry::Config::key_frame_shift,
              "image motion that makes a key frame, of the shorter side"),
      setting("odometry.min_parallax_deg", &Config::odometry, &odometry::Config::min_parallax_deg,
              "intersection angle a new tie point needs"),
      setting("odometry.attitude_sigma_deg", &Config::odometry,
              &odometry::Config::attitude_sigma_deg,
              "1 sigma of the AHRS's roll and pitch, mounting included, in the adjustment; 0: not "
              "used"),
      setting("odometry.heading_sigma_deg", &Config::odometry, &odometry::Config::heading_sigma_deg,
              "1 sigma of its heading, beside a slowly varying offset; 0: not used"),
      setting("odometry.depth_sigma_m", &Config::odometry, &odometry::Config::depth_sigma_m,
              "1 sigma of the depth sensor, beside a slowly varying offset; 0: not used"),
      setting("odometry.range_sigma", &Config::odometry, &odometry::Config::range_sigma,
              "1 sigma of a laser's range, relative, beside a slowly varying offset; 0: not used"),
      setting("odometry.relocalise_key_frames", &Config::odometry,
              &odometry::Config::relocalise_key_frames, "recent key frames searched after a loss"),
      choice<odometry::Config, odometry::OnLost>(
          "odometry.on_lost", &Config::odometry, &odometry::Config::on_lost,
          {{"stop", odometry::OnLost::stop}, {"submap", odometry::OnLost::submap}},
          "after a loss: stop, or start a sub-map and look for known ground"),
      setting("odometry.weak_tie_points", &Config::odometry, &odometry::Config::weak_tie_points,
              "an image with fewer is called weak in health.csv"),
      setting("odometry.weak_quadrant", &Config::odometry, &odometry::Config::weak_quadrant,
              "or with fewer in a quadrant"),
      setting("odometry.weak_track_length", &Config::odometry, &odometry::Config::weak_track_length,
              "or with tie points seen in fewer images, in the median"),
      setting("odometry.weak_rms_px", &Config::odometry, &odometry::Config::weak_rms_px,
              "or with larger reprojection residuals"),
      setting("odometry.weak_sharpness", &Config::odometry, &odometry::Config::weak_sharpness,
              "or less sharp: variance of the Laplacian"),
      setting("odometry.weak_dark", &Config::odometry, &odometry::Config::weak_dark,
              "or darker: mean grey level"),
      setting("odometry.weak_bright", &Config::odometry, &odometry::Config::weak_bright,
              "or brighter"),
      setting("reference.attitude", &Config::reference, &reference::Config::attitude,
              "vertical and north from the AHRS where images have attitudes"),
      setting("reference.origin", &Config::reference, &reference::Config::origin,
              "\"LATITUDE LONGITUDE\" or \"LATITUDE LONGITUDE HEIGHT\" of the ground where the map "
              "begins, WGS 84, decimal degrees, metres above the ellipsoid: with an AHRS the files "
              "for GIS are UTM, and magnetic headings become true; empty: none"),
      setting("reference.stereo_matching_px", &Config::reference,
              &reference::Config::stereo_matching_px,
              "1 sigma of a disparity, for the sigma of the stereo scale"),
      setting("reference.dead_reckoning_max_s", &Config::reference,
              &reference::Config::dead_reckoning_max_s,
              "after this long the last velocity says nothing any more"),
      setting("reference.altimeter_below_camera_m", &Config::reference,
              &reference::Config::altimeter_below_camera_m,
              "metres from the lens down to the altimeter, along the vehicle's down axis"),
      setting("reference.known_length", &Config::reference, &reference::Config::known_length,
              "\"IMAGE X1 Y1 X2 Y2 METRES\": two places of an image (counted from 0; pixels at the "
              "processed scale) whose distance on the ground is known; it scales a single camera's "
              "map"),
      setting("reference.max_plane_tilt_deg", &Config::reference,
              &reference::Config::max_plane_tilt_deg,
              "between a map's plane and the viewing direction; a steeper plane gives no vertical"),
      setting("revisit.enabled", &Config::revisit, &revisit::Config::enabled,
              "look for known ground and adjust the map to it"),
      setting("revisit.gap", &Config::revisit, &revisit::Config::gap,
              "key frames between two that count as a revisit"),
      setting("revisit.candidates", &Config::revisit, &revisit::Config::candidates,
              "earlier key frames tried for each new one"),
      setting("revisit.max_adjusted", &Config::revisit, &revisit::Config::max_adjusted,
              "key frames in the final bundle adjustment; beyond, only the pose graph"),
      setting("revisit.max_tilt_deg", &Config::revisit, &revisit::Config::max_tilt_deg,
              "between the verticals of two images that show the same ground"),
      setting("revisit.check_calibration", &Config::revisit, &revisit::Config::check_calibration,
              "alert where images contradict the calibration, revisits enabled or not; a "
              "self-calibration tells, a second or so off the live path"),
      setting("plane.min_images", &Config::plane, &plane::Config::min_images,
              "a tie point counts when seen in at least so many images"),
      setting("plane.max_reprojection_px", &Config::plane, &plane::Config::max_reprojection_px,
              "and reprojected with at most this RMS"),
      setting("plane.inlier_distance", &Config::plane, &plane::Config::inlier_distance,
              "of the viewing distance"),
      setting("plane.min_inlier_ratio", &Config::plane, &plane::Config::min_inlier_ratio,
              "below it the seabed is not planar"),
      setting("plane.max_tilt_deg", &Config::plane, &plane::Config::max_tilt_deg,
              "between the plane's normal and the central optical axis"),
      setting("plane.max_iterations", &Config::plane, &plane::Config::max_iterations,
              "RANSAC samples at most"),
      setting("mosaic2d.ground_sampling_distance", &Config::mosaic2d,
              &mosaic2d::Config::ground_sampling_distance,
              "survey units per px; 0: that of a mosaic's first image"),
      setting("mosaic2d.max_megapixels", &Config::mosaic2d, &mosaic2d::Config::max_megapixels,
              "of one projected image; coarser sampling keeps to it"),
      setting("mosaic2d.max_range", &Config::mosaic2d, &mosaic2d::Config::max_range,
              "longest ray, as a ratio of the camera's distance to the plane"),
      setting("mosaic2d.max_slope_deg", &Config::mosaic2d, &mosaic2d::Config::max_slope_deg,
              "of a plane against the horizontal; steeper ground is not mosaicked"),
      setting("mosaic2d.even_light", &Config::mosaic2d, &mosaic2d::Config::even_light,
              "flatten the lamps' pattern and the exposure's steps"),
      setting("mosaic2d.restart_angle_deg", &Config::mosaic2d, &mosaic2d::Config::restart_angle_deg,
              "a new mosaic starts beyond this between the planes' normals,"),
      setting("mosaic2d.restart_offset", &Config::mosaic2d, &mosaic2d::Config::restart_offset,
              "this height below the image centre, of the viewing distance,"),
      setting("mosaic2d.restart_rms", &Config::mosaic2d, &mosaic2d::Config::restart_rms,
              "this growth of the plane's RMS,"),
      setting("mosaic2d.restart_zoom", &Config::mosaic2d, &mosaic2d::Config::restart_zoom,
              "or this factor of coarser or finer sampling,"),
      setting("mosaic2d.restart_after", &Config::mosaic2d, &mosaic2d::Config::restart_after,
              "for so many images in a row"),
      setting("projection3d.columns", &Config::projection3d, &projection3d::Config::columns,
              "points across a planar cloud"),
      setting("projection3d.rows", &Config::projection3d, &projection3d::Config::rows,
              "points down a planar cloud"),
      setting("projection3d.max_range", &Config::projection3d, &projection3d::Config::max_range,
              "longest ray, as a ratio of the camera's distance to the plane"),
      setting("plan.length", &Config::plan, &PlanConfig::length,
              "metres of the rectangle that is to be covered, along its lanes; 0: no plan, the "
              "ground swept is to be covered without gaps"),
      setting("plan.width", &Config::plan, &PlanConfig::width,
              "metres across the lanes, to the right of the first"),
      setting("plan.bearing_deg", &Config::plan, &PlanConfig::bearing_deg,
              "of the first lane, clockwise from the map's north (y)"),
      setting("plan.lane_spacing", &Config::plan, &PlanConfig::lane_spacing,
              "metres from lane to lane at most; 0: 0.7 of the width of the first planar cloud"),
      setting("plan.corner_x", &Config::plan, &PlanConfig::corner_x,
              "where the first lane's left edge begins, metres in the map,"),
      setting("plan.corner_y", &Config::plan, &PlanConfig::corner_y, "likewise;"),
      setting("plan.corner_latitude", &Config::plan, &PlanConfig::corner_latitude,
              "or with reference.origin in degrees,"),
      setting("plan.corner_longitude", &Config::plan, &PlanConfig::corner_longitude,
              "likewise; 0 and 0: by corner_x and corner_y"),
      setting("guide.altitude_low", &Config::guide, &GuideConfig::altitude_low,
              "metres over ground below which the page advises to go up; with both 0, in which an "
              "image shows two thirds of its usual width and a tenth more than a lane"),
      setting("guide.altitude_high", &Config::guide, &GuideConfig::altitude_high,
              "and above which to go down; likewise one and a half times the width"),
      setting("guide.overlap_low", &Config::guide, &GuideConfig::overlap_low,
              "share of an image that the one before it must show; slower below it"),
      setting("record.dives", &Config::record, &record::Config::dives,
              "folder in which nadir run makes a new one for each dive; the service may write "
              "elsewhere only "
              "with ReadWritePaths=FOLDER by systemctl edit nadir"),
      choice<record::Config, record::Originals>(
          "record.originals", &Config::record, &record::Config::originals,
          {{"none", record::Originals::none},
           {"key_frames", record::Originals::key_frames},
           {"all", record::Originals::all}},
          "which images of live cameras are kept as they came, "
          "in DIVE/survey, which can be replayed: none, "
          "key_frames (new ground) or all"),
      setting("record.projected", &Config::record, &record::Config::projected,
              "save each projected image; without them mosaics cannot be recovered"),
      setting("record.small_png", &Config::record, &record::Config::small_png,
              "smaller projected images for a little more time"),
      setting("serve.address", &Config::serve, &serve::Config::address,
              "IP literal; 0.0.0.0 or :: for every network"),
      setting("serve.port", &Config::serve, &serve::Config::port, "0: the system's choice"),
      names("serve.names", &serve::Config::names,
            "host names this device goes by beside localhost, separated by commas"),
      setting("serve.certificate", &Config::serve, &serve::Config::certificate,
              "PEM file, its chain included: with serve.key the page is had by https too, on the "
              "same port; tablets install it only from there"),
      setting("serve.key", &Config::serve, &serve::Config::key,
              "PEM file, without a passphrase, readable by the user nadir"),
      setting("serve.max_clients", &Config::serve, &serve::Config::max_clients,
              "viewers at a time"),
      setting("serve.client_bytes", &Config::serve, &serve::Config::client_bytes,
              "kernel send buffer of a viewer: what may be stale"),
      setting("serve.retained_bytes", &Config::serve, &serve::Config::retained_bytes,
              "of records kept for late viewers; oldest data go"),
      setting("serve.header_timeout", &Config::serve, &serve::Config::header_timeout,
              "seconds for a request's header, with TLS's handshake, and for the hello"),
      setting("serve.idle_timeout", &Config::serve, &serve::Config::idle_timeout,
              "seconds without an answer to a ping"),
      setting("serve.stall_timeout", &Config::serve, &serve::Config::stall_timeout,
              "seconds in which a viewer took nothing of what it is sent"),
  };
}

}  // namespace

const std::vector<Setting>& settings() {
  static const std::vector<Setting> table = make_settings();
  return table;
}

}  // namespace nadir::app

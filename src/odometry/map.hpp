// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One sub-map: its key frames and tie points, in the survey frame once it was placed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "features.hpp"
#include "nadir/core/window.hpp"
#include "nadir/odometry/depth_prior.hpp"
#include "patch.hpp"

namespace nadir::odometry {

/// A tie point in a key frame: normalised coordinates, and those in the right image of a pair.
struct Sighting {
  int key_frame = 0;
  Eigen::Vector2d ray;
  std::optional<Eigen::Vector2d> right_ray;
};

struct MapPoint {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of the ground around it
  int host = 0;                                       ///< key frame its patch was cut from
  Eigen::Vector2i host_pixel = Eigen::Vector2i::Zero();
  Patch patch;
  std::array<std::uint8_t, 32> descriptor{};
  std::array<std::uint8_t, 3> rgb{};
  std::vector<Sighting> sightings;  ///< empty: the point was given up
  double rms_px = 0;
};

/// How far a sensor is off in a map: a mean that changes slowly.
class SlowOffset {
 public:
  void add(double measured) {
    constexpr int kMemory = 200;  // key frames
    count_ = std::min(count_ + 1, kMemory);
    mean_ += (measured - mean_) / count_;
  }
  bool is_known() const {
    constexpr int kEnough = 10;
    return count_ >= kEnough;
  }
  double mean() const { return mean_; }

 private:
  double mean_ = 0;
  int count_ = 0;
};

struct KeyFrame {
  std::uint64_t image = 0;
  Time time = 0;
  Rigid3 camera_from_map;
  std::shared_ptr<const View> view;   ///< null once the key frame left the window
  std::vector<std::uint8_t> picture;  ///< grey JPEG, reduced, once the view is gone
  Features features;                  ///< kept longer than the view, to find recent ground again
  std::vector<int> points;            ///< seen in it
  std::optional<Eigen::Quaterniond> enu_from_camera;  ///< by the AHRS
  std::optional<double> height;                       ///< minus the depth below the surface, metres
  std::vector<Range> ranges;                          ///< by lasers
  double rms_px = 0;
  double depth = 0;  ///< median of its tie points along the optical axis
  double sigma_position = 0, sigma_rotation = 0;  ///< relative to the key frame before it
};

struct Map {
  std::shared_ptr<const CameraRig> rig;
  std::vector<KeyFrame> key_frames;
  std::vector<MapPoint> points;
  std::vector<int> given_up;  ///< since the last window was made
  int settled = 0;            ///< key frames handed out for good
  std::uint32_t submap = 0;
  std::uint64_t first_id = 0;  ///< id of points[0] in the dive
  Scale scale;
  SurveyAxes axes = SurveyAxes::none;
  SlowOffset heading_offset;  ///< radians about z, from the AHRS to the map
  SlowOffset height_offset;   ///< of the map's z above the surface
  SlowOffset range_offset;    ///< logarithm of the map's depths over the lasers'
  bool uncertain = false;     ///< placed by attitude and dead reckoning only

  const KeyFrame& last() const { return key_frames.back(); }
  KeyFrame& key_frame(int i) { return key_frames[static_cast<std::size_t>(i)]; }
  const KeyFrame& key_frame(int i) const { return key_frames[static_cast<std::size_t>(i)]; }
  MapPoint& point(int i) { return points[static_cast<std::size_t>(i)]; }
  const MapPoint& point(int i) const { return points[static_cast<std::size_t>(i)]; }
};

/// Moves the whole map.
void move(Map& map, const Similarity3& to_from_map);

/// Takes a point out of the map, or one sighting from a point.
void give_up(Map& map, int point);
void give_up_sighting(Map& map, int point, int key_frame);

/// Median distance of the key frame's tie points along its optical axis; 0 without any.
double median_depth(const Map& map, const KeyFrame& key_frame);

/// From the tie points seen in a key frame.
DepthPrior depth_prior(const Map& map, const KeyFrame& key_frame);

/// Points expected in an image at this pose, those seen most often first; at most `limit`, spread
/// over the image.
struct Expected {
  int point = 0;
  Eigen::Vector2d pixel;
};
std::vector<Expected> expected_points(const Map& map, const Rigid3& camera_from_map, int limit);

}  // namespace nadir::odometry

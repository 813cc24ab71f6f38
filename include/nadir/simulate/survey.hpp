// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A simulated survey in memory: pictures of a synthetic seabed and the exact truth about them.
// Frames as in machine.md; survey: x east, y north, z up, z = 0 at the water's surface.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "nadir/core/camera_model.hpp"
#include "nadir/core/frame.hpp"
#include "nadir/core/rigid3.hpp"
#include "nadir/core/time.hpp"
#include "nadir/simulate/options.hpp"

namespace nadir::simulate {

/// A coded plate; the point is the centre of its white disc.
struct Target {
  std::string id;
  Eigen::Vector3d x_in_survey = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double disc = 0, plate = 0;  ///< diameter, side; metres
};

/// A target wholly and freely seen: exact projection of its centre.
struct Sighting {
  std::string id;
  bool right = false;  ///< in the right camera
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double disc_px = 0;
};

/// Where a laser's beam meets the seabed, seen by the left camera.
struct LaserDot {
  int laser = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double depth = 0;  ///< along the optical axis, metres
};

/// Parallel beams along the optical axis.
struct Lasers {
  double separation = 0;                 ///< metres
  std::vector<Eigen::Vector3d> origins;  ///< camera frame, metres
};

/// The surface from above. Node (row, column) lies at
/// survey_from_local * (x0 + column cell, y0 + row cell, z(row, column)).
struct HeightMap {
  cv::Mat1f z;  ///< metres
  double x0 = 0, y0 = 0, cell = 0;
  Rigid3 survey_from_local;
};

/// BGR, CV_8UC3; right is empty when mono.
struct Picture {
  cv::Mat left, right;
};

struct AttitudeReading {
  double seconds = 0;
  Attitude attitude;
};
struct DepthReading {
  double seconds = 0, depth = 0;
};

/// Everything follows from the options; each member gives the same bits whenever it is asked.
class Survey {
 public:
  /// Throws InputError as Options::check does.
  explicit Survey(const Options& options);
  ~Survey();
  Survey(const Survey&) = delete;
  Survey& operator=(const Survey&) = delete;

  int images() const;  ///< or pairs
  const std::shared_ptr<const CameraRig>& rig() const;
  Time time(int image) const;
  std::string name(int image) const;
  Rigid3 survey_from_camera(int image) const;

  /// What the cameras record.
  Picture picture(int image) const;
  /// The same as capture delivers it, with exact attitude and depth below the surface.
  Frame frame(int image) const;
  /// Depth along the left camera's optical axis at pixel centres, metres; 0: nothing there.
  cv::Mat1f depth(int image) const;

  std::vector<Target> targets() const;
  std::vector<Sighting> sightings(int image) const;
  /// None unless the scene is transect and mono.
  std::optional<Lasers> lasers() const;
  std::vector<LaserDot> laser_dots(int image) const;
  HeightMap height_map() const;

  /// Noisy as the README of a written survey says; from 0 to just after the last image.
  std::vector<AttitudeReading> attitude_readings() const;  ///< 10 Hz
  std::vector<DepthReading> depth_readings() const;        ///< 5 Hz

 private:
  struct World;
  std::unique_ptr<const World> world_;
};

}  // namespace nadir::simulate

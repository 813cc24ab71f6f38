// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether the AHRS turns as the images do: units, signs, order of its columns, mounting, clock.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "nadir/core/time.hpp"

namespace nadir::reference {

struct AttitudeSigma {
  double tilt_deg = 2;     ///< of roll and pitch
  double heading_deg = 5;  ///< of yaw
};

/// An oriented image that the AHRS told of.
struct AttitudeSample {
  Time time = 0;
  std::uint32_t submap = 0;
  Eigen::Quaterniond survey_from_body;  ///< by the images
  Eigen::Quaterniond ned_from_body;     ///< by the AHRS
};

struct AttitudeContradiction {
  std::string message;   ///< with the figures
  bool of_tilt = false;  ///< roll or pitch contradict, not the heading alone
};

/// Compares how far both turned, of images at least 0.3 s apart, from each to the fifth before it,
/// about levelled axes: ahead, to the right, down. The AHRS's turn about each is regressed on the
/// images' turn about all three and a constant, by which their map bends; its coefficient of the
/// same axis is 1 when they agree, 0.02 for radians, -1 for a wrong sign, 0 for another axis.
class AttitudeCheck {
 public:
  explicit AttitudeCheck(const AttitudeSigma& sigma) : sigma_(sigma) {}

  /// Of images in order of time. A contradiction of the tilt once, of the heading once: when the
  /// regression is certain of it, or when turns keep differing by more than 4 sigma
  /// of both.
  std::optional<AttitudeContradiction> observe(const AttitudeSample& sample);

 private:
  bool is_far_off(const Eigen::Vector3d& difference, bool tilt) const;
  std::optional<AttitudeContradiction> tell(bool of_tilt, std::string message);
  std::optional<AttitudeContradiction> regress();

  AttitudeSigma sigma_;
  std::deque<AttitudeSample> recent_;  ///< of one sub-map

  // Sums of turns about the levelled axes (roll, pitch, heading) and of their products, faded.
  Eigen::Vector3d sum_images_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum_ahrs_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d by_images_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d by_ahrs_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d by_both_ = Eigen::Matrix3d::Zero();
  double pairs_ = 0;

  int far_off_tilt_ = 0, far_off_heading_ = 0;  ///< pairs in a row
  bool tilt_told_ = false, heading_told_ = false;
};

}  // namespace nadir::reference

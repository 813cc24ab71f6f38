// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What depth to expect at a place of an image: the ground is nearly a plane (whose inverse depth is
// linear in normalised coordinates), and relief is alike in the neighbourhood.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nadir::odometry {

struct DepthSample {
  Eigen::Vector2d ray;
  double inverse_depth = 0;  ///< along the optical axis
};

class DepthPrior {
 public:
  explicit DepthPrior(std::vector<DepthSample> samples);

  struct Guess {
    double inverse_depth = 0;
    double spread = 0;  ///< half of the range to search
  };
  Guess at(const Eigen::Vector2d& ray) const;

  /// Of the ground, in the camera frame; towards +z.
  Eigen::Vector3d normal() const;

  bool known() const { return known_; }

 private:
  std::vector<DepthSample> samples_;  ///< inverse_depth replaced by its residual to the plane
  Eigen::Vector3d plane_ = Eigen::Vector3d::Zero();  ///< inverse depth = plane . (x, y, 1)
  double relief_ = 0;                                ///< bound of the residuals to the plane
  bool known_ = false;
};

}  // namespace nadir::odometry

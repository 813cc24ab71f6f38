// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What depth to expect at a place of an image: the ground is nearly a plane (whose inverse depth is
// linear in normalised coordinates), and relief is alike in the neighbourhood.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
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
  static constexpr std::size_t kNeighbours = 6;
  struct Neighbour {
    double squared_distance = 1e300;  ///< of the rays
    double residual = 0;              ///< of the inverse depth, to the plane
  };
  /// The nearest first.
  std::array<Neighbour, kNeighbours> nearest(const Eigen::Vector2d& ray) const;

  /// By x of the ray; inverse_depth replaced by its residual to the plane.
  std::vector<DepthSample> samples_;
  Eigen::Vector3d plane_ = Eigen::Vector3d::Zero();  ///< inverse depth = plane . (x, y, 1)
  double relief_ = 0;                                ///< bound of the residuals to the plane
  bool known_ = false;
};

}  // namespace nadir::odometry

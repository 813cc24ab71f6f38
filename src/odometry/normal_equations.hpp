// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The normal equations of a bundle adjustment, its tie points eliminated (Triggs et al., Bundle
// Adjustment - A Modern Synthesis, 2000, section 6; Cauchy's loss by reweighting).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "nadir/odometry/bundle_adjustment.hpp"

namespace nadir::odometry {

/// What an adjustment looks for.
struct Unknowns {
  std::vector<Rigid3> camera_from_map;
  std::vector<Eigen::Vector3d> points;  ///< x_in_map
  Eigen::Vector3d up;                   ///< of the map, unit length

  bool is_finite() const;
};

class NormalEquations {
 public:
  /// Observations whose tie point lies behind their camera are left out.
  NormalEquations(const Adjustment& adjustment, const CameraRig& rig, double robust_px);

  /// As the adjustment gives them.
  Unknowns start() const;

  /// Half the robust sum of squares, px2; infinite where a tie point would be behind a camera.
  double cost(const Unknowns& at) const;

  void linearise(const Unknowns& at);

  struct Step {
    Unknowns there;
    double expected = 0;  ///< decrease of the cost
  };
  /// From where they were linearised, the diagonal grown by the damping (Levenberg-Marquardt); none
  /// where that determines nothing.
  std::optional<Step> step(const Unknowns& from, double damping) const;

  /// Of the free images' (rotation vector, translation), small and applied from the left;
  /// symmetric. Of an adjustment whose vertical is not looked for.
  Eigen::MatrixXd reduced() const;

  /// First column of an image, -1 when it is fixed or sees nothing.
  int column_of(int image) const;
  bool has_unknowns() const { return unknowns() > 0 || eliminated() > 0; }
  /// Free tie points that are seen.
  int eliminated() const;

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Matrix63 = Eigen::Matrix<double, 6, 3>;
  using Matrix62 = Eigen::Matrix<double, 6, 2>;

  struct Seen {
    int image = 0, point = 0;
    int cell = -1;  ///< -1: image or point is fixed
    bool right = false;
    Eigen::Vector2d ray;
    double weight = 1;
  };
  struct Point {
    bool free = false, seen = false;
    int first_cell = 0, end_cell = 0;
    std::size_t first_slot = 0;
    Eigen::Matrix3d normal;
    Eigen::Vector3d gradient;
  };
  /// A free point in a free image.
  struct Cell {
    int pose = 0;
    Matrix63 cross;
  };
  struct Camera {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
  };
  /// The equations of poses and vertical once the points are eliminated.
  struct Reduced {
    std::vector<Matrix6> blocks;
    Eigen::VectorXd gradient;
    std::vector<Eigen::Matrix3d> inverse;  ///< of the points' damped normal matrices
  };

  std::vector<Camera> left_cameras(const Unknowns& at) const;
  std::vector<Camera> right_cameras(const std::vector<Camera>& left) const;
  double robust(double squares) const;  ///< Cauchy's loss of them
  void add_structure();
  void number_poses();
  void add_observations(const Unknowns& at);
  void add_verticals(const Unknowns& at);
  template <class Visit>
  void for_each_sensor(const Unknowns& at, Visit visit) const;
  void add_sensors(const Unknowns& at);
  void hold_distances(const Unknowns& at);
  Reduced reduce(double damping) const;
  std::optional<Eigen::VectorXd> solve(const Reduced& reduced, double damping) const;
  Unknowns moved(const Unknowns& from, const Eigen::VectorXd& poses,
                 const std::vector<Eigen::Vector3d>& points) const;
  bool is_up_free() const { return !a_.verticals.empty() && !a_.up_in_map; }
  static Eigen::Index row_of(int pose) { return Eigen::Index{6} * pose; }
  int unknowns() const { return 6 * poses_ + (is_up_free() ? 2 : 0); }

  const Adjustment& a_;
  double robust_px_;
  Camera right_from_left_;
  std::array<double, 2> focal_;  ///< of the left and the right camera

  std::vector<Seen> seen_;  ///< by point, then by image
  std::vector<Point> points_;
  std::vector<Cell> cells_;
  std::vector<int> pose_of_;  ///< by image; -1: fixed
  int poses_ = 0;
  std::vector<std::pair<int, int>> block_poses_;  ///< the first not after the second
  std::vector<int> slots_;                        ///< block of each pair of cells, point by point

  std::vector<Matrix6> blocks_;
  std::vector<std::pair<int, Eigen::Matrix3d>> held_;  ///< distances of poses
  std::vector<Matrix62> by_up_;
  Eigen::Matrix2d up_normal_;
  Eigen::Matrix<double, 3, 2> up_tangent_;
  Eigen::VectorXd gradient_;  ///< minus that of the cost
};

}  // namespace nadir::odometry

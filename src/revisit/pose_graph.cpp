// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pose_graph.hpp"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glog/logging.h>

#include <array>
#include <cmath>

namespace nadir::revisit {
namespace {

using Pose = std::array<double, 8>;  // quaternion x y z w, translation, logarithm of the scale
using PoseManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<4>>;

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

// Difference of first_from_second as the poses have it and as it was measured, over its sigmas.
struct Difference {
  Edge edge;

  template <class T>
  bool operator()(const T* first, const T* second, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q1(first), q2(second);
    const Eigen::Map<const Vector3<T>> t1(first + 4), t2(second + 4);
    const Eigen::Quaternion<T> back = q2.conjugate();
    const Eigen::Quaternion<T> rotation =
        back * q1 * edge.second_from_first.rigid.rotation.conjugate().template cast<T>();
    const Vector3<T> translation = back * (t1 - t2) * exp(-second[7]);
    Vector3<T> turn;
    const T ordered[4] = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
    ceres::QuaternionToAngleAxis(ordered, turn.data());
    Eigen::Map<Eigen::Matrix<T, 7, 1>> error(residuals);
    error.template head<3>() = turn / T(edge.sigma_rotation);
    error.template segment<3>(3) =
        (translation - edge.second_from_first.rigid.translation.template cast<T>()) /
        T(edge.sigma_translation);
    error(6) =
        (first[7] - second[7] - T(std::log(edge.second_from_first.scale))) / T(edge.sigma_scale);
    return true;
  }
};

Pose to_parameters(const Similarity3& s) {
  const auto& q = s.rigid.rotation;
  const auto& t = s.rigid.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z(), std::log(s.scale)};
}

Similarity3 to_similarity(const Pose& p) {
  return {std::exp(p[7]),
          {Eigen::Quaterniond(p[3], p[0], p[1], p[2]).normalized(), {p[4], p[5], p[6]}}};
}

}  // namespace

bool optimise(std::vector<Similarity3>& poses, const std::vector<Edge>& edges,
              const std::vector<int>& fixed) {
  constexpr double kDoubtful = 3;  // sigmas, from where a robust edge weighs ever less
  std::vector<Pose> parameters;
  parameters.reserve(poses.size());
  for (const Similarity3& pose : poses) parameters.push_back(to_parameters(pose));
  PoseManifold manifold;
  ceres::CauchyLoss loss(kDoubtful);
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (const Edge& edge : edges) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Difference, 7, 8, 8>(new Difference{edge}),
        edge.robust ? &loss : nullptr, parameters[static_cast<std::size_t>(edge.first)].data(),
        parameters[static_cast<std::size_t>(edge.second)].data());
  }
  for (Pose& pose : parameters) {
    if (problem.HasParameterBlock(pose.data())) problem.SetManifold(pose.data(), &manifold);
  }
  for (const int i : fixed) {
    double* pose = parameters[static_cast<std::size_t>(i)].data();
    if (problem.HasParameterBlock(pose)) problem.SetParameterBlockConstant(pose);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 50;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  // What a solver could not do is in its summary; the diver's terminal is not its log.
  [[maybe_unused]] static const int kQuiet = FLAGS_minloglevel = google::GLOG_FATAL;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return false;
  std::vector<Similarity3> solved;
  solved.reserve(parameters.size());
  for (const Pose& pose : parameters) {
    solved.push_back(to_similarity(pose));
    const Similarity3& s = solved.back();
    if (!s.rigid.is_finite() || !std::isfinite(s.scale) || !(s.scale > 0)) return false;
  }
  poses = std::move(solved);
  return true;
}

}  // namespace nadir::revisit

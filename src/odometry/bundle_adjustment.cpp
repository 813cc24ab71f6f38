// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/bundle_adjustment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "normal_equations.hpp"

namespace nadir::odometry {
namespace {

double error_px(const Adjustment& a, const CameraRig& rig, const Adjustment::Observation& o) {
  Eigen::Vector3d x = a.images[static_cast<std::size_t>(o.image)].camera_from_map *
                      a.points[static_cast<std::size_t>(o.point)].x_in_map;
  if (o.right) x = rig.right->right_from_left * x;
  if (!(x.z() > 1e-6)) return std::numeric_limits<double>::infinity();
  const double error = (x.head<2>() / x.z() - o.ray).norm();
  return (o.right ? rig.right->camera : rig.left).mean_focal() * error;
}

double robust_rms(Adjustment& a, const CameraRig& rig, double robust_px) {
  double sum = 0, weights = 0;
  for (auto& o : a.observations) {
    o.error_px = error_px(a, rig, o);
    if (!std::isfinite(o.error_px)) continue;
    const double ratio = o.error_px / robust_px, weight = 1 / (1 + ratio * ratio);
    sum += weight * o.error_px * o.error_px;
    weights += weight;
  }
  return weights > 0 ? std::sqrt(sum / weights) : 0.0;
}

// Levenberg's and Marquardt's damping with Nielsen's steps of it.
class Damping {
 public:
  double value() const { return value_; }
  void accept(double gain) {
    value_ *= std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3));
    growth_ = 2;
  }
  void reject() {
    value_ *= growth_;
    growth_ *= 2;
  }

 private:
  double value_ = 1e-4, growth_ = 2;
};

struct Solution {
  Unknowns unknowns;
  int iterations = 0;
  bool converged = false;
  bool solvable = false;
};

Solution solve(NormalEquations& equations, const AdjustmentOptions& options) {
  constexpr double kLeastGain = 1e-3;  // of what was expected
  constexpr double kNothing = 1e-9;    // px2; of a cost without noise there is no share to ask for
  constexpr double kShortened = 1;     // with more damping a small step says nothing
  constexpr double kHopeless = 1e12;
  Solution solution{equations.start()};
  double cost = equations.cost(solution.unknowns);
  equations.linearise(solution.unknowns);
  Damping damping;
  while (solution.iterations < options.iterations && damping.value() < kHopeless) {
    ++solution.iterations;
    auto step = equations.step(solution.unknowns, damping.value());
    if (!step) {
      damping.reject();
      continue;
    }
    solution.solvable = true;
    const double least = options.tolerance * (cost + kNothing);
    const double decrease = cost - equations.cost(step->there);
    solution.converged = step->expected <= least && damping.value() < kShortened;
    if (decrease > kLeastGain * step->expected) {
      solution.unknowns = std::move(step->there);
      cost -= decrease;
      solution.converged = solution.converged || decrease <= least;
      if (solution.converged) break;
      damping.accept(decrease / step->expected);
      equations.linearise(solution.unknowns);
    } else {
      if (solution.converged) break;
      damping.reject();
    }
  }
  return solution;
}

}  // namespace

AdjustmentSummary adjust(Adjustment& a, const CameraRig& rig, const AdjustmentOptions& options) {
  NormalEquations equations(a, rig, options.robust_px);
  const Solution solution = solve(equations, options);
  AdjustmentSummary result;
  result.usable = solution.unknowns.is_finite() && (solution.solvable || !equations.has_unknowns());
  result.iterations = solution.iterations;
  result.converged = solution.converged;
  if (result.usable) {
    for (std::size_t i = 0; i < a.images.size(); ++i) {
      a.images[i].camera_from_map = solution.unknowns.camera_from_map[i];
    }
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      a.points[i].x_in_map = solution.unknowns.points[i];
    }
  }
  result.rms_px = robust_rms(a, rig, options.robust_px);
  return result;
}

}  // namespace nadir::odometry

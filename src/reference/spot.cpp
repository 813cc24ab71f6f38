// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "spot.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace nadir::reference {
namespace {

using Eigen::Vector2d;

// Centre x, y (from the start); log sigma; amplitude; background at the start and its slope x, y.
using Parameters = Eigen::Matrix<double, 7, 1>;
using Normal = Eigen::Matrix<double, 7, 7>;

struct Sample {
  Vector2d place;  ///< px from the start
  double value = 0;
  bool at_least = false;
};

std::vector<Sample> samples(const cv::Mat1f& image, const cv::Mat1b& at_least,
                            const Vector2d& start, double radius) {
  std::vector<Sample> samples;
  const int left = static_cast<int>(std::ceil(start.x() - radius));
  const int right = static_cast<int>(std::floor(start.x() + radius));
  const int top = static_cast<int>(std::ceil(start.y() - radius));
  const int bottom = static_cast<int>(std::floor(start.y() + radius));
  if (left < 0 || top < 0 || right >= image.cols || bottom >= image.rows) return {};
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const Vector2d place = Vector2d(x, y) - start;
      if (place.norm() > radius) continue;
      samples.push_back({place, image(y, x), at_least(y, x) != 0});
    }
  }
  return samples;
}

Parameters first_guess(const std::vector<Sample>& samples, double radius) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const Sample& sample : samples) values.push_back(sample.value);
  std::sort(values.begin(), values.end());
  const double background = values[values.size() / 3];
  Parameters p = Parameters::Zero();
  p(2) = std::log(radius / 4);
  p(3) = values.back() - background;
  p(4) = background;
  return p;
}

struct Linearised {
  Normal information = Normal::Zero();
  Parameters gradient = Parameters::Zero();
  double squares = 0;
  int counted = 0;  ///< samples that say something
};

Linearised linearise(const std::vector<Sample>& samples, const Parameters& p) {
  Linearised at;
  const double s = std::exp(p(2));
  for (const Sample& sample : samples) {
    const Vector2d from = sample.place - p.head<2>();
    const double bell = std::exp(-from.squaredNorm() / (2 * s * s));
    const double residual = p(3) * bell + p(4) + p.tail<2>().dot(sample.place) - sample.value;
    if (sample.at_least && residual > 0) continue;
    Parameters slope;
    slope.head<2>() = p(3) * bell / (s * s) * from;
    slope(2) = p(3) * bell * from.squaredNorm() / (s * s);
    slope(3) = bell;
    slope(4) = 1;
    slope.tail<2>() = sample.place;
    at.information += slope * slope.transpose();
    at.gradient += residual * slope;
    at.squares += residual * residual;
    ++at.counted;
  }
  return at;
}

}  // namespace

std::optional<Spot> fit_spot(const cv::Mat1f& image, const cv::Mat1b& at_least,
                             const Vector2d& start, double radius) {
  constexpr int kIterations = 40;
  constexpr double kConverged_px = 1e-4;
  constexpr std::size_t kMinSamples = 21;  // three for each parameter
  const std::vector<Sample> seen = samples(image, at_least, start, radius);
  if (seen.size() < kMinSamples) return std::nullopt;
  Parameters p = first_guess(seen, radius);
  Linearised at = linearise(seen, p);
  double damping = 1e-3;
  for (int i = 0; i < kIterations; ++i) {
    Normal damped = at.information;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-9;
    const Parameters step = damped.ldlt().solve(at.gradient);
    const Linearised next = linearise(seen, p - step);
    if (step.allFinite() && next.squares <= at.squares) {
      p -= step;
      at = next;
      damping *= 0.3;
      if (step.head<3>().norm() < kConverged_px) break;
    } else {
      damping *= 5;
    }
  }
  const int surplus = at.counted - static_cast<int>(Parameters::RowsAtCompileTime);
  const double sigma = std::exp(p(2));
  if (surplus < 1 || !p.allFinite() || p(3) <= 0 || p.head<2>().norm() > radius / 2 ||
      sigma > radius) {
    return std::nullopt;
  }
  Spot spot;
  spot.centre = start + p.head<2>();
  spot.amplitude = p(3);
  spot.sigma = sigma;
  spot.background = p(4) + p.tail<2>().dot(p.head<2>());
  spot.slope = p.tail<2>();
  spot.rms = std::sqrt(at.squares / surplus);
  const Normal covariance = at.information.ldlt().solve(Normal::Identity());
  spot.sigma_centre =
      spot.rms * std::sqrt(std::max(0.0, (covariance(0, 0) + covariance(1, 1)) / 2));
  return spot;
}

}  // namespace nadir::reference

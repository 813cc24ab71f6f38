// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "patch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "nadir/core/clones.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d, Eigen::Vector2f;

constexpr float kMinContrast = 15.0F;  // norm of the grey levels about their mean, 1.4 per px
constexpr float kMinTexture = 0.02F;   // smaller eigenvalue of the normalised structure tensor
constexpr double kMaxScale2 = 2.6;     // of areas, between two images of one tie point
constexpr float kWhole = 4096;
constexpr int kIterations = 12;
constexpr double kConverged = 0.01;  // px
constexpr double kAlike = 0.98;      // correlation that needs no change of shape
constexpr double kUnlike = 0.5;      // correlation from which no change of shape leads back
constexpr float kMaxStrain = 0.45F;  // of the template's shape
constexpr double kMaxDrift = 3.0;    // px from the start

// Grey level at an offset from the patch's centre; beyond its border that of the border.
inline float sample(const Patch& patch, float x, float y) {
  constexpr float kLast = Patch::kSide - 1.001F;
  x = std::min(std::max(x + Patch::kRadius, 0.0F), kLast);
  y = std::min(std::max(y + Patch::kRadius, 0.0F), kLast);
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float a = x - static_cast<float>(column), b = y - static_cast<float>(row);
  const std::uint8_t* p = patch.grey.data() + std::ptrdiff_t{row} * Patch::kSide + column;
  const auto at = [p](int i) { return static_cast<float>(p[i]); };
  return (1 - b) * ((1 - a) * at(0) + a * at(1)) +
         b * ((1 - a) * at(Patch::kSide) + a * at(Patch::kSide + 1));
}

bool inside(const cv::Mat& grey, int x, int y, int margin) {
  return x >= margin && y >= margin && x < grey.cols - margin && y < grey.rows - margin;
}

// Grey levels around a sub-pixel place, zero mean and unit norm; false without contrast.
NADIR_CLONES
bool normalised_window(const cv::Mat& grey, const Vector2d& pixel, Template::Values& window) {
  const int left = static_cast<int>(std::floor(pixel.x())),
            top = static_cast<int>(std::floor(pixel.y()));
  const auto a = static_cast<float>(pixel.x() - left), b = static_cast<float>(pixel.y() - top);
  const float w00 = (1 - a) * (1 - b), w01 = a * (1 - b), w10 = (1 - a) * b, w11 = a * b;
  int i = 0;
  for (int dy = -Template::kRadius; dy <= Template::kRadius; ++dy) {
    const std::uint8_t* upper = grey.ptr(top + dy) + left - Template::kRadius;
    const std::uint8_t* lower = grey.ptr(top + dy + 1) + left - Template::kRadius;
    for (int k = 0; k < Template::kSide; ++k, ++i) {
      window[i] = w00 * static_cast<float>(upper[k]) + w01 * static_cast<float>(upper[k + 1]) +
                  w10 * static_cast<float>(lower[k]) + w11 * static_cast<float>(lower[k + 1]);
    }
  }
  window.array() -= window.mean();
  const float norm = window.norm();
  if (!(norm > 1.0F)) return false;
  window /= norm;
  return true;
}

NADIR_CLONES
std::optional<Sight> refine_shift(const Template& wanted, const cv::Mat& grey,
                                  const Vector2d& start) {
  Vector2d pixel = start;
  Template::Values window;
  for (int i = 0; i < kIterations; ++i) {
    if (!(pixel - start).allFinite() || (pixel - start).norm() > kMaxDrift) return std::nullopt;
    if (!inside(grey, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()),
                Template::kRadius + 1))
      return std::nullopt;
    if (!normalised_window(grey, pixel, window)) return std::nullopt;
    const Vector2f step =
        wanted.inverse_normal * (wanted.gradient.transpose() * (wanted.value - window));
    if (step.norm() < kConverged) {
      return Sight{pixel + step.cast<double>(), wanted.value.dot(window)};
    }
    pixel += step.cast<double>();
  }
  return std::nullopt;
}

// Grey levels at pixel + shape * offset, zero mean and unit norm; false outside or without
// contrast.
NADIR_CLONES
bool normalised_window(const cv::Mat& grey, const Vector2f& pixel, const Eigen::Matrix2f& shape,
                       Template::Values& window) {
  const Vector2f reach = Template::kRadius * shape.cwiseAbs().rowwise().sum();
  if (!(pixel.x() > reach.x() + 1 && pixel.y() > reach.y() + 1 &&
        pixel.x() < static_cast<float>(grey.cols - 2) - reach.x() &&
        pixel.y() < static_cast<float>(grey.rows - 2) - reach.y()))
    return false;
  int i = 0;
  for (int dy = -Template::kRadius; dy <= Template::kRadius; ++dy) {
    for (int dx = -Template::kRadius; dx <= Template::kRadius; ++dx, ++i) {
      const Vector2f at = pixel + shape * Vector2f(static_cast<float>(dx), static_cast<float>(dy));
      const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
      const float a = at.x() - static_cast<float>(column), b = at.y() - static_cast<float>(row);
      const std::uint8_t* upper = grey.ptr(row) + column;
      const std::uint8_t* lower = grey.ptr(row + 1) + column;
      window[i] =
          (1 - b) * ((1 - a) * static_cast<float>(upper[0]) + a * static_cast<float>(upper[1])) +
          b * ((1 - a) * static_cast<float>(lower[0]) + a * static_cast<float>(lower[1]));
    }
  }
  window.array() -= window.mean();
  const float norm = window.norm();
  if (!(norm > 1.0F)) return false;
  window /= norm;
  return true;
}

// From the centre of a template, x and y.
const Eigen::Matrix<float, Template::kArea, 2>& offsets() {
  static const auto kOffsets = [] {
    Eigen::Matrix<float, Template::kArea, 2> result;
    for (int i = 0; i < Template::kArea; ++i) {
      const int column = i % Template::kSide, row = i / Template::kSide;
      result(i, 0) = static_cast<float>(column - Template::kRadius);
      result(i, 1) = static_cast<float>(row - Template::kRadius);
    }
    return result;
  }();
  return kOffsets;
}

// Six parameters: shift and shape.
NADIR_CLONES
std::optional<Sight> refine_shape(const Template& wanted, const cv::Mat& grey,
                                  const Vector2d& start) {
  using Vector6f = Eigen::Matrix<float, 6, 1>;
  Eigen::Matrix<float, Template::kArea, 6> design;
  const auto& offset = offsets();
  for (int axis = 0; axis < 2; ++axis) {
    const auto gradient = wanted.gradient.col(axis);
    design.col(axis) = gradient;
    design.col(2 + 2 * axis) = gradient.cwiseProduct(offset.col(0));
    design.col(3 + 2 * axis) = gradient.cwiseProduct(offset.col(1));
  }
  for (int i = 0; i < 6; ++i) {
    auto column = design.col(i);
    column.array() -= column.mean();
    column -= wanted.value.dot(column) * wanted.value;
  }
  // A product of this size is not worth the blocks of a large one.
  Eigen::Matrix<float, 6, 6> normal = design.transpose().lazyProduct(design);
  normal.diagonal() *= 1.001F;
  const Eigen::LLT<Eigen::Matrix<float, 6, 6>> solver(normal);
  if (solver.info() != Eigen::Success) return std::nullopt;
  Vector2f pixel = start.cast<float>();
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();
  Template::Values window;
  for (int i = 0; i < kIterations; ++i) {
    if (!((pixel.cast<double>() - start).norm() < kMaxDrift)) return std::nullopt;
    if (!((shape - Eigen::Matrix2f::Identity()).cwiseAbs().maxCoeff() < kMaxStrain))
      return std::nullopt;
    if (!normalised_window(grey, pixel, shape, window)) return std::nullopt;
    const Vector6f step = solver.solve(design.transpose() * (wanted.value - window));
    if (step.head<2>().norm() < kConverged && step.tail<4>().norm() < 0.01F) {
      return Sight{(pixel + step.head<2>()).cast<double>(), wanted.value.dot(window)};
    }
    pixel += step.head<2>();
    shape += Eigen::Matrix2f{{step[2], step[3]}, {step[4], step[5]}};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Patch> cut_patch(const cv::Mat& grey, const Eigen::Vector2i& centre) {
  if (!inside(grey, centre.x(), centre.y(), Patch::kRadius)) return std::nullopt;
  Patch patch;
  auto* to = patch.grey.begin();
  for (int row = 0; row < Patch::kSide; ++row) {
    const std::uint8_t* from =
        grey.ptr(centre.y() - Patch::kRadius + row) + centre.x() - Patch::kRadius;
    to = std::copy(from, from + Patch::kSide, to);
  }
  return patch;
}

NADIR_CLONES
std::optional<Template> warp_patch(const Patch& patch, const Matrix2d& image_from_patch) {
  const double area = image_from_patch.determinant();
  if (!(area > 1 / kMaxScale2 && area < kMaxScale2)) return std::nullopt;
  const Eigen::Matrix2f back = image_from_patch.inverse().cast<float>();
  constexpr int kReach = Template::kRadius + 1, kWide = 2 * kReach + 1;
  std::array<float, std::size_t{kWide} * kWide> wide;
  for (int row = 0, i = 0; row < kWide; ++row) {
    for (int column = 0; column < kWide; ++column, ++i) {
      const Vector2f d =
          back * Vector2f(static_cast<float>(column - kReach), static_cast<float>(row - kReach));
      wide[static_cast<std::size_t>(i)] = sample(patch, d.x(), d.y());
    }
  }
  Template result;
  for (int row = 0, i = 0; row < Template::kSide; ++row) {
    for (int column = 0; column < Template::kSide; ++column, ++i) {
      const float* at =
          &wide[static_cast<std::size_t>(row + 1) * kWide + static_cast<std::size_t>(column + 1)];
      result.value[i] = *at;
      result.gradient.row(i) << 0.5F * (at[1] - at[-1]), 0.5F * (at[kWide] - at[-kWide]);
    }
  }
  result.value.array() -= result.value.mean();
  const float norm = result.value.norm();
  if (!(norm > kMinContrast)) return std::nullopt;
  result.value /= norm;
  constexpr float kRaised = kWhole + 0.5F;  // what is above zero is rounded by truncating
  for (int i = 0; i < Template::kArea; ++i) {
    result.whole[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(
        static_cast<int>(kWhole * result.value[i] + kRaised) - static_cast<int>(kWhole));
  }
  result.gradient /= norm;
  result.gradient.rowwise() -= result.gradient.colwise().mean().eval();
  // The normalisation takes the part along the value itself out of the gradients, too.
  for (int axis = 0; axis < 2; ++axis) {
    auto gradient = result.gradient.col(axis);
    gradient -= result.value.dot(gradient) * result.value;
  }
  const Eigen::Matrix2f normal = result.gradient.transpose().lazyProduct(result.gradient);
  const float smaller =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f>(normal, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  if (!(smaller > kMinTexture)) return std::nullopt;
  result.inverse_normal = normal.inverse();
  return result;
}

NADIR_CLONES
float correlation(const Template& wanted, const cv::Mat& grey, int x, int y) {
  if (!inside(grey, x, y, Template::kRadius)) return -1.0F;
  std::array<std::int16_t, Template::kArea> window;
  auto* to = window.begin();
  for (int row = 0; row < Template::kSide; ++row) {
    const std::uint8_t* at = grey.ptr(y - Template::kRadius + row) + x - Template::kRadius;
    to = std::copy(at, at + Template::kSide, to);
  }
  int dot = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    dot += window[i] * wanted.whole[i];
    sum += window[i];
    squares += window[i] * window[i];
  }
  const auto total = static_cast<float>(sum);
  const float variance = static_cast<float>(squares) - total * total / Template::kArea;
  return variance > 1.0F ? static_cast<float>(dot) / kWhole / std::sqrt(variance) : -1.0F;
}

Sight search(const Template& wanted, const cv::Mat& grey, const Vector2d& start, int radius) {
  const int x0 = static_cast<int>(std::lround(start.x())),
            y0 = static_cast<int>(std::lround(start.y()));
  Sight best{start, -1};
  for (int y = y0 - radius; y <= y0 + radius; ++y) {
    for (int x = x0 - radius; x <= x0 + radius; ++x) {
      const float c = correlation(wanted, grey, x, y);
      if (c > best.correlation) best = {Vector2d(x, y), c};
    }
  }
  return best;
}

std::optional<Sight> refine(const Template& wanted, const cv::Mat& grey, const Vector2d& start) {
  auto shifted = refine_shift(wanted, grey, start);
  if (shifted && (shifted->correlation > kAlike || shifted->correlation < kUnlike)) return shifted;
  auto reshaped = refine_shape(wanted, grey, shifted ? shifted->pixel : start);
  if (reshaped && (!shifted || reshaped->correlation > shifted->correlation)) return reshaped;
  return shifted;
}

}  // namespace nadir::odometry

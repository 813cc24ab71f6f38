// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "light.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "nadir/core/clones.hpp"

namespace nadir::mosaic2d {
namespace {

constexpr int kCellsAcross = 24;
constexpr int kMemory = 64;     // images; a lamp that fails or a changed set-up is forgotten
constexpr float kDark = 4;      // grey levels added before the logarithm: noise has no pattern
constexpr double kMaxGain = 4;  // beyond it there is more noise than seabed
constexpr int kUnitBits = 8;

cv::Size cells(cv::Size image) {
  return {kCellsAcross, std::max(1, kCellsAcross * image.height / image.width)};
}

// Early on every image changes the mean, later few do.
bool worth_updating(int images) { return images <= 16 || images % 8 == 0; }

// The middle of a grey level times the gain, in the 16-bit products compilers vectorise.
NADIR_CLONES
void scale(const std::uint8_t* in, const std::uint16_t* gain, std::uint8_t* out, int count) {
  for (int i = 0; i < count; ++i) {
    const auto middle = static_cast<std::uint16_t>((in[i] << 8) + 128);
    const auto value = static_cast<std::uint16_t>((std::uint32_t{middle} * gain[i]) >> 16);
    out[i] = static_cast<std::uint8_t>(value < 255 ? value : 255);
  }
}

// What the seabed leaves in the mean fades with the square root of the number of images, and so may
// the smoothing that keeps it out.
cv::Mat gain_of(const cv::Mat& mean_log, int images, cv::Size size) {
  cv::Mat smooth, fine;
  const double sigma = std::max(0.7, 3 / std::sqrt(images));  // cells
  cv::GaussianBlur(mean_log, smooth, {}, sigma, sigma, cv::BORDER_REPLICATE);
  const cv::Scalar level = cv::mean(smooth);
  smooth.forEach<cv::Vec3f>([&](cv::Vec3f& cell, const int*) {
    for (int c = 0; c < 3; ++c) {
      const double gain = std::exp(level[c] - static_cast<double>(cell[c]));
      cell[c] = static_cast<float>(std::clamp(gain, 1 / kMaxGain, kMaxGain) * (1 << kUnitBits));
    }
  });
  smooth.convertTo(smooth, CV_16U);
  cv::resize(smooth, fine, size, 0, 0, cv::INTER_LINEAR);
  return fine;
}

}  // namespace

void LampPattern::learn(const cv::Mat& bgr) {
  cv::Mat some, small, log;
  // Some hundred pixels of a cell tell its mean as well as some thousand.
  const int divisor = bgr.cols > kCellsAcross * 40 ? 4 : 1;
  cv::resize(bgr, some, bgr.size() / divisor, 0, 0, cv::INTER_NEAREST);
  cv::resize(some, small, cells(bgr.size()), 0, 0, cv::INTER_AREA);
  small.convertTo(log, CV_32F);
  cv::log(log + cv::Scalar::all(kDark), log);
  if (mean_log_.size() != log.size() || gain_.size() != bgr.size()) images_ = 0;
  ++images_;
  if (images_ == 1) {
    mean_log_ = log;
  } else {
    const double weight = 1.0 / std::min(images_, kMemory);
    cv::addWeighted(mean_log_, 1 - weight, log, weight, 0, mean_log_);
  }
  if (worth_updating(images_)) gain_ = gain_of(mean_log_, images_, bgr.size());
}

cv::Mat LampPattern::flatten(const cv::Mat& bgr) {
  learn(bgr);
  cv::Mat flat(bgr.size(), CV_8UC3);
  for (int row = 0; row < bgr.rows; ++row) {
    scale(bgr.ptr<std::uint8_t>(row), gain_.ptr<std::uint16_t>(row), flat.ptr<std::uint8_t>(row),
          3 * bgr.cols);
  }
  return flat;
}

void apply_gain(cv::Mat& bgra, const cv::Vec3d& gain) {
  constexpr double kUnit = 1 << kUnitBits;
  std::vector<std::uint16_t> factors(static_cast<std::size_t>(4 * bgra.cols), 1 << kUnitBits);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (i % 4 == 3) continue;
    const double factor = std::round(gain[static_cast<int>(i % 4)] * kUnit);
    factors[i] = static_cast<std::uint16_t>(std::clamp(factor, 0.0, 2 * kUnit - 1));  // 0 stays 0
  }
  for (int row = 0; row < bgra.rows; ++row) {
    auto* values = bgra.ptr<std::uint8_t>(row);
    scale(values, factors.data(), values, 4 * bgra.cols);
  }
}

}  // namespace nadir::mosaic2d

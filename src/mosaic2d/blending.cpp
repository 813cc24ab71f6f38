// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "blending.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nadir::mosaic2d {
namespace {

constexpr float kFeather = 16;  // px: half the width over which two images pass into each other
constexpr int kFarInside = 32;  // px: borders farther than the whole width do not matter

// Signed distance of a pixel to the line half way between two image centres, positive on the side
// of the newer. It is linear along a row.
struct Bisector {
  float along_column = 0, along_row = 0, at_origin = -kFeather;

  Bisector(const cv::Point2d& older, const cv::Point2d& newer, const cv::Point& origin) {
    const cv::Point2d step = newer - older;
    const double length = std::hypot(step.x, step.y);
    if (length < 1) return;  // the same view again: the older stays
    const cv::Point2d from_middle = cv::Point2d(origin) - (older + newer) * 0.5;
    along_column = static_cast<float>(step.x / length);
    along_row = static_cast<float>(step.y / length);
    at_origin = static_cast<float>(from_middle.dot(step) / length);
  }
  float operator()(int column, int row) const {
    return at_origin + along_column * static_cast<float>(column) +
           along_row * static_cast<float>(row);
  }
};

// The newer image's share in 1/256: by the bisector, but none at its own border, and all of it at
// the border of what is there unless its own is as near.
int share(float bisector, int newer_border, int older_border) {
  float x = std::max(bisector, static_cast<float>(newer_border - older_border) - kFeather);
  x = std::min(x, static_cast<float>(newer_border) - kFeather);
  x = std::clamp(x, -kFeather, kFeather);
  return static_cast<int>((x + kFeather) * (128 / kFeather));
}

// min(value, neighbour + step) along a row, for all pixels at once.
void approach(std::uint8_t* values, const std::uint8_t* neighbours, int step, int count) {
  for (int i = 0; i < count; ++i) {
    const auto far = static_cast<std::uint8_t>(neighbours[i] + step);
    values[i] = values[i] < far ? values[i] : far;
  }
}

// The distance along a row by doubling: neighbours at 1, 2, 4, ... px on either side.
void along_row(std::uint8_t* row, std::vector<std::uint8_t>& padded, int count) {
  for (int step = 1; step < kFarInside; step *= 2) {
    std::fill(padded.begin(), padded.end(), std::uint8_t{0});
    std::copy(row, row + count, padded.begin() + step);
    const std::uint8_t* left = padded.data();
    const std::uint8_t* right = left + step + step;
    approach(row, left, step, count);
    approach(row, right, step, count);
  }
}

// From alpha, in place.
void to_border_distance(cv::Mat& mask) {
  const int count = mask.cols, rows = mask.rows;
  cv::min(mask, kFarInside, mask);
  std::vector<std::uint8_t> padded(static_cast<std::size_t>(count + 2 * kFarInside));
  const std::vector<std::uint8_t> outside(static_cast<std::size_t>(count), 0);
  for (int row = 0; row < rows; ++row) along_row(mask.ptr<std::uint8_t>(row), padded, count);
  for (int row = 0; row < rows; ++row) {
    const auto* above = row > 0 ? mask.ptr<std::uint8_t>(row - 1) : outside.data();
    approach(mask.ptr<std::uint8_t>(row), above, 1, count);
  }
  for (int row = rows - 1; row >= 0; --row) {
    const auto* below = row + 1 < rows ? mask.ptr<std::uint8_t>(row + 1) : outside.data();
    approach(mask.ptr<std::uint8_t>(row), below, 1, count);
  }
}

std::uint8_t mix(int older, int newer, int share) {
  return static_cast<std::uint8_t>((older * (256 - share) + newer * share + 128) >> 8);
}

cv::Vec4b mix(const cv::Vec4b& older, const cv::Vec4b& newer, int share) {
  return {mix(older[0], newer[0], share), mix(older[1], newer[1], share),
          mix(older[2], newer[2], share), 255};
}

}  // namespace

Outline outline(const cv::Mat& bgra) {
  Outline outline;
  cv::extractChannel(bgra, outline.border, 3);
  const cv::Moments moments = cv::moments(outline.border);
  if (moments.m00 > 0) {
    outline.centre = cv::Point2d(moments.m10 / moments.m00, moments.m01 / moments.m00);
  }
  to_border_distance(outline.border);
  return outline;
}

bool blend_patch(const Patch& from, Ground onto, cv::Point origin,
                 const std::vector<cv::Point2d>& centres) {
  const auto newest = static_cast<std::int32_t>(centres.size()) - 1;
  std::int32_t bisected = -1;
  Bisector bisector(centres.back(), centres.back(), origin);
  bool written = false;
  for (int row = 0; row < from.bgra.rows; ++row) {
    const auto* image = from.bgra.ptr<cv::Vec4b>(row);
    const auto* image_border = from.border.ptr<std::uint8_t>(row);
    auto* ground = onto.bgra.ptr<cv::Vec4b>(row);
    auto* owner = onto.owner.ptr<std::int32_t>(row);
    auto* border = onto.border.ptr<std::uint8_t>(row);
    for (int column = 0; column < from.bgra.cols; ++column) {
      if (image[column][3] == 0) continue;
      int part = 256;
      if (ground[column][3] != 0) {
        if (owner[column] != bisected) {
          bisected = owner[column];
          bisector = Bisector(centres[static_cast<std::size_t>(bisected)], centres.back(), origin);
        }
        part = share(bisector(column, row), image_border[column], border[column]);
      }
      border[column] = std::max(border[column], image_border[column]);
      if (part == 0) continue;
      ground[column] = mix(ground[column], image[column], part);
      if (part > 128) owner[column] = newest;
      written = true;
    }
  }
  return written;
}

void Overlap::add(const cv::Mat& image, const cv::Mat& mosaic) {
  constexpr int kStride = 4;
  for (int row = 0; row < image.rows; row += kStride) {
    const auto* a = image.ptr<cv::Vec4b>(row);
    const auto* b = mosaic.ptr<cv::Vec4b>(row);
    for (int column = 0; column < image.cols; column += kStride) {
      if (a[column][3] == 0 || b[column][3] == 0) continue;
      ++count_;
      for (int channel = 0; channel < 3; ++channel) {
        image_[static_cast<std::size_t>(channel)] += a[column][channel];
        mosaic_[static_cast<std::size_t>(channel)] += b[column][channel];
      }
    }
  }
}

cv::Vec3d Overlap::gain() const {
  constexpr std::int64_t kEnough = 500;  // samples; 8000 px of ground
  cv::Vec3d gain(1, 1, 1);
  if (count_ < kEnough) return gain;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const double ratio = static_cast<double>(mosaic_[channel] + count_) /
                         static_cast<double>(image_[channel] + count_);
    gain[static_cast<int>(channel)] = std::clamp(ratio, 0.5, 1.99);
  }
  return gain;
}

}  // namespace nadir::mosaic2d

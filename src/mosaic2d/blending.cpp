// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "blending.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "bgra.hpp"
#include "nadir/core/clones.hpp"

namespace nadir::mosaic2d {
namespace {

constexpr int kFeather = 16;  // px: half the width over which two images pass into each other
constexpr int kSharePerPixel = 128 / kFeather;
constexpr int kFarInside = 32;  // px: borders farther than the whole width do not matter

// The newer image's share by the distance to the line half way between two image centres, in
// 1/256 and kBits more: none on the older's side of the feather, linear along a row, unbounded.
struct Bisector {
  static constexpr int kBits = 8;
  double along_column = 0, along_row = 0, at_origin = 0;

  Bisector(const cv::Point2d& older, const cv::Point2d& newer, const cv::Point& origin) {
    const cv::Point2d step = newer - older;
    const double length = std::hypot(step.x, step.y);
    if (length < 1) return;  // the same view again: the older stays
    constexpr double kUnit = kSharePerPixel << kBits;
    const cv::Point2d from_middle = cv::Point2d(origin) - (older + newer) * 0.5;
    along_column = kUnit * step.x / length;
    along_row = kUnit * step.y / length;
    at_origin = kUnit * (from_middle.dot(step) / length + kFeather);
  }
  int at(int column, int row) const {
    constexpr double kFar = 1 << 29;  // px / 2048: nothing passes into anything there
    return cvRound(std::clamp(at_origin + along_column * column + along_row * row, -kFar, kFar));
  }
  int step() const { return cvRound(along_column); }
};

// The newer image's share in 1/256 along a row: by the bisector, but none at its own border, and
// all of it at the border of what is there unless its own is as near.
NADIR_CLONES
void shares(int bisector, int step, const std::uint8_t* newer_border,
            const std::uint8_t* older_border, int count, std::uint16_t* share) {
  for (int i = 0; i < count; ++i) {
    const int newer = kSharePerPixel * newer_border[i], older = kSharePerPixel * older_border[i];
    int part = (bisector + i * step) >> Bisector::kBits;
    part = part > newer - older ? part : newer - older;
    part = part < newer ? part : newer;
    part = part > 0 ? part : 0;
    share[i] = static_cast<std::uint16_t>(part < 256 ? part : 256);
  }
}

// min(value, neighbour + step) along a row, for all pixels at once.
inline void approach(std::uint8_t* values, const std::uint8_t* neighbours, int step, int count) {
  for (int i = 0; i < count; ++i) {
    const auto far = static_cast<std::uint8_t>(neighbours[i] + step);
    values[i] = values[i] < far ? values[i] : far;
  }
}

// The distance along a row by doubling: neighbours at 1, 2, 4, ... px on either side.
NADIR_CLONES
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

// Values of channels, not pixels: compilers vectorise loops over one kind of value. What is mixed
// was opaque and stays so.
NADIR_CLONES
void mix(std::uint8_t* older, const std::uint8_t* newer, const std::uint16_t* share, int count) {
  for (int i = 0; i < count; ++i) {
    const auto kept = static_cast<std::uint16_t>(256 - share[i]);
    const auto sum = static_cast<std::uint16_t>(older[i] * kept + newer[i] * share[i] + 128);
    older[i] = static_cast<std::uint8_t>(sum >> 8);
  }
}

NADIR_CLONES
void for_four_channels(const std::uint16_t* share, int count, std::uint16_t* channels) {
  for (int i = 0; i < count; ++i) {
    const std::uint64_t four = 0x0001000100010001 * std::uint64_t{share[i]};
    std::memcpy(channels + kChannels * i, &four, sizeof four);
  }
}

NADIR_CLONES
void own(std::uint16_t* owner, std::uint16_t newest, const std::uint16_t* share, int count) {
  for (int i = 0; i < count; ++i) owner[i] = share[i] > 128 ? newest : owner[i];
}

NADIR_CLONES
void widen(std::uint8_t* border, const std::uint8_t* other, int count) {
  for (int i = 0; i < count; ++i) border[i] = std::max(border[i], other[i]);
}

// A row of a new image and of the ground below it.
struct Rows {
  const std::uint8_t* image;  ///< BGRA
  const std::uint8_t* ground;
  const std::uint16_t* owner;

  bool image_at(int column) const { return image[kChannels * column + 3] != 0; }
  bool ground_at(int column) const { return ground[kChannels * column + 3] != 0; }
};

// Whether all of 16 columns show the image, and the ground as `first` does. Whole pixels are
// compared, since compilers vectorise that.
inline bool are_like(const Rows& rows, int first, int begin) {
  constexpr int kColumns = 16;
  std::uint32_t image = ~0U, ground = ~0U, any_ground = 0;
  std::uint32_t other_owner = 0;
  for (int i = begin; i < begin + kColumns; ++i) {
    const std::uint32_t of_ground = pixel_at(rows.ground, i);
    image &= pixel_at(rows.image, i), ground &= of_ground, any_ground |= of_ground;
    other_owner |= std::uint32_t{rows.owner[i]} ^ rows.owner[first];
  }
  if ((image & kAlpha) != kAlpha) return false;
  return rows.ground_at(first) ? (ground & kAlpha) == kAlpha && other_owner == 0
                               : (any_ground & kAlpha) == 0;
}

// The first column from `column` on where the image is seen, or `count`; its border distance tells.
int next_seen(const std::uint8_t* border, int column, int count) {
  constexpr int kColumns = 8;
  for (; column + kColumns <= count; column += kColumns) {
    std::uint64_t any;
    std::memcpy(&any, border + column, kColumns);
    if (any != 0) break;
  }
  while (column < count && border[column] == 0) ++column;
  return column;
}

// Columns from `first` on where the image lies over bare ground, or over that of one other image.
NADIR_CLONES
int end_of_run(const Rows& rows, int first, int count) {
  const bool covered = rows.ground_at(first);
  int end = first + 1;
  while (end + 16 <= count && are_like(rows, first, end)) end += 16;
  while (end < count && rows.image_at(end) && rows.ground_at(end) == covered &&
         (!covered || rows.owner[end] == rows.owner[first]))
    ++end;
  return end;
}

struct Sums {
  std::uint32_t opaque = 0, across = 0;  ///< pixels, and their columns
};

NADIR_CLONES
Sums sums_of(const std::uint8_t* alpha, int count) {
  Sums sums;
  for (int i = 0; i < count; ++i) {
    const std::uint32_t is_opaque = alpha[i] != 0 ? 1 : 0;
    sums.opaque += is_opaque;
    sums.across += is_opaque * static_cast<std::uint32_t>(i);
  }
  return sums;
}

std::optional<cv::Point2d> centre_of(const cv::Mat& alpha) {
  double opaque = 0, across = 0, down = 0;
  for (int row = 0; row < alpha.rows; ++row) {
    const Sums sums = sums_of(alpha.ptr(row), alpha.cols);
    opaque += sums.opaque;
    across += sums.across;
    down += static_cast<double>(sums.opaque) * row;
  }
  if (opaque == 0) return std::nullopt;
  return cv::Point2d(across / opaque, down / opaque);
}

}  // namespace

Outline outline(const cv::Mat& bgra) {
  Outline outline;
  cv::extractChannel(bgra, outline.border, 3);
  outline.centre = centre_of(outline.border);
  to_border_distance(outline.border);
  return outline;
}

bool blend_patch(const Patch& from, Ground onto, cv::Point origin,
                 const std::vector<cv::Point2d>& centres) {
  const auto newest = static_cast<std::uint16_t>(centres.size() - 1);
  std::vector<std::uint16_t> share(static_cast<std::size_t>(from.bgra.cols));
  std::vector<std::uint16_t> channels(4 * share.size());
  bool written = false;
  for (int row = 0; row < from.bgra.rows; ++row) {
    const std::uint8_t* image = from.bgra.ptr(row);
    std::uint8_t* ground = onto.bgra.ptr(row);
    auto* owner = onto.owner.ptr<std::uint16_t>(row);
    const Rows rows{image, ground, owner};
    for (int first = 0, end = 0;; first = end) {
      first = next_seen(from.border.ptr(row), first, from.bgra.cols);
      if (first == from.bgra.cols) break;
      end = end_of_run(rows, first, from.bgra.cols);
      const int count = end - first;
      const std::uint8_t* image_border = from.border.ptr(row) + first;
      std::uint8_t* border = onto.border.ptr(row) + first;
      if (!rows.ground_at(first)) {
        std::copy(image + kChannels * first, image + kChannels * end, ground + kChannels * first);
        std::fill(owner + first, owner + end, newest);
        written = true;
      } else {
        const Bisector bisector(centres[owner[first]], centres.back(), origin);
        shares(bisector.at(first, row), bisector.step(), image_border, border, count, share.data());
        if (std::any_of(share.begin(), share.begin() + count, [](auto part) { return part > 0; })) {
          for_four_channels(share.data(), count, channels.data());
          mix(ground + kChannels * first, image + kChannels * first, channels.data(), 4 * count);
          own(owner + first, newest, share.data(), count);
          written = true;
        }
      }
      widen(border, image_border, count);
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

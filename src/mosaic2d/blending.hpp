// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Seams: which image a ground pixel shows, and how two images pass into each other.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace nadir::mosaic2d {

/// What decides the seams of an image, from its alpha channel alone.
struct Outline {
  std::optional<cv::Point2d> centre;  ///< mean position weighted by alpha; none without any
  cv::Mat border;  ///< CV_8UC1: city-block distance to the nearest pixel without alpha or outside
                   ///< the image, px, saturated at 32
};
Outline outline(const cv::Mat& bgra);

/// The part of a new image over a tile.
struct Patch {
  cv::Mat bgra, border;
};

/// The same part of the tile, written in place.
struct Ground {
  cv::Mat bgra;
  cv::Mat owner;  ///< CV_16UC1: index of an image's centre
  cv::Mat border;
};

/// Blends the newest image, whose centre is centres.back() of at most 65536, onto a tile; `origin`
/// is the pixel of the raster at the patch's top left. False when nothing was written.
bool blend_patch(const Patch& from, Ground onto, cv::Point origin,
                 const std::vector<cv::Point2d>& centres);

/// Sums of two images of the same ground, over every fourth pixel of every fourth row.
class Overlap {
 public:
  void add(const cv::Mat& image, const cv::Mat& mosaic);
  /// mosaic / image per channel; 1 when there is too little overlap, never beyond 1/2 to 2.
  cv::Vec3d gain() const;

 private:
  std::int64_t count_ = 0;
  std::array<std::int64_t, 3> image_{}, mosaic_{};
};

}  // namespace nadir::mosaic2d

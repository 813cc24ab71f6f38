// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The ground that a vehicle went over, gaps between its lanes and holes included, the open outside
// not.
#pragma once

#include <opencv2/core/mat.hpp>

namespace nadir::coverage {

/// On a raster of blocks, several cells each. Its border must stay unseen, margin(radius) wide.
class Swept {
 public:
  /// radius of the closing, in blocks: what is narrower than twice that counts as between lanes.
  void begin(const cv::Size& size, double radius);

  /// seen: CV_8UC1, 255 where any cell of the block was seen; whole: where all were. changed: where
  /// they did since the last time. Afterwards all() is what is to be covered.
  void update(const cv::Mat1b& seen, const cv::Mat1b& whole, const cv::Rect& changed);

  /// 255 where every cell of the block is to be covered; of others, those that were seen.
  const cv::Mat1b& all() const { return all_; }

  static int margin(double radius);

 private:
  void close(const cv::Mat1b& seen, const cv::Rect& changed);

  double radius_ = 0;
  cv::Mat1b closed_, all_;
};

}  // namespace nadir::coverage

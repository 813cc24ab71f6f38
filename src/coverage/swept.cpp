// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "swept.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace nadir::coverage {
namespace {

// The closing keeps away from the outside by this much: the steps of a slanted border are not
// between anything.
constexpr double kSteps = 1.5;  // blocks

// An unseen region that borders the open outside by more than this part of its rim is a bay of it,
// such as the inside of a bend; less, and it is the end of a lane left out.
constexpr double kOpen = 0.25;

// Distance to the nearest block that is not 0, in blocks.
cv::Mat1f distance_to(const cv::Mat1b& blocks) {
  cv::Mat1f distance;
  cv::distanceTransform(~blocks, distance, cv::DIST_L2, cv::DIST_MASK_5);
  return distance;
}

// All that cannot be reached from the raster's corner.
cv::Mat1b filled(const cv::Mat1b& closed) {
  cv::Mat1b outside = closed.clone();
  constexpr std::uint8_t kReached = 128;
  cv::floodFill(outside, cv::Point(0, 0), cv::Scalar(kReached));
  return cv::Mat1b(outside != kReached);
}

struct Rim {
  int inner = 0, open = 0;  ///< sides of blocks towards seen ground, towards the outside
};

std::vector<Rim> rims_of(const cv::Mat1i& labels, int count, const cv::Mat1b& seen) {
  std::vector<Rim> rims(static_cast<std::size_t>(count));
  for (int y = 1; y + 1 < labels.rows; ++y) {
    for (int x = 1; x + 1 < labels.cols; ++x) {
      const int label = labels(y, x);
      if (label == 0) continue;
      Rim& rim = rims[static_cast<std::size_t>(label)];
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        if (seen(y + dy, x + dx)) {
          ++rim.inner;
        } else if (labels(y + dy, x + dx) == 0) {
          ++rim.open;
        }
      }
    }
  }
  return rims;
}

void leave_out_bays(const cv::Mat1b& seen, cv::Mat1b& ground) {
  const cv::Mat1b unseen(ground & ~seen);
  cv::Mat1i labels;
  const int count = cv::connectedComponents(unseen, labels, 4);
  if (count < 2) return;
  const std::vector<Rim> rims = rims_of(labels, count, seen);
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      const Rim& rim = rims[static_cast<std::size_t>(labels(y, x))];
      if (labels(y, x) != 0 && rim.open > kOpen * (rim.open + rim.inner)) ground(y, x) = 0;
    }
  }
}

}  // namespace

int Swept::margin(double radius) { return static_cast<int>(std::ceil(radius)) + 3; }

void Swept::begin(const cv::Size& size, double radius) {
  radius_ = radius;
  closed_ = cv::Mat1b::zeros(size);
  all_ = cv::Mat1b::zeros(size);
}

// A block's closing depends on what lies within twice the radius, so that far from what changed it
// stays.
void Swept::close(const cv::Mat1b& seen, const cv::Rect& changed) {
  const cv::Rect all({}, seen.size());
  const int reach = 2 * margin(radius_);
  const auto grown = [&](int by) {
    return cv::Rect(changed.x - by, changed.y - by, changed.width + 2 * by,
                    changed.height + 2 * by) &
           all;
  };
  const cv::Rect to = grown(reach), from = grown(2 * reach);
  const cv::Mat1b near(distance_to(seen(from)) <= radius_);
  const cv::Mat1b inside(distance_to(cv::Mat1b(~near)) > radius_ + kSteps);
  const cv::Mat1b closed(inside | seen(from));
  closed(to - from.tl()).copyTo(closed_(to));
}

void Swept::update(const cv::Mat1b& seen, const cv::Mat1b& whole, const cv::Rect& changed) {
  if (!changed.empty()) close(seen, changed);
  cv::Mat1b ground = filled(closed_);
  leave_out_bays(seen, ground);
  // Of a block that was seen in part the rest is to be covered when it borders nothing outside.
  cv::Mat1b inner;
  cv::erode(ground, inner, cv::Mat());
  all_ = (ground & ~seen) | whole | (inner & seen);
}

}  // namespace nadir::coverage

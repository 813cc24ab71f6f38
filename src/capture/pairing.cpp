// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pairing.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace nadir::capture {
namespace {

constexpr std::size_t kMostWaiting = 2;  // drivers have few buffers
constexpr std::size_t kSkews = 20;

}  // namespace

void Pairing::add(Side side, Picture picture) {
  waiting(side).push_back(std::move(picture));
  if (waiting(side).size() > kMostWaiting) drop(side);
}

void Pairing::drop(Side side) {
  waiting(side).pop_front();
  if (side == Side::left) ++unpaired_;
}

std::optional<PicturePair> Pairing::take(Time period) {
  std::deque<Picture>&left = waiting(Side::left), &right = waiting(Side::right);
  while (!left.empty() && !right.empty()) {
    const Time skew = right.front().time - left.front().time;
    if (2 * std::abs(skew) < period) {
      PicturePair pair{std::move(left.front()), std::move(right.front())};
      left.pop_front();
      right.pop_front();
      skews_.push_back(skew);
      if (skews_.size() > kSkews) skews_.pop_front();
      return pair;
    }
    drop(skew > 0 ? Side::left : Side::right);
  }
  return std::nullopt;
}

std::optional<Time> Pairing::skew() const {
  if (skews_.size() < kSkews) return std::nullopt;
  std::vector<Time> sorted(skews_.begin(), skews_.end());
  std::ranges::nth_element(sorted, sorted.begin() + kSkews / 2);
  return sorted[kSkews / 2];
}

}  // namespace nadir::capture

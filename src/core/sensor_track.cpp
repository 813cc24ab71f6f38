// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/sensor_track.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace nadir {
namespace {

constexpr Time kLongestGap = 500'000'000;

// Within half a period of 0.
double wrapped(double value, double period) {
  return period > 0 ? value - period * std::floor(value / period + 0.5) : value;
}

}  // namespace

bool SensorTrack::add(Time time, const Values& values) {
  if (!rows_.empty() && time <= rows_.back().time) return false;
  rows_.push_back({time, values});
  return true;
}

std::optional<SensorTrack::Values> SensorTrack::at(Time time) const {
  const auto after = std::ranges::lower_bound(rows_, time, {}, &Row::time);
  if (after == rows_.end()) return std::nullopt;
  const bool exact = after->time == time;
  if (!exact && after == rows_.begin()) return std::nullopt;
  const Row& from = exact ? *after : *std::prev(after);
  const Time gap = after->time - from.time;
  if (gap > kLongestGap) return std::nullopt;
  const double share = exact ? 0 : static_cast<double>(time - from.time) / static_cast<double>(gap);
  Values values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double step = wrapped(after->values[i] - from.values[i], periods_[i]);
    values[i] = wrapped(from.values[i] + share * step, periods_[i]);
  }
  return values;
}

void SensorTrack::forget_before(Time time) {
  while (!rows_.empty() && rows_.front().time < time) rows_.pop_front();
}

}  // namespace nadir

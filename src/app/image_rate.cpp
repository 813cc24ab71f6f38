// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_rate.hpp"

#include <algorithm>

namespace nadir::app {
namespace {

using namespace std::chrono_literals;
using Seconds = std::chrono::duration<double>;

constexpr auto kSpan = 10s, kEnough = 2s;

ImageRate::Clock::duration patience(double wanted_hz) {
  constexpr auto kShortest = 3s;
  constexpr double kImages = 3, kLongest_s = 3600;
  if (wanted_hz <= 0) return kShortest;
  const Seconds time(std::min(kImages / wanted_hz, kLongest_s));
  return std::max<ImageRate::Clock::duration>(
      kShortest, std::chrono::duration_cast<ImageRate::Clock::duration>(time));
}

}  // namespace

ImageRate::ImageRate(double wanted_hz) : patience_(patience(wanted_hz)) {}

void ImageRate::observe(Clock::time_point now, const ImageFlow& images) {
  now_ = now;
  const std::uint64_t count = images.accepted + images.dropped;
  if (!counts_.empty() && count == counts_.back().images) return;
  // The time without images is no part of the rate they come at afterwards.
  if (silence() || (!counts_.empty() && counts_.back().images == 0)) counts_.clear();
  counts_.push_back({now, count});
  while (counts_.size() > 2 && now - counts_[1].time >= kSpan) counts_.pop_front();
}

std::optional<double> ImageRate::hz() const {
  if (counts_.empty() || silence()) return std::nullopt;
  const Count& first = counts_.front();
  const Count& last = counts_.back();
  if (last.time - first.time < kEnough) return std::nullopt;
  return static_cast<double>(last.images - first.images) / Seconds(last.time - first.time).count();
}

std::optional<std::chrono::seconds> ImageRate::silence() const {
  if (counts_.empty() || now_ - counts_.back().time <= patience_) return std::nullopt;
  return std::chrono::floor<std::chrono::seconds>(now_ - counts_.back().time);
}

}  // namespace nadir::app

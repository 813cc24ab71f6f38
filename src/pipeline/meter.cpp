// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/meter.hpp"

#include <algorithm>
#include <vector>

namespace nadir::pipeline {
namespace {

std::int64_t nanoseconds(Meter::Clock::duration duration) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
}

double percentile_95(std::vector<std::int64_t>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 95 / 100);
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

}  // namespace

void Meter::add(Clock::time_point begin, Clock::time_point end, std::uint64_t arrived) {
  const std::uint64_t n = done_.load(std::memory_order_relaxed);
  begun_.store(n + 1, std::memory_order_relaxed);
  // The release stores below keep a reader that sees any of a new sample from missing begun_.
  Sample& sample = samples_[n % kSize];
  sample.end_ns.store(nanoseconds(end.time_since_epoch()), std::memory_order_release);
  sample.duration_ns.store(nanoseconds(end - begin), std::memory_order_release);
  sample.arrived.store(arrived, std::memory_order_release);
  done_.store(n + 1, std::memory_order_release);
}

Meter::Reading Meter::read(Clock::time_point now, std::uint64_t arrived) const {
  const std::int64_t now_ns = nanoseconds(now.time_since_epoch());
  Reading reading;
  reading.count = done_.load(std::memory_order_acquire);

  std::vector<std::int64_t> durations;
  std::int64_t since_ns = now_ns;
  std::uint64_t arrived_since = arrived;
  for (std::uint64_t n = reading.count; n > 0 && reading.count - n < kSize; --n) {
    const Sample& sample = samples_[(n - 1) % kSize];
    const std::int64_t end_ns = sample.end_ns.load(std::memory_order_acquire);
    const std::int64_t duration_ns = sample.duration_ns.load(std::memory_order_acquire);
    const std::uint64_t arrived_then = sample.arrived.load(std::memory_order_acquire);
    const bool overwritten = begun_.load(std::memory_order_relaxed) >= n + kSize;
    const bool old = now_ns - end_ns > nanoseconds(kSpan);
    if (overwritten || (old && !durations.empty())) break;
    durations.push_back(duration_ns);
    since_ns = end_ns;
    arrived_since = arrived_then;
  }
  if (durations.empty()) return reading;

  reading.last_ms = 1e-6 * static_cast<double>(durations.front());
  const double span = 1e-9 * static_cast<double>(std::max<std::int64_t>(now_ns - since_ns, 1));
  reading.rate_out_hz = static_cast<double>(durations.size() - 1) / span;
  reading.rate_in_hz = static_cast<double>(arrived - std::min(arrived, arrived_since)) / span;
  reading.p95_ms = 1e-6 * percentile_95(durations);
  return reading;
}

}  // namespace nadir::pipeline

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether a viewer's link carries what it is sent: by the part of the time that writing to it
// waits.
#pragma once

#include <chrono>
#include <cmath>

namespace nadir::serve {

class LinkLoad {
 public:
  using Clock = std::chrono::steady_clock;
  explicit LinkLoad(Clock::time_point now) : seen_(now) {}

  /// A record was written from then to now, what waited for the link before it included.
  void wrote(Clock::time_point begun, Clock::time_point now) {
    observe(begun, 0);
    observe(now, 1);
    if (busy_ > kThin) thin_ = true;
    if (busy_ < kAmple) thin_ = false;
  }

  bool is_thin() const { return thin_; }

 private:
  static constexpr double kMemory = 1.5;               // s
  static constexpr double kThin = 0.85, kAmple = 0.4;  // of the time

  void observe(Clock::time_point now, double writing) {
    const double elapsed = std::chrono::duration<double>(now - seen_).count();
    busy_ = writing + (busy_ - writing) * std::exp(-elapsed / kMemory);
    seen_ = now;
  }

  Clock::time_point seen_;
  double busy_ = 0;
  bool thin_ = false;
};

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/meter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace nadir::pipeline {
namespace {

using namespace std::chrono_literals;

/// Items of the given duration ending every period; three arrive for each that is processed.
Meter::Clock::time_point run(Meter& meter, int items, Meter::Clock::duration period,
                             Meter::Clock::duration duration) {
  Meter::Clock::time_point now{1h};
  for (int i = 0; i < items; ++i) {
    now += period;
    meter.add(now - duration, now, static_cast<std::uint64_t>(3 * (i + 1)));
  }
  return now;
}

TEST(Meter, IsZeroBeforeTheFirstItem) {
  const Meter meter;
  const auto reading = meter.read(Meter::Clock::now(), 5);
  EXPECT_EQ(reading.count, 0u);
  EXPECT_EQ(reading.rate_in_hz, 0);
  EXPECT_EQ(reading.p95_ms, 0);
}

TEST(Meter, MeasuresRatesAndDurations) {
  Meter meter;
  const auto now = run(meter, 50, 100ms, 20ms);
  const auto reading = meter.read(now, 150);
  EXPECT_EQ(reading.count, 50u);
  EXPECT_NEAR(reading.rate_out_hz, 10, 1e-6);
  EXPECT_NEAR(reading.rate_in_hz, 30, 1e-6);
  EXPECT_NEAR(reading.last_ms, 20, 1e-6);
  EXPECT_NEAR(reading.p95_ms, 20, 1e-6);
}

TEST(Meter, ForgetsWhatLiesBeforeItsWindow) {
  Meter meter;
  run(meter, 500, 1ms, 900us);
  Meter::Clock::time_point now{1h + 60s};
  for (int i = 0; i < 11; ++i) {
    now += 1s;
    meter.add(now - 5ms, now, 1500);
  }
  const auto reading = meter.read(now, 1500);
  EXPECT_NEAR(reading.rate_out_hz, 1, 1e-6);
  EXPECT_NEAR(reading.p95_ms, 5, 1e-6);
}

TEST(Meter, GivesTheDurationThatOneItemInTwentyExceeds) {
  Meter meter;
  Meter::Clock::time_point now{1h};
  for (int i = 1; i <= 100; ++i) {
    now += 10ms;
    meter.add(now - i * 1ms, now, 0);
  }
  EXPECT_NEAR(meter.read(now, 0).p95_ms, 96, 1e-6);
}

TEST(Meter, IsReadWhileItIsWrittenWithoutTornSamples) {
  constexpr Meter::Clock::time_point kStart{1h};
  Meter meter;
  std::atomic<bool> stop = false;
  std::thread writer([&] {
    // One item arrives and one ends every microsecond, so a whole sample gives exactly 1 MHz.
    for (std::uint64_t i = 0; !stop; ++i) meter.add(kStart, kStart + i * 1us, i);
  });
  int torn = 0;
  for (int read = 0; read < 5000;) {
    const auto reading = meter.read(kStart + 9s, 9'000'000);
    if (reading.rate_out_hz == 0) continue;
    torn += std::abs(reading.rate_in_hz - 1e6) > 1e-3;
    ++read;
  }
  stop = true;
  writer.join();
  EXPECT_EQ(torn, 0);
}

}  // namespace
}  // namespace nadir::pipeline

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_rate.hpp"

#include <gtest/gtest.h>

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

/// A camera that is looked at every half second.
struct Watched {
  explicit Watched(double wanted_hz) : rate(wanted_hz) {}

  void give(double images_a_second, std::chrono::duration<double> time) {
    for (const auto end = now + time; now < end; now += 500ms) {
      images += 0.5 * images_a_second;
      const auto whole = static_cast<std::uint64_t>(images);
      rate.observe(now, {whole / 2, whole - whole / 2});  // half of them dropped
    }
  }

  ImageRate rate;
  ImageRate::Clock::time_point now = ImageRate::Clock::now();
  double images = 0;
};

TEST(ImageRate, CountsWhatCameDroppedOrNot) {
  Watched camera(10);
  camera.give(10, 5s);
  EXPECT_NEAR(camera.rate.hz().value(), 10, 0.1);
  camera.give(4, 12s);
  EXPECT_NEAR(camera.rate.hz().value(), 4, 0.1);
  EXPECT_FALSE(camera.rate.silence());
}

TEST(ImageRate, IsUnknownAtFirst) {
  Watched camera(10);
  EXPECT_FALSE(camera.rate.hz());
  EXPECT_FALSE(camera.rate.silence());
  camera.give(0, 2s);  // one that takes its time to start
  camera.give(10, 1s);
  EXPECT_FALSE(camera.rate.hz());
  camera.give(10, 2s);
  EXPECT_NEAR(camera.rate.hz().value(), 10, 0.1);
}

TEST(ImageRate, IsNoneWhileNoImagesComeAndBeginsAnew) {
  Watched camera(0);
  camera.give(10, 20s);
  camera.give(0, 3s);
  EXPECT_TRUE(camera.rate.hz());
  camera.give(0, 30s);
  EXPECT_FALSE(camera.rate.hz());
  EXPECT_NEAR(static_cast<double>(camera.rate.silence().value().count()), 33, 1);
  camera.give(10, 1s);
  EXPECT_FALSE(camera.rate.silence());
  EXPECT_FALSE(camera.rate.hz());
  camera.give(10, 2s);
  EXPECT_NEAR(camera.rate.hz().value(), 10, 0.1);
}

TEST(ImageRate, WaitsForASlowCamera) {
  Watched camera(0.25);
  camera.give(0.25, 60s);
  EXPECT_FALSE(camera.rate.silence());
  EXPECT_NEAR(camera.rate.hz().value(), 0.25, 0.01);
  camera.give(0, 12s);
  EXPECT_FALSE(camera.rate.silence());
  camera.give(0, 1s);
  EXPECT_TRUE(camera.rate.silence());
}

TEST(ImageRate, OfACameraThatGivesNoneIsSilence) {
  Watched camera(10);
  camera.give(0, 10s);
  EXPECT_FALSE(camera.rate.hz());
  EXPECT_TRUE(camera.rate.silence());
}

}  // namespace
}  // namespace nadir::app

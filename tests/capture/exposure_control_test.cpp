// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "exposure_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace nadir::capture {
namespace {

constexpr ExposureRange kRange{0.1, 500, 0, 100};
constexpr double kPeriod_ms = 100;

/// A camera whose settings show some images later, with the usual gamma.
class Camera {
 public:
  Camera(double light, double gain_doubles, std::size_t delay = 2)
      : light_(light), gain_doubles_(gain_doubles), pending_(delay + 1, Exposure{5, 0}) {}

  void set(const Exposure& exposure) { pending_.back() = exposure; }
  /// The mean of the next image.
  double next() {
    pending_.push_back(pending_.back());
    pending_.pop_front();
    const Exposure& now = pending_.front();
    const double linear = light_ * now.ms * std::exp2(now.gain / gain_doubles_);
    return std::clamp(255 * std::pow(linear, 1 / 2.2), 0.0, 255.0);
  }
  void light(double light) { light_ = light; }

 private:
  double light_, gain_doubles_;
  std::deque<Exposure> pending_;
};

class ExposureControlTest : public testing::Test {
 protected:
  /// The mean after so many images; how often the exposure was changed in the last ten.
  double run(Camera& camera, int images, double speed_px = 0) {
    double mean = 0;
    changes = 0;
    for (int i = 0; i < images; ++i) {
      mean = camera.next();
      if (const auto next = control.observe(mean, speed_px, kPeriod_ms)) {
        camera.set(*next);
        changes += i >= images - 10;
      }
    }
    return mean;
  }

  ExposureControl control{kRange, 1, {5, 0}};
  int changes = 0;
};

TEST_F(ExposureControlTest, FindsTheBrightnessWhateverTheLightAndThenStays) {
  for (const double light : {0.002, 0.02, 0.2}) {
    control = ExposureControl(kRange, 1, {5, 0});
    Camera camera(light, 20);
    EXPECT_NEAR(run(camera, 60), 105, 0.16 * 105) << light;
    EXPECT_EQ(changes, 0) << light;
    EXPECT_EQ(control.exposure().gain, 0) << light;
  }
}

TEST_F(ExposureControlTest, KeepsTheBlurBelowAPixelAndTakesGainInstead) {
  Camera camera(0.01, 20);
  EXPECT_NEAR(run(camera, 200, 300), 105, 0.2 * 105);
  EXPECT_LE(control.exposure().ms, 1000.0 / 300 * 1.1);
  EXPECT_GT(control.exposure().gain, 5);
  EXPECT_EQ(changes, 0);
  // Slower again, gain goes before the exposure grows.
  camera.light(0.03);
  EXPECT_NEAR(run(camera, 200, 50), 105, 0.16 * 105);
  EXPECT_LT(control.exposure().gain, 40);
}

TEST_F(ExposureControlTest, ShortensAtOnceWhenItGetsFaster) {
  Camera camera(0.002, 20);
  run(camera, 100);
  ASSERT_GT(control.exposure().ms, 20);
  for (int i = 0; i < 3; ++i) {
    if (const auto next = control.observe(camera.next(), 400, kPeriod_ms)) camera.set(*next);
  }
  EXPECT_LE(control.exposure().ms, 1000.0 / 400);
}

TEST_F(ExposureControlTest, StaysWithinWhatTheCameraAndItsRateAllow) {
  Camera dark(1e-6, 20);
  run(dark, 300);
  EXPECT_EQ(control.exposure().ms, 90);
  EXPECT_EQ(control.exposure().gain, 100);
  Camera bright(1e4, 20);
  run(bright, 300);
  EXPECT_EQ(control.exposure().ms, 0.1);
  EXPECT_EQ(control.exposure().gain, 0);
}

TEST_F(ExposureControlTest, WaitsForACameraThatTakesItsTime) {
  for (const double light : {0.002, 0.2}) {
    ExposureRange range = kRange;
    range.delay = 9;
    control = ExposureControl(range, 1, {5, 0});
    Camera camera(light, 20, 8);
    EXPECT_NEAR(run(camera, 60), 105, 0.16 * 105) << light;
    EXPECT_EQ(changes, 0) << light;
  }
}

TEST_F(ExposureControlTest, DoesNotSwingWhereGainMeansMoreThanItThinks) {
  Camera camera(0.001, 3);  // a third of a hundred steps for each doubling of light
  run(camera, 300, 500);
  EXPECT_LE(changes, 3);
}

}  // namespace
}  // namespace nadir::capture

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a camera is set to, by the controls of the libcamera found here.
#include "plugin/settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace nadir::capture::plugin {
namespace {

using libcamera::ControlInfo;
using libcamera::ControlInfoMap;
using testing::HasSubstr;
namespace controls = libcamera::controls;

constexpr double kFrame_us = 100'000;

ControlInfoMap::Map raspberry_pi() {
  return {{&controls::AeEnable, ControlInfo(false, true)},
          {&controls::ExposureTime, ControlInfo(75, 11'767'556)},  // an IMX219's
          {&controls::AnalogueGain, ControlInfo(1.0F, 10.666667F)},
          {&controls::FrameDurationLimits,
           ControlInfo(std::int64_t{33'327}, std::int64_t{11'767'829})}};
}

NadirCameraWanted wanting(double exposure_ms, double gain) {
  NadirCameraWanted wanted{};
  wanted.exposure_ms = exposure_ms;
  wanted.gain = gain;
  wanted.focus = -1;
  wanted.rate_hz = 1e6 / kFrame_us;
  return wanted;
}

class LibcameraSettingsTest : public testing::Test {
 protected:
  /// As the camera begins.
  NadirExposing begin(const NadirCameraWanted& wanted, const ControlInfoMap& with) {
    Settings settings(with);
    const double frame_us = set_rate(settings, wanted);
    const NadirExposing exposing = set_exposure(settings, frame_us, wanted, remarks);
    list = settings.list();
    return exposing;
  }
  double value(const libcamera::ControlId& id) const {
    if (!list.contains(id.id())) return std::nan("");
    const libcamera::ControlValue& value = list.get(id.id());
    if (value.type() == libcamera::ControlTypeBool) return value.get<bool>() ? 1 : 0;
    if (value.type() == libcamera::ControlTypeInteger32) return value.get<std::int32_t>();
    return value.get<float>();
  }

  const ControlInfoMap known{raspberry_pi(), controls::controls};
  libcamera::ControlList list;
  std::string remarks;
};

TEST_F(LibcameraSettingsTest, BeginsToSteerByHand) {
  const NadirExposing exposing = begin(wanting(0, -1), known);
  EXPECT_EQ(exposing.steered, 1);
  EXPECT_NEAR(exposing.shortest_ms, 0.075, 1e-9);
  EXPECT_NEAR(exposing.longest_ms, 1e-3 * kFrame_us, 1e-9);
  EXPECT_NEAR(exposing.most_gain, 10.666667, 1e-6);
  EXPECT_EQ(value(controls::AeEnable), 0);
  EXPECT_EQ(value(controls::ExposureTime), std::round(1000 * exposing.ms));
  EXPECT_EQ(value(controls::AnalogueGain), 1);
  EXPECT_EQ(remarks, "");
}

TEST_F(LibcameraSettingsTest, SteersInMicrosecondsAndNothingElse) {
  Settings settings(known);
  expose(settings, 12.5, 2.5);
  list = settings.list();
  EXPECT_EQ(value(controls::ExposureTime), 12'500);
  EXPECT_EQ(value(controls::AnalogueGain), 2.5);
  EXPECT_EQ(list.size(), 2u);
}

TEST_F(LibcameraSettingsTest, LeavesWhatIsFixed) {
  EXPECT_EQ(begin(wanting(5, -1), known).steered, 0);
  EXPECT_EQ(value(controls::AeEnable), 1);  // finds the gain
  EXPECT_EQ(value(controls::ExposureTime), 5000);
  EXPECT_TRUE(std::isnan(value(controls::AnalogueGain)));
  EXPECT_EQ(begin(wanting(5, 2), known).steered, 0);
  EXPECT_EQ(value(controls::AeEnable), 0);
  const NadirExposing exposing = begin(wanting(0, 2), known);
  EXPECT_EQ(exposing.steered, 1);
  EXPECT_EQ(exposing.least_gain, 2);
  EXPECT_EQ(exposing.most_gain, 2);
  EXPECT_EQ(value(controls::AeEnable), 0);
  EXPECT_EQ(value(controls::AnalogueGain), 2);
  EXPECT_EQ(remarks, "");
}

TEST_F(LibcameraSettingsTest, TellsOfAGainThatCannotBeAndTakesTheNearest) {
  EXPECT_EQ(begin(wanting(0, 20), known).steered, 1);
  EXPECT_NEAR(value(controls::AnalogueGain), 10.666667, 1e-6);
  EXPECT_THAT(remarks, HasSubstr("its gain cannot be set to 20"));
}

TEST_F(LibcameraSettingsTest, LeavesACameraWithoutBothControlsToItself) {
  for (const libcamera::ControlId* missing :
       {static_cast<const libcamera::ControlId*>(&controls::ExposureTime),
        static_cast<const libcamera::ControlId*>(&controls::AnalogueGain)}) {
    ControlInfoMap::Map some = raspberry_pi();
    some.erase(missing);
    EXPECT_EQ(begin(wanting(0, -1), {std::move(some), controls::controls}).steered, 0);
    EXPECT_EQ(value(controls::AeEnable), 1);
    EXPECT_TRUE(std::isnan(value(controls::ExposureTime)));
  }
  EXPECT_EQ(remarks, "");
}

}  // namespace
}  // namespace nadir::capture::plugin

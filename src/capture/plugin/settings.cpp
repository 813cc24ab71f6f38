// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace nadir::capture::plugin {
namespace {

// Not a number where there is none.
double number_of(const libcamera::ControlValue& value) {
  if (value.isArray()) return std::nan("");
  switch (value.type()) {
    case libcamera::ControlTypeInteger32:
      return value.get<std::int32_t>();
    case libcamera::ControlTypeInteger64:
      return static_cast<double>(value.get<std::int64_t>());
    case libcamera::ControlTypeFloat:
      return value.get<float>();
    default:
      return std::nan("");
  }
}

}  // namespace

Bounds Settings::bounds(const char* name) const {
  const auto control = find(name);
  if (control == known_.end()) return {std::nan(""), std::nan("")};
  return {number_of(control->second.min()), number_of(control->second.max())};
}

bool Settings::set(const char* name, double value) {
  const auto control = find(name);
  if (control == known_.end()) return false;
  const auto& [id, info] = *control;
  if (value < number_of(info.min()) || value > number_of(info.max())) return false;
  switch (id->type()) {
    case libcamera::ControlTypeBool:
      list_.set(id->id(), libcamera::ControlValue(value != 0));
      return true;
    case libcamera::ControlTypeInteger32:
      list_.set(id->id(), libcamera::ControlValue(static_cast<std::int32_t>(std::lround(value))));
      return true;
    case libcamera::ControlTypeFloat:
      list_.set(id->id(), libcamera::ControlValue(static_cast<float>(value)));
      return true;
    default:
      return false;
  }
}

double Settings::set_frame_us(double frame_us) {
  const auto control = find("FrameDurationLimits");
  if (control == known_.end()) return 0;
  const auto& [id, info] = *control;
  // Not std::clamp: a bound that is not known is not a number.
  if (frame_us < number_of(info.min())) frame_us = number_of(info.min());
  if (frame_us > number_of(info.max())) frame_us = number_of(info.max());
  if (frame_us <= 0) return 0;
  const std::array<std::int64_t, 2> limits{std::llround(frame_us), std::llround(frame_us)};
  list_.set(id->id(), libcamera::ControlValue(libcamera::Span<const std::int64_t>(limits)));
  return frame_us;
}

libcamera::ControlInfoMap::const_iterator Settings::find(const char* name) const {
  return std::find_if(known_.begin(), known_.end(),
                      [&](const auto& control) { return control.first->name() == name; });
}

void expose(Settings& settings, double ms, double gain) {
  settings.set("ExposureTime", 1000 * ms);
  settings.set("AnalogueGain", gain);
}

NadirExposing set_exposure(Settings& settings, double frame_us, const NadirCameraWanted& wanted,
                           std::string& remarks) {
  constexpr double kAuto = 0, kManual = 1;  // of both modes, which 0.5 brought
  const NadirExposing exposing =
      steering(settings.bounds("ExposureTime"), settings.bounds("AnalogueGain"), frame_us, wanted);
  const bool steered = exposing.steered != 0;
  const bool fixed = wanted.exposure_ms > 0, fixed_gain = wanted.gain >= 0;
  if (settings.has("ExposureTimeMode")) {
    settings.set("ExposureTimeMode", fixed || steered ? kManual : kAuto);
    settings.set("AnalogueGainMode", fixed_gain || steered ? kManual : kAuto);
  } else {
    // With one of them fixed, it still finds the other.
    settings.set("AeEnable", steered || (fixed && fixed_gain) ? 0 : 1);
  }
  if (fixed && !settings.set("ExposureTime", 1000 * wanted.exposure_ms))
    remarks += "its exposure cannot be set to " + std::to_string(wanted.exposure_ms) + " ms\n";
  if (fixed_gain && !settings.set("AnalogueGain", wanted.gain))
    remarks += "its gain cannot be set to " + std::to_string(wanted.gain) + "\n";
  if (steered) expose(settings, exposing.ms, exposing.gain);
  return exposing;
}

void set_focus(Settings& settings, const NadirCameraWanted& wanted, std::string& remarks) {
  // A lens that moves has another calibration each time.
  constexpr double kManual = 0;
  if (settings.has("AfMode") && !settings.set("AfMode", kManual))
    remarks += "its autofocus cannot be turned off\n";
  if (wanted.focus >= 0 && !settings.set("LensPosition", wanted.focus))
    remarks += "its focus cannot be set to " + std::to_string(wanted.focus) + " dioptres\n";
}

double set_rate(Settings& settings, const NadirCameraWanted& wanted) {
  const double frame_us = wanted.rate_hz > 0 ? 1e6 / wanted.rate_hz : 0;  // 0: made the shortest
  return settings.set_frame_us(std::max(frame_us, 1000 * wanted.exposure_ms));
}

}  // namespace nadir::capture::plugin

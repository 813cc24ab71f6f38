// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "survey_sensors.hpp"

#include <numbers>
#include <utility>

namespace nadir::capture {

namespace fs = std::filesystem;

SurveySensors::SurveySensors(const fs::path& folder) {
  constexpr double kDeepest = 12000;  // metres
  attitude_ =
      load(folder / "ahrs.csv",
           {{"roll", -360, 360, true}, {"pitch", -180, 180, true}, {"yaw", -360, 360, true}});
  depth_ = load(folder / "depth.csv", {{"depth", -kDeepest, kDeepest}});
  altitude_ = load(folder / "altitude.csv", {{"altitude", 0, kDeepest}});
}

std::optional<SurveySensors::Sensor> SurveySensors::load(const fs::path& file,
                                                         const std::vector<SensorColumn>& columns) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  SensorLog log(file, columns);
  const std::string name = file.filename().string();
  if (log.dropped() > 0) {
    faults_.push_back(name + ": " + (log.size() == 0 ? "all " : "") +
                      std::to_string(log.dropped()) +
                      " rows were dropped: not finite, out of range, or of a time given before");
  } else if (log.size() == 0) {
    faults_.push_back(name + ": holds no row");
  }
  return Sensor{name, std::move(log), {}};
}

std::vector<Alert> SurveySensors::new_faults(Time time) {
  std::vector<Alert> alerts;
  for (const std::string& fault : std::exchange(faults_, {}))
    alerts.push_back(
        {time, std::nullopt, AlertKind::sensor_stale, fault, "check the sensor's log"});
  return alerts;
}

std::optional<SensorLog::Values> SurveySensors::Sensor::at(const Frame& frame,
                                                           std::vector<Alert>& alerts) {
  if (log.size() == 0) return std::nullopt;
  const auto values = log.at(frame.time);
  if (auto alert = silence.observe(frame, values.has_value(), file, log))
    alerts.push_back(*std::move(alert));
  return values;
}

void SurveySensors::Sensor::finish(std::vector<Alert>& alerts) {
  if (log.size() == 0) return;
  if (auto alert = silence.finish(file, log)) alerts.push_back(*std::move(alert));
}

void SurveySensors::read(Frame& frame, std::vector<Alert>& alerts) {
  const auto values_of = [&](std::optional<Sensor>& sensor) {
    return sensor ? sensor->at(frame, alerts) : std::nullopt;
  };
  constexpr double kDegree = std::numbers::pi / 180;
  if (const auto v = values_of(attitude_))
    frame.attitude = Attitude{(*v)[0] * kDegree, (*v)[1] * kDegree, (*v)[2] * kDegree};
  if (const auto v = values_of(depth_)) frame.depth = v->front();
  if (const auto v = values_of(altitude_)) frame.altitude = v->front();
}

void SurveySensors::finish(std::vector<Alert>& alerts) {
  for (std::optional<Sensor>* sensor : {&attitude_, &depth_, &altitude_})
    if (*sensor) (*sensor)->finish(alerts);
}

}  // namespace nadir::capture

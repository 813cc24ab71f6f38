// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/vehicle_state.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "nadir/core/check.hpp"
#include "nadir/sensors/input.hpp"

namespace nadir::sensors {
namespace {

constexpr Time kSecond = 1'000'000'000;
constexpr Time kSilence = 2 * kSecond;
constexpr Time kGood = 10 * kSecond;    // before the same is told again
constexpr Time kHold = kSecond / 10;    // the newest value stands for a later image
constexpr Time kMemory = 30 * kSecond;  // images come later than the values they need by less
constexpr double kTurn = 2 * std::numbers::pi;

struct Traits {
  std::string_view name;
  SensorTrack::Values periods;
  double fastest;  ///< change a second of any value that can be true; 0: anything can
};

// Faster than divers and ROVs turn and sink, by far.
Traits traits_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::tilt:
      return {"roll and pitch", {kTurn, 0, 0}, kTurn};
    case Quantity::heading:
      return {"heading", {kTurn, 0, 0}, kTurn};
    case Quantity::depth:
      return {"depth", {}, 10};
    case Quantity::altitude:
      return {"altitude", {}, 0};  // ground has edges
    case Quantity::position:
      return {"position", {}, 0};
  }
  return {};
}

bool is_jump(const Traits& traits, const SensorTrack::Row& from, Time time,
             const SensorTrack::Values& to) {
  // Values a moment apart differ by their noise.
  constexpr Time kShortest = kSecond / 10, kLongest = kSecond;
  const Time gap = time - from.time;
  if (traits.fastest <= 0 || gap > kLongest) return false;
  const double most = traits.fastest * seconds(std::max(gap, kShortest));
  for (std::size_t i = 0; i < to.size(); ++i) {
    const double step = to[i] - from.values[i], period = traits.periods[i];
    const double way = period > 0 ? std::remainder(step, period) : step;
    if (std::abs(way) > most) return true;
  }
  return false;
}

double turned(double angle) {
  const double rest = angle - kTurn * std::floor(angle / kTurn);
  return rest < kTurn ? rest : 0;
}

void require_delay(double delay, const char* key) {
  require_setting(delay >= 0 && delay <= 5, key, "0 to 5 seconds");
}

}  // namespace

void Config::check() const {
  (void)parse_inputs(inputs);
  require_delay(attitude_delay_s, "sensors.attitude_delay_s");
  require_delay(depth_delay_s, "sensors.depth_delay_s");
  require_delay(altitude_delay_s, "sensors.altitude_delay_s");
  require_setting(surface_pressure_hpa >= 500 && surface_pressure_hpa <= 1100,
                  "sensors.surface_pressure_hpa", "500 to 1100 hPa");
  require_setting(water_density >= 950 && water_density <= 1250, "sensors.water_density",
                  "950 to 1250 kg/m3");
  require_setting(std::abs(magnetic_variation_deg) <= 180, "sensors.magnetic_variation_deg",
                  "-180 to 180 degrees");
}

VehicleState::VehicleState(Config config, std::vector<std::string> names)
    : config_(std::move(config)), names_(std::move(names)), clocks_(names_.size()) {
  config_.check();
  for (const Quantity quantity : kQuantities) {
    channels_[static_cast<std::size_t>(quantity)].track = SensorTrack(traits_of(quantity).periods);
  }
}

// Crystals differ by less than 100 millionths: by so much an old offset may have become too early.
Time VehicleState::Clock::time_of(Time arrival_now, Time uptime) {
  constexpr Time kDrift = 10'000, kRestart = kSecond;
  const Time now = arrival_now - uptime;
  if (offset) *offset += (arrival_now - arrival) / kDrift;
  // Started again, it counts from 0.
  offset = offset && now - *offset < kRestart ? std::min(*offset, now) : now;
  arrival = arrival_now;
  return uptime + *offset;
}

void VehicleState::hear(std::size_t input, Time arrival, const Reading& reading) {
  NADIR_CHECK(input < names_.size(), input);
  const Time time = reading.uptime ? clocks_[input].time_of(arrival, *reading.uptime) : arrival;
  if (reading.variation) variation_ = reading.variation;
  if (reading.utc) {
    const Time offset = *reading.utc - time;
    constexpr Time kStep = 5 * kSecond;  // a clock that was set
    const bool stepped = utc_offset_ && std::abs(*utc_offset_ - offset) > kStep;
    utc_offset_ = utc_offset_ && !stepped ? std::max(*utc_offset_, offset) : offset;
  }
  if (reading.roll && reading.pitch) {
    add(Quantity::tilt, 2 * input, arrival, time - from_seconds(config_.attitude_delay_s),
        {*reading.roll, *reading.pitch, 0});
  }
  hear_heading(input, arrival, time, reading);
  hear_depth(input, arrival, time, reading);
  if (reading.altitude) {
    add(Quantity::altitude, 2 * input, arrival, time - from_seconds(config_.altitude_delay_s),
        {*reading.altitude, 0, 0});
  }
  if (reading.position) {
    add(Quantity::position, 2 * input, arrival, time,
        {reading.position->latitude_deg, reading.position->longitude_deg,
         reading.position->sigma.value_or(0)});
  }
}

void VehicleState::hear_heading(std::size_t input, Time arrival, Time time,
                                const Reading& reading) {
  time -= from_seconds(config_.attitude_delay_s);
  if (reading.heading) {
    add(Quantity::heading, 2 * input, arrival, time, {*reading.heading, 0, 0});
  } else if (reading.magnetic_heading) {
    const double variation =
        variation_.value_or(config_.magnetic_variation_deg * std::numbers::pi / 180);
    add(Quantity::heading, 2 * input + 1, arrival, time,
        {turned(*reading.magnetic_heading + variation), 0, 0});
  }
}

void VehicleState::hear_depth(std::size_t input, Time arrival, Time time, const Reading& reading) {
  constexpr double kGravity = 9.80665, kHectopascal = 100;
  time -= from_seconds(config_.depth_delay_s);
  if (reading.depth) {
    add(Quantity::depth, 2 * input, arrival, time, {*reading.depth, 0, 0});
  } else if (reading.pressure) {
    const double by_water = *reading.pressure - kHectopascal * config_.surface_pressure_hpa;
    add(Quantity::depth, 2 * input + 1, arrival, time,
        {by_water / (kGravity * config_.water_density), 0, 0});
  }
}

void VehicleState::add(Quantity quantity, std::size_t source, Time arrival, Time time,
                       const SensorTrack::Values& values) {
  Channel& channel = channels_[static_cast<std::size_t>(quantity)];
  const Traits traits = traits_of(quantity);
  if (channel.source != source) {
    if (channel.source && arrival - channel.heard < kSilence) return;
    channel.source = source;
    channel.track = SensorTrack(traits.periods);  // of two sensors nothing is interpolated
    channel.jumps = 0;
  }
  channel.heard = arrival;
  // A value that stays where it jumped to was right, and the one before was not.
  constexpr int kStays = 3;
  const auto& rows = channel.track.rows();
  if (!rows.empty() && is_jump(traits, rows.back(), time, values)) {
    channel.last_jump = arrival;
    if (++channel.jumps < kStays) return;
    channel.track = SensorTrack(traits.periods);
  }
  channel.jumps = 0;
  channel.track.add(time, values);
  channel.track.forget_before(time - kMemory);
}

std::optional<SensorTrack::Values> VehicleState::at(Quantity quantity, Time time) const {
  const SensorTrack& track = channel(quantity).track;
  if (const auto values = track.at(time)) return values;
  if (track.rows().empty()) return std::nullopt;
  const SensorTrack::Row& newest = track.rows().back();
  const bool fresh = newest.time <= time && time - newest.time <= kHold;
  return fresh ? std::optional(newest.values) : std::nullopt;
}

void VehicleState::mark(Frame& frame) const {
  const auto tilt = at(Quantity::tilt, frame.time), heading = at(Quantity::heading, frame.time);
  if (tilt && heading) frame.attitude = Attitude{(*tilt)[0], (*tilt)[1], (*heading)[0]};
  if (const auto depth = at(Quantity::depth, frame.time)) frame.depth = depth->front();
  if (const auto altitude = at(Quantity::altitude, frame.time)) frame.altitude = altitude->front();
}

std::optional<Position> VehicleState::position(Time time) const {
  const auto values = at(Quantity::position, time);
  if (!values) return std::nullopt;
  const auto& [latitude, longitude, sigma] = *values;
  return Position{latitude, longitude, sigma > 0 ? std::optional(sigma) : std::nullopt};
}

std::vector<Alert> VehicleState::new_alerts(Time now, std::optional<std::uint64_t> image) {
  std::vector<Alert> alerts;
  for (const Quantity quantity : kQuantities) {
    Channel& channel = channels_[static_cast<std::size_t>(quantity)];
    if (!channel.source) continue;
    const bool silent = now - channel.heard > kSilence;
    const bool jumps = channel.last_jump && now - *channel.last_jump < kSilence;
    if (!silent && !jumps) {
      if (channel.told && now - *channel.told > kGood) channel.told.reset();
      continue;
    }
    if (std::exchange(channel.told, now)) continue;
    const std::string what = names_[*channel.source / 2] + ": " +
                             std::string(traits_of(quantity).name) +
                             (silent ? " was not heard for 2 s"
                                     : " jumped by more than a vehicle can, and was left out");
    alerts.push_back({now, image, AlertKind::sensor_stale, what,
                      silent ? "check the sensor, its power and its cable; mapping goes on without"
                             : "check the sensor and its cable; magnets and motors disturb a "
                               "compass"});
  }
  return alerts;
}

}  // namespace nadir::sensors

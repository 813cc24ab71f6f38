// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/vehicle_state.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "angle.hpp"
#include "nadir/core/check.hpp"
#include "nadir/sensors/input.hpp"
#include "nadir/sensors/pose_output.hpp"

namespace nadir::sensors {
namespace {

constexpr Time kSecond = 1'000'000'000;
constexpr Time kSilence = 2 * kSecond;
constexpr Time kGood = 10 * kSecond;    // before the same is told again
constexpr Time kHold = kSecond / 10;    // the newest value stands for a later image
constexpr Time kMemory = 30 * kSecond;  // images come later than the values they need by less

constexpr Time kCrystal = 10'000;  // one in so many a clock may be off

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
      return {"position", {0, 360, 0}, 0};
  }
  return {};
}

bool is_jump(const Traits& traits, const SensorTrack::Row& from, Time time,
             const SensorTrack::Values& to) {
  // Values a moment apart differ by their noise.
  constexpr Time kShortest = kSecond / 10, kLongest = 2 * kSecond;
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

void require_delay(double delay, const char* key) {
  require_setting(delay >= 0 && delay <= 5, key, "0 to 5 seconds");
}

}  // namespace

void Config::check() const {
  (void)parse_inputs(inputs);
  (void)parse_outputs(outputs);
  require_setting(mavlink_system >= 1, "sensors.mavlink_system", "1 to 255");
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
    : config_(std::move(config)), names_(std::move(names)) {
  config_.check();
  for (const Quantity quantity : kQuantities) {
    channels_[static_cast<std::size_t>(quantity)].track = SensorTrack(traits_of(quantity).periods);
  }
}

// Crystals differ by less than 100 millionths: by so much an old offset may have become too early.
Time VehicleState::Clock::time_of(Time arrival, Time uptime) {
  const Time now = arrival - uptime;
  const bool started_again = uptime < uptime_;
  if (offset_ && !started_again) {
    offset_ = std::min(*offset_ + (arrival - arrival_) / kCrystal, now);
  } else {
    offset_ = now;
  }
  arrival_ = arrival;
  uptime_ = uptime;
  return uptime + *offset_;
}

void VehicleState::hear(std::size_t input, Time arrival, const Reading& reading) {
  NADIR_CHECK(input < names_.size(), input);
  constexpr std::uint32_t kSystemAndComponent = 0xFFFF;
  Moment moment{input, reading.sender, arrival, arrival};
  if (reading.uptime)
    moment.time =
        clocks_[{input, reading.sender & kSystemAndComponent}].time_of(arrival, *reading.uptime);
  if (reading.variation) variation_ = reading.variation;
  if (reading.utc) hear_utc(moment, *reading.utc);
  hear_heading(moment, reading);
  hear_depth(moment, reading);
  if (reading.roll && reading.pitch) {
    add(Quantity::tilt, moment.earlier(config_.attitude_delay_s), false,
        {*reading.roll, *reading.pitch, 0});
  }
  if (reading.altitude) {
    add(Quantity::altitude, moment.earlier(config_.altitude_delay_s), false,
        {*reading.altitude, 0, 0});
  }
  if (const auto& position = reading.position) {
    add(Quantity::position, moment, !position->sigma,
        {position->latitude_deg, position->longitude_deg, position->sigma.value_or(0)});
  }
}

// The least delayed is believed, as of a sender's own clock.
void VehicleState::hear_utc(const Moment& moment, Time utc) {
  constexpr Time kStep = 5 * kSecond;  // a clock that was set
  const Time offset = utc - moment.time;
  const bool stepped = utc_offset_ && std::abs(*utc_offset_ - offset) > kStep;
  if (utc_offset_ && !stepped) {
    utc_offset_ = std::max(*utc_offset_ - (moment.arrival - utc_heard_) / kCrystal, offset);
  } else {
    utc_offset_ = offset;
  }
  utc_heard_ = moment.arrival;
}

void VehicleState::hear_heading(const Moment& moment, const Reading& reading) {
  const Moment when = moment.earlier(config_.attitude_delay_s);
  if (reading.heading) {
    add(Quantity::heading, when, false, {*reading.heading, 0, 0});
  } else if (reading.magnetic_heading) {
    const double variation =
        variation_.value_or(config_.magnetic_variation_deg * std::numbers::pi / 180);
    add(Quantity::heading, when, true, {as_heading(*reading.magnetic_heading + variation), 0, 0});
  }
}

void VehicleState::hear_depth(const Moment& moment, const Reading& reading) {
  constexpr double kGravity = 9.80665, kHectopascal = 100;
  const Moment when = moment.earlier(config_.depth_delay_s);
  if (reading.depth) {
    add(Quantity::depth, when, false, {*reading.depth, 0, 0});
  } else if (reading.pressure) {
    const double by_water = *reading.pressure - kHectopascal * config_.surface_pressure_hpa;
    add(Quantity::depth, when, true, {by_water / (kGravity * config_.water_density), 0, 0});
  }
}

void VehicleState::add(Quantity quantity, Moment moment, bool lesser,
                       const SensorTrack::Values& values) {
  Channel& channel = channels_[static_cast<std::size_t>(quantity)];
  const Traits traits = traits_of(quantity);
  const Source source{moment.input, moment.sender, lesser};
  if (channel.source != source) {
    const bool silent = channel.source && moment.arrival - channel.heard >= kSilence;
    const bool better = channel.source && channel.source->lesser && !lesser &&
                        channel.source->input == moment.input;
    if (channel.source && !silent && !better) return;
    if (silent) channel.fallen_silent = channel.source;
    channel.source = source;
    channel.track = SensorTrack(traits.periods);  // of two sensors nothing is interpolated
    channel.candidate.reset();
  }
  channel.heard = moment.arrival;
  const SensorTrack::Row row{moment.time, values};
  const auto& rows = channel.track.rows();
  if (!rows.empty() && is_jump(traits, rows.back(), row.time, values)) {
    channel.last_jump = moment.arrival;
    // Values that agree on where they have jumped to are right, and those before were not.
    constexpr int kEnough = 3;
    const bool agrees = channel.candidate && !is_jump(traits, *channel.candidate, row.time, values);
    channel.candidates = agrees ? channel.candidates + 1 : 1;
    channel.candidate = row;
    if (channel.candidates < kEnough) return;
    channel.track = SensorTrack(traits.periods);
  }
  channel.candidate.reset();
  channel.track.add(row.time, values);
  channel.track.forget_before(row.time - kMemory);
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
    const auto replaced = std::exchange(channel.fallen_silent, std::nullopt);
    const bool silent = now - channel.heard > kSilence;
    const bool jumps = channel.last_jump && now - *channel.last_jump < kSilence;
    if (!silent && !jumps && !replaced) {
      if (channel.told && now - *channel.told > kGood) channel.told.reset();
      continue;
    }
    if (std::exchange(channel.told, now)) continue;
    const Source& source = replaced ? *replaced : *channel.source;
    std::string what =
        names_[source.input] + ": " + std::string(traits_of(quantity).name) +
        (silent || replaced ? " was not heard for 2 s"
                            : " jumped by more than a vehicle can, and was left out");
    if (replaced && !silent) what += "; " + names_[channel.source->input] + " stands in for it";
    alerts.push_back(
        {now, image, AlertKind::sensor_stale, what,
         silent || replaced
             ? "check the sensor, its power and its cable; mapping goes on without it"
             : "check the sensor and its cable; magnets and motors disturb a compass"});
  }
  return alerts;
}

}  // namespace nadir::sensors

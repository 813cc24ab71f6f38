// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensors.hpp"

#include <cmath>
#include <numbers>

#include "random.hpp"

namespace nadir::simulate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// First-order Gauss-Markov process, standard deviation 1, correlated over `seconds`.
class Correlated {
 public:
  Correlated(double step, double seconds) : keep_(std::exp(-step / seconds)) {}
  double next(Random& random) {
    value_ = started_ ? keep_ * value_ + std::sqrt(1 - keep_ * keep_) * random.normal()
                      : random.normal();
    started_ = true;
    return value_;
  }

 private:
  double keep_, value_ = 0;
  bool started_ = false;
};

}  // namespace

std::vector<AttitudeReading> attitude_readings(const Path& path, double end, std::uint64_t seed) {
  constexpr double kStep = 0.1, kTilt = 0.3 * kDegree, kYaw = 1 * kDegree;
  constexpr double kBias = 0.7 * kDegree, kDrift = 2 * kDegree, kDriftPeriod = 240;
  Random random(hash(seed, 'a'));
  const double phase = random.uniform(0, 2 * std::numbers::pi);
  Correlated roll(kStep, 2), pitch(kStep, 2), yaw(kStep, 2);
  const auto error = [&](Correlated& slow) {
    const double white = random.normal();
    return std::sqrt(0.5) * (white + slow.next(random));
  };
  std::vector<AttitudeReading> readings;
  for (int i = 0; i * kStep <= end; ++i) {
    const double t = i * kStep;
    Attitude a = path.at(t).attitude;
    a.roll += kTilt * error(roll);
    a.pitch += kTilt * error(pitch);
    const double slow = kDrift * std::sin(2 * std::numbers::pi * t / kDriftPeriod + phase);
    a.yaw = std::remainder(a.yaw + kBias + slow + kYaw * error(yaw), 2 * std::numbers::pi);
    readings.push_back({t, a});
  }
  return readings;
}

std::vector<DepthReading> depth_readings(const Path& path, double surface, double end,
                                         std::uint64_t seed) {
  constexpr double kStep = 0.2, kSigma = 0.01;
  Random random(hash(seed, 'd'));
  std::vector<DepthReading> readings;
  for (int i = 0; i * kStep <= end; ++i) {
    const double t = i * kStep;
    readings.push_back({t, surface - path.at(t).x_in_local.z() + kSigma * random.normal()});
  }
  return readings;
}

}  // namespace nadir::simulate

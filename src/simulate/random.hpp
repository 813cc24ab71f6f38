// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Random numbers that are the same on every machine and in every thread: a counter, hashed.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace nadir::simulate {

/// SplitMix64's output function (Steele, Lea, Flood 2014): a bijection that looks random.
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

/// One number of its own for each list of keys.
template <class... Keys>
constexpr std::uint64_t hash(std::uint64_t seed, Keys... keys) {
  ((seed = mix(seed ^ static_cast<std::uint64_t>(keys))), ...);
  return seed;
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : counter_(mix(seed)) {}

  std::uint64_t bits() { return mix(counter_++); }
  /// In [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Standard normal (Box and Muller 1958).
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t counter_;
};

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "noise.hpp"

#include <algorithm>
#include <cmath>

namespace nadir::simulate {
namespace {

// Integer finaliser with low bias (Wellons' "lowbias32"); 32 bits because it runs for every pixel.
std::uint32_t scramble(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352d;
  h ^= h >> 15;
  h *= 0x846ca68b;
  return h ^ (h >> 16);
}

std::uint32_t lattice(int x, int y, std::uint32_t seed) {
  return scramble(static_cast<std::uint32_t>(x) * 0x8da6b343 +
                  static_cast<std::uint32_t>(y) * 0xd8163841 + seed * 0xcb1ab31f);
}

std::uint32_t lattice(int x, int y, int z, std::uint32_t seed) {
  return lattice(x, y, seed + static_cast<std::uint32_t>(z) * 0x165667b1);
}

float signed_unit(std::uint32_t h) { return static_cast<float>(h >> 8) * 0x1p-23f - 1.0f; }

// std::floor is a library call on baseline x86-64.
int floor_of(double x) {
  const int i = static_cast<int>(x);
  return i - (x < i);
}

float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

float lerp(float a, float b, float t) { return a + (b - a) * t; }

}  // namespace

float noise(double x, double y, std::uint32_t seed) {
  const int i = floor_of(x), j = floor_of(y);
  const float u = fade(static_cast<float>(x - i)), v = fade(static_cast<float>(y - j));
  const auto at = [&](int a, int b) { return signed_unit(lattice(i + a, j + b, seed)); };
  return lerp(lerp(at(0, 0), at(1, 0), u), lerp(at(0, 1), at(1, 1), u), v);
}

float noise(const Eigen::Vector3d& x, std::uint32_t seed) {
  const int i = floor_of(x.x()), j = floor_of(x.y()), k = floor_of(x.z());
  const float u = fade(static_cast<float>(x.x() - i)), v = fade(static_cast<float>(x.y() - j));
  const float w = fade(static_cast<float>(x.z() - k));
  const auto layer = [&](int c) {
    const auto at = [&](int a, int b) { return signed_unit(lattice(i + a, j + b, k + c, seed)); };
    return lerp(lerp(at(0, 0), at(1, 0), u), lerp(at(0, 1), at(1, 1), u), v);
  };
  return lerp(layer(0), layer(1), w);
}

float visible(double size, double footprint) {
  return static_cast<float>(std::clamp(size / footprint - 1, 0.0, 1.0));
}

float Fractal::operator()(double x, double y, double footprint) const {
  constexpr double kCos = 0.8, kSin = 0.6;  // each octave turned: no common lattice is seen
  double size = largest;
  float sum = 0, amplitude = 1;
  for (int octave = 0; octave < octaves; ++octave) {
    const float weight = amplitude * visible(size, footprint);
    if (weight <= 0) break;
    sum += weight * noise(x / size, y / size, seed + static_cast<std::uint32_t>(octave));
    const double turned = kCos * x - kSin * y;
    y = kSin * x + kCos * y;
    x = turned;
    size /= 2;
    amplitude *= persistence;
  }
  return sum;
}

Cell cell(double x, double y, std::uint32_t seed) {
  const int i = floor_of(x), j = floor_of(y);
  const Eigen::Vector2f here(static_cast<float>(x - i), static_cast<float>(y - j));
  Cell nearest{9, 9, Eigen::Vector2f::Zero(), 0};
  float first = 9, second = 9;  // squared
  for (int b = -1; b <= 1; ++b) {
    for (int a = -1; a <= 1; ++a) {
      const std::uint32_t id = lattice(i + a, j + b, seed);
      const Eigen::Vector2f point(
          static_cast<float>(a) + static_cast<float>(id & 0xffff) * 0x1p-16f,
          static_cast<float>(b) + static_cast<float>(id >> 16) * 0x1p-16f);
      const Eigen::Vector2f from = here - point;
      const float squared = from.squaredNorm();
      if (squared < first) {
        second = first;
        first = squared;
        nearest.from = from;
        nearest.id = id;
      } else {
        second = std::min(second, squared);
      }
    }
  }
  nearest.distance = std::sqrt(first);
  nearest.border = std::sqrt(second) - nearest.distance;
  return nearest;
}

float random_of(std::uint32_t id, std::uint32_t k) {
  return static_cast<float>(scramble(id + k * 0x9e3779b9) >> 8) * 0x1p-24f;
}

}  // namespace nadir::simulate

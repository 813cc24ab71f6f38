// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "shading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "noise.hpp"

namespace nadir::simulate {
namespace {

using cv::Vec3f;
using Eigen::Vector3d;

float clamp01(float x) { return std::clamp(x, 0.0f, 1.0f); }

float smooth(float low, float high, float x) {
  const float t = clamp01((x - low) / (high - low));
  return t * t * (3 - 2 * t);
}

Vec3f blend(const Vec3f& a, const Vec3f& b, float t) { return a * (1 - t) + b * t; }

// Share of a pixel inside an edge at signed distance d (metres, negative inside).
float inside(double d, double footprint) {
  return clamp01(static_cast<float>(0.5 - d / footprint));
}

// Sand grains and dirt: the contrast that tie points live on, from 10 cm down to the pixel.
float grain(double x, double y, double footprint, std::uint32_t seed) {
  return Fractal{0.032, 5, 0.95f, seed}(x, y, footprint) +
         0.3f * Fractal{0.25, 2, 0.8f, seed + 7}(x, y, footprint);
}

struct Ground {
  Vec3f albedo;
  Vector3d tilt = Vector3d::Zero();
};

// Pebbles: each its own grey and tint, rounded, dark gaps between.
Ground pebbles(double x, double y, double size, double footprint, const Vec3f& dark,
               const Vec3f& bright, std::uint32_t seed) {
  const Cell c = cell(x / size, y / size, seed);
  const float shown = visible(size, footprint);
  const float tone = random_of(c.id, 1), warm = random_of(c.id, 2) - 0.5f;
  const float gap = 0.35f + 0.65f * smooth(0.02f, 0.22f, c.border);
  Vec3f colour = blend(dark, bright, tone);
  colour[0] *= 1 - 0.25f * warm;
  colour[2] *= 1 + 0.35f * warm;
  Ground ground{blend((dark + bright) * 0.42f, colour * gap, shown)};
  const double bulge = 0.75 * static_cast<double>(shown);
  ground.tilt = {bulge * static_cast<double>(c.from.x()), bulge * static_cast<double>(c.from.y()),
                 0};
  return ground;
}

Ground concrete(double x, double y, double footprint, std::uint32_t seed) {
  const float stain = Fractal{0.7, 3, 0.6f, seed + 10}(x, y, footprint);
  const float fine = grain(x, y, footprint, seed + 20);
  const Cell pit = cell(x / 0.045, y / 0.045, seed + 30);
  const float pitted = random_of(pit.id, 1) < 0.35f
                           ? inside(0.045 * static_cast<double>(pit.distance) -
                                        0.008 * static_cast<double>(random_of(pit.id, 2)),
                                    footprint)
                           : 0.0f;
  const float tone = (1 + 0.22f * stain + 0.26f * fine) * (1 - 0.6f * pitted);
  return {Vec3f(0.36f, 0.34f, 0.31f) * std::max(tone, 0.3f)};
}

Ground gravel(double x, double y, double footprint, std::uint32_t seed) {
  Ground bed = pebbles(x, y, 0.026, footprint, {0.10f, 0.12f, 0.12f}, {0.48f, 0.56f, 0.58f}, seed);
  const float fine = grain(x, y, footprint, seed + 20);
  const float silt = smooth(-0.05f, 0.45f, Fractal{0.9, 4, 0.55f, seed + 40}(x, y, footprint));
  const Vec3f mud = Vec3f(0.13f, 0.19f, 0.17f) * std::max(1 + 0.5f * fine, 0.2f);
  bed.albedo = blend(bed.albedo * (1 + 0.15f * fine), mud, 0.85f * silt);
  bed.tilt *= 1 - 0.85 * static_cast<double>(silt);
  return bed;
}

Ground rubble(double x, double y, double footprint, float fine, std::uint32_t seed) {
  Ground bed = pebbles(x, y, 0.045, footprint, {0.14f, 0.15f, 0.13f}, {0.44f, 0.50f, 0.50f}, seed);
  const float crust = smooth(0.25f, 0.5f, Fractal{0.5, 3, 0.6f, seed + 60}(x, y, footprint));
  bed.albedo = blend(bed.albedo * (1 + 0.2f * fine), {0.30f, 0.19f, 0.33f}, 0.6f * crust);
  return bed;
}

// Rubble between sand and weed; what is wholly covered is not worked out.
Ground reef_floor(double x, double y, double footprint, std::uint32_t seed) {
  const float fine = grain(x, y, footprint, seed + 20);
  const float where = Fractal{2.2, 4, 0.55f, seed + 40}(x, y, footprint);
  const float sandy = smooth(0.15f, 0.40f, where), weedy = smooth(0.05f, 0.30f, -where);
  const float bare = (1 - sandy) * (1 - weedy);
  Ground floor{};
  if (bare > 0) floor = rubble(x, y, footprint, fine, seed);
  floor.tilt *= static_cast<double>(bare);
  if (sandy > 0) {
    const Vec3f sand = Vec3f(0.40f, 0.47f, 0.48f) * std::max(1 + 0.28f * fine, 0.3f);
    floor.albedo = blend(floor.albedo, sand, sandy);
  }
  if (weedy > 0) {
    const float turf = Fractal{0.12, 4, 0.8f, seed + 50}(x, y, footprint);
    const Vec3f weed = blend({0.07f, 0.14f, 0.10f}, {0.14f, 0.27f, 0.24f}, clamp01(0.5f + turf)) *
                       std::max(1 + 0.35f * fine, 0.2f);
    floor.albedo = blend(floor.albedo, weed, weedy);
  }
  return floor;
}

Ground sand(double x, double y, double footprint, std::uint32_t seed) {
  const float fine = grain(x, y, footprint, seed + 20);
  const float bend = Fractal{0.8, 2, 0.5f, seed + 70}(x, y, footprint);
  const double phase = 2 * std::numbers::pi * (y + 0.35 * x) / 0.13 + 5 * static_cast<double>(bend);
  const float crest = static_cast<float>(std::sin(phase));
  const float patch = smooth(0.12f, 0.35f, Fractal{1.1, 5, 0.6f, seed + 40}(x, y, footprint));
  const float tone = 1 + 0.26f * fine + 0.14f * crest;
  Ground floor{Vec3f(0.30f, 0.34f, 0.34f) * std::max(tone, 0.3f)};
  floor.tilt = {0, 0.28 * std::cos(phase), 0};
  const Ground lag =
      pebbles(x, y, 0.018, footprint, {0.09f, 0.10f, 0.11f}, {0.34f, 0.37f, 0.38f}, seed + 80);
  floor.albedo = blend(floor.albedo, lag.albedo, patch);
  floor.tilt =
      floor.tilt * (1 - static_cast<double>(patch)) + lag.tilt * static_cast<double>(patch);
  return floor;
}

Ground ground(const Scene& scene, const Vector3d& x, double footprint) {
  switch (scene.kind) {
    case SceneKind::pool:
      return concrete(x.x(), x.y(), footprint, scene.seed);
    case SceneKind::transect:
      return gravel(x.x(), x.y(), footprint, scene.seed);
    case SceneKind::reef:
      return reef_floor(x.x(), x.y(), footprint, scene.seed);
    case SceneKind::wreck:
      return sand(x.x(), x.y(), footprint, scene.seed);
  }
  return {};
}

// Contrast plates: islands, discs or pebbles on a pale board with a dark rim.
Vec3f plate_pattern(const Slab& slab, const Vector3d& place, double footprint) {
  const Vec3f pale(0.42f, 0.47f, 0.48f), dark(0.035f, 0.035f, 0.035f);
  const double x = place.x(), y = place.y();
  const double rim = std::max(std::abs(x) - slab.half.x(), std::abs(y) - slab.half.y());
  Vec3f colour = pale;
  switch (slab.seed % 3) {
    case 0: {
      const float level = Fractal{0.11, 5, 0.6f, slab.seed}(x, y, footprint);
      colour = blend(pale, dark, smooth(-0.04f, 0.04f, level - 0.12f));
      break;
    }
    case 1: {
      const Cell c = cell(x / 0.07, y / 0.07, slab.seed);
      const double radius = 0.07 * (0.15 + 0.35 * static_cast<double>(random_of(c.id, 1)));
      const float disc = inside(0.07 * static_cast<double>(c.distance) - radius, footprint);
      colour = blend(pale, blend(dark, pale, 0.6f * random_of(c.id, 2)), disc);
      break;
    }
    default:
      colour =
          pebbles(x, y, 0.032, footprint, {0.06f, 0.06f, 0.06f}, {0.5f, 0.52f, 0.53f}, slab.seed)
              .albedo;
  }
  const float dirt = 1 + 0.12f * grain(x, y, footprint, slab.seed + 5);
  return blend(pale, colour, inside(rim + 0.012, footprint)) * dirt;
}

// A white disc and a ring of twelve coded segments on black, pale rim.
Vec3f target_pattern(const Slab& slab, const Vector3d& place, double footprint) {
  const double side = 2 * slab.half.x(), r = std::hypot(place.x(), place.y());
  const double rim = std::max(std::abs(place.x()), std::abs(place.y())) - 0.475 * side;
  const double turn = (std::atan2(place.y(), place.x()) / std::numbers::pi + 1) * 6;
  const bool bit = (slab.seed >> (static_cast<int>(turn) % 12)) & 1;
  const double ring = std::abs(r - 0.30 * side) - 0.06 * side;
  const float white = std::max({inside(r - kDiscShare * side / 2, footprint),
                                bit ? inside(ring, footprint) : 0.0f, 1 - inside(rim, footprint)});
  return blend({0.03f, 0.03f, 0.03f}, {0.62f, 0.64f, 0.64f}, white);
}

Vec3f solid_colour(const Solid& solid, const Vector3d& place, double footprint) {
  const std::uint32_t seed = static_cast<std::uint32_t>(solid.tint * 1e6f);
  const double size = solid.radius;  // place is on the unit sphere
  const auto speckle = [&](double cell_size, float amplitude) {
    float sum = 0, weight = amplitude;
    for (std::uint32_t i = 0; i < 4; ++i, cell_size /= 2.1, weight *= 0.8f) {
      const float shown = visible(cell_size, footprint);
      if (shown <= 0) break;
      sum += weight * shown * noise(Vector3d(place * (size / cell_size)), seed + i);
    }
    return sum;
  };
  switch (solid.material) {
    case Material::rock:
      return blend({0.22f, 0.25f, 0.26f}, {0.40f, 0.43f, 0.42f}, solid.tint) *
             std::max(1 + speckle(0.06, 0.55f), 0.15f);
    case Material::coral: {
      const Vec3f base = solid.tint < 0.35f   ? Vec3f(0.20f, 0.33f, 0.36f)
                         : solid.tint < 0.65f ? Vec3f(0.34f, 0.24f, 0.30f)
                                              : Vec3f(0.20f, 0.30f, 0.24f);
      return base * std::max(1 + speckle(0.035, 0.7f), 0.15f);
    }
    case Material::urchin:
      return Vec3f(0.09f, 0.04f, 0.08f) * std::max(1 + speckle(0.012, 0.9f), 0.1f);
    case Material::starfish:
      return blend({0.08f, 0.22f, 0.52f}, {0.22f, 0.42f, 0.50f}, solid.tint) *
             std::max(1 + speckle(0.015, 0.5f), 0.2f);
    default:
      return blend({0.16f, 0.24f, 0.30f}, {0.24f, 0.31f, 0.35f}, solid.tint) *
             std::max(1 + speckle(0.08, 0.5f), 0.15f);
  }
}

Vec3f slab_colour(const Solid& solid, const Slab& slab, const Vector3d& place, double footprint) {
  const bool on_top = place.z() > -1e-6;
  if (solid.material == Material::target) {
    return on_top ? target_pattern(slab, place, footprint) : Vec3f(0.05f, 0.05f, 0.05f);
  }
  if (on_top) return plate_pattern(slab, place, footprint);
  return Vec3f(0.20f, 0.21f, 0.22f) *
         (1 + 0.3f * grain(place.x() + place.y(), place.z(), footprint, slab.seed));
}

}  // namespace

Skin skin(const Scene& scene, const Scene::Meeting& meeting, double footprint) {
  const Hit& hit = meeting.hit;
  if (!meeting.solid) {
    const Ground g = ground(scene, hit.place, footprint);
    return {g.albedo, (hit.normal + g.tilt).normalized()};
  }
  const auto* slab = std::get_if<Slab>(&meeting.solid->shape);
  return {slab ? slab_colour(*meeting.solid, *slab, hit.place, footprint)
               : solid_colour(*meeting.solid, hit.place, footprint),
          hit.normal};
}

namespace {

// A beam is some 10 mm wide and outshines the lamps several times.
float laser(const Light& light, const Vector3d& place) {
  constexpr double kSigma = 0.0045;
  float sum = 0;
  for (const Light::Beam& beam : light.beams) {
    const double squared = beam.direction.cross(place - beam.origin).squaredNorm();
    if (squared > 16 * kSigma * kSigma) continue;
    sum += 12 * static_cast<float>(std::exp(-squared / (2 * kSigma * kSigma)));
  }
  return sum;
}

}  // namespace

Vec3f radiance(const Light& light, const Skin& skin, const Vector3d& place, const Vector3d& eye,
               float open) {
  const double to_eye = (eye - place).norm();
  Vec3f lit(0, 0, 0);
  for (const Light::Source& source : light.sources) {
    const Vector3d to_lamp = source.position - place;
    const double squared = to_lamp.squaredNorm(), distance = std::sqrt(squared);
    const double facing = std::max(0.0, skin.normal.dot(to_lamp) / distance);
    const double aimed = std::max(0.0, -source.direction.dot(to_lamp) / distance);
    const float arriving = source.power * std::pow(static_cast<float>(aimed), source.sharpness) *
                           static_cast<float>(facing / squared) * (0.5f + 0.5f * open);
    for (int c = 0; c < 3; ++c) {
      lit[c] +=
          arriving * std::exp(-light.water.attenuation[c] * static_cast<float>(distance + to_eye));
    }
  }
  lit[1] += laser(light, place);
  const float up = 0.4f + 0.6f * static_cast<float>(std::max(0.0, skin.normal.z()));
  Vec3f seen;
  for (int c = 0; c < 3; ++c) {
    const float through = std::exp(-light.water.attenuation[c] * static_cast<float>(to_eye));
    lit[c] += light.water.ambient[c] * up * open * through;
    seen[c] = skin.albedo[c] * lit[c] + light.water.veil[c] * (1 - through);
  }
  return seen;
}

}  // namespace nadir::simulate

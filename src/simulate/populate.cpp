// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// make_scene: raises the relief and lays things on it until each scene's densities are met.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "noise.hpp"
#include "random.hpp"
#include "scene.hpp"

namespace nadir::simulate {
namespace {

using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector2d, Eigen::Vector3d, std::numbers::pi;

struct Box {
  Vector2d low, high;
  double area() const { return (high - low).prod(); }
};

// What the camera can see from the path, with a margin.
Box seen_from(const Profile& profile, const Path& path, int images) {
  const CameraModel& camera = profile.camera;
  const double reach =
      1.35 * profile.altitude * std::hypot(camera.width, camera.height) / 2 / camera.fx;
  Box box{Vector2d::Constant(1e9), Vector2d::Constant(-1e9)};
  const double end = path.seconds(images - 1);
  for (double t = 0; t <= end + profile.interval / 4; t += profile.interval / 4) {
    const Vector2d xy = path.at(std::min(t, end)).x_in_local.head<2>();
    box.low = box.low.cwiseMin(xy - Vector2d::Constant(reach));
    box.high = box.high.cwiseMax(xy + Vector2d::Constant(reach));
  }
  return box;
}

double octave(const Vector2d& size_and_amplitude, int number, std::uint32_t seed, double x,
              double y) {
  const double size = size_and_amplitude.x(), turn = 0.6 + number;
  const double u = std::cos(turn) * x - std::sin(turn) * y;
  const double v = std::sin(turn) * x + std::cos(turn) * y;
  return size_and_amplitude.y() *
         static_cast<double>(noise(u / size, v / size, seed + static_cast<std::uint32_t>(number)));
}

Relief raise(const Profile& profile, std::uint32_t seed, const Box& box) {
  Relief relief;
  relief.cell = profile.cell;
  relief.x0 = box.low.x(), relief.y0 = box.low.y();
  const int columns = static_cast<int>((box.high.x() - relief.x0) / relief.cell) + 2;
  const int rows = static_cast<int>((box.high.y() - relief.y0) / relief.cell) + 2;
  relief.height = cv::Mat1f(rows, columns);
  relief.light = cv::Mat1f(rows, columns, 1.0f);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      double z = 0;
      for (std::size_t i = 0; i < profile.relief.size(); ++i) {
        z += octave(profile.relief[i], static_cast<int>(i), seed, relief.x0 + column * relief.cell,
                    relief.y0 + row * relief.cell);
      }
      relief.height(row, column) = static_cast<float>(z);
    }
  }
  return relief;
}

Quaterniond about_z(double angle) { return Quaterniond(AngleAxisd(angle, Vector3d::UnitZ())); }

// Lays things down; keeps apart those that must not touch. Random numbers are drawn one a statement
// or in braces: the order of a call's arguments is the compiler's choice.
class Layout {
 public:
  Layout(Scene& scene, const Box& box, std::uint64_t seed)
      : scene_(scene), box_(box), random_(hash(seed, 'l')) {}

  Random& random() { return random_; }
  double yaw() { return random_.uniform(0, 2 * pi); }
  std::uint32_t seed() { return static_cast<std::uint32_t>(random_.bits()); }
  Vector2d anywhere() {
    const double x = random_.uniform(box_.low.x(), box_.high.x());
    return {x, random_.uniform(box_.low.y(), box_.high.y())};
  }

  /// Calls put(place) for so many places per square metre, each `radius` clear of all others.
  template <class Put>
  void scatter(double per_square_metre, double smallest, double largest, Put put) {
    const int number = static_cast<int>(std::lround(per_square_metre * box_.area()));
    for (int i = 0; i < number; ++i) {
      const double size = smallest * std::pow(largest / smallest, random_.uniform());
      const Vector2d place = anywhere();
      if (reserve(place, size)) put(place, size);
    }
  }

  bool reserve(const Vector2d& place, double radius) {
    for (const auto& [other, r] : taken_) {
      if ((place - other).norm() < radius + r) return false;
    }
    taken_.emplace_back(place, radius);
    return true;
  }

  /// Rests on its belly, `sunk` of its height in the ground.
  void blob(Material material, const Vector2d& place, const Vector3d& radii, double sunk,
            float roughness, float frequency, int arms = 0) {
    const double z = scene_.relief.z(place.x(), place.y()) + (1 - 2 * sunk) * radii.z();
    const Quaterniond turned = about_z(yaw());
    Solid solid =
        make_blob(material, {place.x(), place.y(), z}, radii, turned, roughness, frequency, seed());
    std::get<Blob>(solid.shape).arms = arms;
    scene_.solids.push_back(solid);
  }

  /// Lies on the ground, touching its highest point; `tilt` rad at most besides the ground's own.
  Rigid3 slab(Material material, const Vector2d& place, const Vector3d& half, double angle,
              double tilt) {
    const Vector3d axis = about_z(yaw()) * Vector3d::UnitX();
    const Vector3d up = Quaterniond(AngleAxisd(random_.uniform(0, tilt), axis)) *
                        mean_normal(place, half.head<2>().norm());
    Rigid3 pose{Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up) * about_z(angle),
                {place.x(), place.y(), 0}};
    pose.translation.z() = lowest_rest(pose, half) + half.z();
    scene_.solids.push_back(make_slab(material, pose, half, seed()));
    return pose;
  }

 private:
  double top(double x, double y) const {
    const Ray down{{x, y, 50}, {0, 0, -1}};
    return 50 - scene_.meet(down)->hit.t;
  }

  Vector3d mean_normal(const Vector2d& p, double r) const {
    const Relief& g = scene_.relief;
    return Vector3d(g.z(p.x() - r, p.y()) - g.z(p.x() + r, p.y()),
                    g.z(p.x(), p.y() - r) - g.z(p.x(), p.y() + r), 2 * r)
        .normalized();
  }

  // The lowest z of the slab's underside with nothing above it.
  double lowest_rest(const Rigid3& pose, const Vector3d& half) const {
    constexpr int kProbes = 4;
    double highest = -1e9;
    for (int i = -kProbes; i <= kProbes; ++i) {
      for (int j = -kProbes; j <= kProbes; ++j) {
        const Vector3d x = pose * Vector3d(half.x() * i / kProbes, half.y() * j / kProbes, 0);
        highest = std::max(highest, top(x.x(), x.y()) - x.z());
      }
    }
    return highest;
  }

  Scene& scene_;
  Box box_;
  Random random_;
  std::vector<std::pair<Vector2d, double>> taken_;
};

void lay_targets(Layout& layout, Scene& scene, const Profile& profile, const Path& path,
                 int images) {
  constexpr double kThickness = 0.012;
  const double length = profile.spacing * (images - 1);
  const int number = std::max(4, static_cast<int>(length / profile.targets) + 1);
  for (int i = 0; i < number; ++i) {
    const double arc = length * (i + layout.random().uniform(0.2, 0.8)) / number;
    const auto course = path.course(arc);
    const double aside = 0.22 * profile.altitude * layout.random().uniform(-1, 1);
    const Vector2d right(std::cos(course.heading), -std::sin(course.heading));
    const Vector2d place = course.position + aside * right;
    if (!layout.reserve(place, 0.75 * profile.target)) continue;
    const Vector3d half(profile.target / 2, profile.target / 2, kThickness);
    const Rigid3 pose = layout.slab(Material::target, place, half, layout.yaw(), 0.04);
    char id[16];
    std::snprintf(id, sizeof id, "T%02zu", scene.plates.size() + 1);
    scene.plates.push_back({id, pose, kDiscShare * profile.target, profile.target});
  }
}

void furnish_pool(Layout& layout, const Box& box) {
  Random& random = layout.random();
  for (double y = box.low.y(); y < box.high.y(); y += 0.82) {
    for (const double x : {-1.15, -0.4, 0.38, 1.2}) {
      if (random.uniform() > 0.62) continue;
      const Vector2d place{x + random.uniform(-0.05, 0.05), y + random.uniform(-0.06, 0.06)};
      const double half = random.uniform(0.26, 0.33), turn = random.uniform(-0.06, 0.06);
      const bool tall = random.uniform() < 0.12;
      const Vector3d size(half, half, tall ? random.uniform(0.06, 0.18) : 0.012);
      layout.slab(tall ? Material::box : Material::plate, place, size, turn, 0.01);
    }
  }
}

void stones(Layout& layout, double density, double smallest, double largest) {
  layout.scatter(density, smallest, largest, [&](const Vector2d& place, double size) {
    Random& random = layout.random();
    const Vector3d radii{size, size * random.uniform(0.6, 0.95), size * random.uniform(0.4, 0.75)};
    layout.blob(Material::rock, place, radii, random.uniform(0.2, 0.4), 0.16f, 2.0f);
  });
}

void urchins(Layout& layout, double density) {
  layout.scatter(density, 0.035, 0.065, [&](const Vector2d& place, double size) {
    layout.blob(Material::urchin, place, {size, size, 0.7 * size}, 0.15, 0.30f, 7.0f);
  });
}

void starfish(Layout& layout, double density) {
  layout.scatter(density, 0.07, 0.13, [&](const Vector2d& place, double size) {
    layout.blob(Material::starfish, place, {size, size, 0.16 * size}, 0.2, 0.05f, 6.0f, 5);
  });
}

void corals(Layout& layout, double density) {
  layout.scatter(density, 0.14, 0.42, [&](const Vector2d& place, double size) {
    Random& random = layout.random();
    const Vector3d radii{size, size * random.uniform(0.8, 1), size * random.uniform(0.5, 0.8)};
    layout.blob(Material::coral, place, radii, 0.3, 0.14f, 3.2f);
  });
}

// Body, neck, lip and two handles of a transport amphora lying on its side.
void amphora(Layout& layout, Scene& scene, const Vector2d& place, double length) {
  const double girth = 0.26 * length, angle = layout.yaw();
  const Quaterniond lying =
      about_z(angle) *
      Quaterniond(AngleAxisd(layout.random().uniform(-0.12, 0.12), Vector3d::UnitY()));
  const double z = scene.relief.z(place.x(), place.y()) + 0.45 * girth;
  const std::uint32_t seed = layout.seed();
  const auto part = [&](const Vector3d& at, const Vector3d& radii, double turn) {
    const Vector3d centre = Vector3d(place.x(), place.y(), z) + lying * (length * at);
    scene.solids.push_back(make_blob(Material::ceramic, centre, radii * length,
                                     lying * about_z(turn), 0.035f, 2.5f, seed));
  };
  part({0, 0, 0}, {0.36, 0.22, 0.22}, 0);
  part({-0.34, 0, 0}, {0.12, 0.05, 0.05}, 0);
  part({0.40, 0, 0}, {0.17, 0.075, 0.075}, 0);
  part({0.53, 0, 0}, {0.035, 0.10, 0.10}, 0);
  part({0.38, 0.13, 0}, {0.14, 0.028, 0.035}, -0.30);
  part({0.38, -0.13, 0}, {0.14, 0.028, 0.035}, 0.30);
}

void furnish_wreck(Layout& layout, Scene& scene) {
  layout.scatter(0.6, 0.36, 0.50, [&](const Vector2d& place, double size) {
    amphora(layout, scene, place, 1.9 * size);
  });
  layout.scatter(1.0, 0.03, 0.10, [&](const Vector2d& place, double size) {
    layout.blob(Material::ceramic, place, {size, 0.7 * size, 0.25 * size}, 0.2, 0.28f, 1.6f);
  });
  stones(layout, 0.8, 0.03, 0.12);
}

void furnish(Layout& layout, Scene& scene) {
  switch (scene.kind) {
    case SceneKind::pool:
      return stones(layout, 0.25, 0.03, 0.07);
    case SceneKind::transect:
      starfish(layout, 0.5);
      urchins(layout, 0.6);
      return stones(layout, 0.9, 0.03, 0.14);
    case SceneKind::reef:
      corals(layout, 0.40);
      stones(layout, 0.9, 0.06, 0.30);
      urchins(layout, 0.7);
      return starfish(layout, 0.06);
    case SceneKind::wreck:
      return furnish_wreck(layout, scene);
  }
}

// Solids keep light from the ground around their feet.
void darken_feet(Scene& scene) {
  Relief& g = scene.relief;
  for (const Solid& solid : scene.solids) {
    const auto* blob = std::get_if<Blob>(&solid.shape);
    if (!blob) continue;
    const double reach = 1.9 * solid.radius;
    const auto first = [&](double x, double origin) {
      return std::max(0, static_cast<int>((x - reach - origin) / g.cell));
    };
    const auto last = [&](double x, double origin, int size) {
      return std::min(size - 1, static_cast<int>((x + reach - origin) / g.cell));
    };
    const Vector3d& c = blob->centre;
    for (int row = first(c.y(), g.y0); row <= last(c.y(), g.y0, g.light.rows); ++row) {
      for (int col = first(c.x(), g.x0); col <= last(c.x(), g.x0, g.light.cols); ++col) {
        const Vector3d x(g.x0 + col * g.cell, g.y0 + row * g.cell,
                         static_cast<double>(g.height(row, col)));
        const double gap = (blob->unit_from_local * (x - c)).norm() - 1;
        const double hidden = 0.6 * std::exp(-std::max(gap, 0.0) / 0.22);
        g.light(row, col) *= static_cast<float>(1 - hidden);
      }
    }
  }
}

}  // namespace

double hills(const Profile& profile, std::uint64_t seed, double x, double y) {
  return 0.75 * octave(profile.relief.front(), 0, static_cast<std::uint32_t>(mix(seed)), x, y);
}

Scene make_scene(SceneKind kind, std::uint64_t seed, const Path& path, int images) {
  const Profile& p = profile(kind);
  const Box box = seen_from(p, path, images);
  Scene scene;
  scene.kind = kind;
  scene.seed = static_cast<std::uint32_t>(mix(seed));
  scene.relief = raise(p, scene.seed, box);
  Layout layout(scene, box, seed);
  if (kind == SceneKind::pool) furnish_pool(layout, box);
  lay_targets(layout, scene, p, path, images);
  furnish(layout, scene);
  darken_feet(scene);
  return scene;
}

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/simulate/survey.hpp"

#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "nadir/core/check.hpp"
#include "noise.hpp"
#include "random.hpp"
#include "renderer.hpp"
#include "sensors.hpp"

namespace nadir::simulate {
namespace {

using cv::Vec3f;
using Eigen::Vector2d, Eigen::Vector3d;

Options resolved(Options options) {
  options.check();
  if (options.images == 0) options.images = profile(options.scene).images;
  return options;
}

// Slow change from image to image, in [-1, 1].
float drift(std::uint64_t seed, int channel, int image) {
  return noise(image / 6.0, channel, static_cast<std::uint32_t>(mix(seed)));
}

Light light_at(const Profile& profile, const Rigid3& local_from_camera) {
  Light light{{}, profile.water, {}};
  for (const Lamp& lamp : profile.lamps) {
    light.sources.push_back({local_from_camera * lamp.position,
                             local_from_camera.rotation * lamp.direction, lamp.power,
                             lamp.sharpness});
  }
  return light;
}

// The exposure a camera would choose over a flat grey bottom, and most of its white balance.
Vec3f gain_of(const Profile& profile) {
  constexpr float kBottom = 0.30f, kWanted = 0.21f, kBalanced = 0.65f;
  const Rigid3 above{Eigen::Quaterniond(0, 1, 0, 0), {0, 0, profile.altitude}};
  const Skin grey{{kBottom, kBottom, kBottom}, Vector3d::UnitZ()};
  const Vec3f seen =
      radiance(light_at(profile, above), grey, Vector3d::Zero(), above.translation, 1);
  const float mean = (seen[0] + seen[1] + seen[2]) / 3;
  Vec3f gain;
  for (int c = 0; c < 3; ++c) gain[c] = kWanted / mean * std::pow(mean / seen[c], kBalanced);
  return gain;
}

bool inside(const CameraModel& camera, const Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= camera.width - 1 && p.y() <= camera.height - 1;
}

// Whether the camera sees this very place: inside the image and nothing before it.
bool sees(const Scene& scene, const CameraModel& camera, const Rigid3& local_from_camera,
          const Vector3d& x_in_local) {
  constexpr double kSame = 1e-3;  // metres
  const auto pixel = camera.project(local_from_camera.inverse() * x_in_local);
  if (!pixel || !inside(camera, *pixel)) return false;
  const Vector3d eye = local_from_camera.translation;
  const auto meeting = scene.meet({eye, x_in_local - eye});
  return meeting && std::abs(meeting->hit.t - 1) * (x_in_local - eye).norm() < kSame;
}

}  // namespace

struct Survey::World {
  explicit World(const Options& wanted)
      : options(resolved(wanted)),
        figures(profile(options.scene)),
        path(figures, options.seed,
             [this](double x, double y) { return hills(figures, options.seed, x, y); }),
        scene(make_scene(options.scene, options.seed, path, options.images)),
        rig(std::make_shared<const CameraRig>(simulate::rig(options))),
        left(scene, rig->left) {
    if (rig->right) right.emplace(scene, rig->right->camera);
  }

  Rigid3 local_from_camera(int image) const {
    NADIR_CHECK(image >= 0 && image < options.images, image);
    return path.at(path.seconds(image)).local_from_camera(figures);
  }

  Light light(int image) const {
    Light light = light_at(figures, local_from_camera(image));
    light.water.veil *= 1 + 0.15f * drift(options.seed, 'v', image);
    for (const Vector3d& origin : laser_origins()) {
      light.beams.push_back({local_from_camera(image) * origin,
                             local_from_camera(image).rotation * Vector3d::UnitZ()});
    }
    return light;
  }

  Vec3f gain(int image) const {
    Vec3f gain = gain_of(figures) * (1 + 0.13f * drift(options.seed, 'e', image));
    gain[0] *= 1 + 0.04f * drift(options.seed, 'b', image);
    gain[2] *= 1 + 0.04f * drift(options.seed, 'r', image);
    return gain;
  }

  double last_reading() const { return path.seconds(options.images - 1) + 0.2; }

  std::vector<Vector3d> laser_origins() const {
    if (options.scene != SceneKind::transect) return {};
    return {{-0.05, 0.062, 0.09}, {0.05, 0.062, 0.09}};
  }

  cv::Mat picture(int image, const Renderer& renderer, const CameraModel& camera,
                  const Rigid3& camera_from_left, std::uint64_t side) const {
    cv::Mat3f seen =
        renderer.radiance(local_from_camera(image) * camera_from_left.inverse(), light(image));
    const Vec3f gain = this->gain(image);
    if (!options.clear) {
      const Snow snow =
          make_snow(rig->left, figures.altitude, figures.snow, hash(options.seed, 's', image));
      const Vec3f white(0.55f / gain[0], 0.6f / gain[1], 0.6f / gain[2]);
      add_snow(seen, snow, camera, camera_from_left, white);
    }
    return expose(seen, gain, options.clear ? 0 : 1, hash(options.seed, 'n', image, side));
  }

  Options options;
  const Profile& figures;
  Path path;
  Scene scene;
  std::shared_ptr<const CameraRig> rig;
  Renderer left;
  std::optional<Renderer> right;
};

Survey::Survey(const Options& options) : world_(std::make_unique<const World>(options)) {}
Survey::~Survey() = default;

int Survey::images() const { return world_->options.images; }

const std::shared_ptr<const CameraRig>& Survey::rig() const { return world_->rig; }

Time Survey::time(int image) const { return from_seconds(world_->path.seconds(image)); }

std::string Survey::name(int image) const {
  char name[16];
  std::snprintf(name, sizeof name, "%06d", image);
  return name;
}

Rigid3 Survey::survey_from_camera(int image) const {
  return survey_from_local(world_->figures) * world_->local_from_camera(image);
}

Picture Survey::picture(int image) const {
  const World& w = *world_;
  Picture picture;
  picture.left = w.picture(image, w.left, w.rig->left, {}, 0);
  if (w.right) {
    picture.right =
        w.picture(image, *w.right, w.rig->right->camera, w.rig->right->right_from_left, 1);
  }
  return picture;
}

Frame Survey::frame(int image) const {
  const Picture picture = this->picture(image);
  Frame frame;
  frame.image = static_cast<std::uint64_t>(image);
  frame.time = time(image);
  frame.name = name(image);
  frame.rig = world_->rig;
  frame.colour = picture.left;
  cv::cvtColor(picture.left, frame.grey, cv::COLOR_BGR2GRAY);
  if (!picture.right.empty()) cv::cvtColor(picture.right, frame.right, cv::COLOR_BGR2GRAY);
  frame.attitude = world_->path.at(world_->path.seconds(image)).attitude;
  frame.depth = -survey_from_camera(image).translation.z();
  return frame;
}

cv::Mat1f Survey::depth(int image) const {
  return world_->left.depth(world_->local_from_camera(image));
}

std::vector<Target> Survey::targets() const {
  const Rigid3 out = survey_from_local(world_->figures);
  std::vector<Target> targets;
  for (const Plate& plate : world_->scene.plates) {
    targets.push_back({plate.id, out * plate.pose.translation,
                       out.rotation * (plate.pose.rotation * Vector3d::UnitZ()), plate.disc,
                       plate.side});
  }
  return targets;
}

std::vector<Sighting> Survey::sightings(int image) const {
  const World& w = *world_;
  std::vector<Sighting> sightings;
  const auto look = [&](const CameraModel& camera, const Rigid3& local_from_camera, bool right) {
    for (const Plate& plate : w.scene.plates) {
      bool whole = true;
      for (const double x : {-0.49, 0.0, 0.49}) {
        for (const double y : {-0.49, 0.0, 0.49}) {
          const Vector3d place = plate.pose * (plate.side * Vector3d(x, y, 0));
          whole = whole && sees(w.scene, camera, local_from_camera, place);
        }
      }
      if (!whole) continue;
      const Vector3d x = local_from_camera.inverse() * plate.pose.translation;
      sightings.push_back({plate.id, right, *camera.project(x), camera.fx * plate.disc / x.z()});
    }
  };
  const Rigid3 pose = w.local_from_camera(image);
  look(w.rig->left, pose, false);
  if (w.rig->right) {
    look(w.rig->right->camera, pose * w.rig->right->right_from_left.inverse(), true);
  }
  return sightings;
}

std::optional<Lasers> Survey::lasers() const {
  const auto origins = world_->laser_origins();
  if (origins.empty()) return std::nullopt;
  return Lasers{(origins[1] - origins[0]).norm(), origins};
}

std::vector<LaserDot> Survey::laser_dots(int image) const {
  const World& w = *world_;
  const Rigid3 pose = w.local_from_camera(image);
  std::vector<LaserDot> dots;
  const auto origins = w.laser_origins();
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const Ray beam{pose * origins[i], pose.rotation * Vector3d::UnitZ()};
    const auto meeting = w.scene.meet(beam);
    if (!meeting) continue;
    const Vector3d place = beam.at(meeting->hit.t);
    if (!sees(w.scene, w.rig->left, pose, place)) continue;
    const Vector3d x = pose.inverse() * place;
    dots.push_back({static_cast<int>(i), *w.rig->left.project(x), x.z()});
  }
  return dots;
}

HeightMap Survey::height_map() const {
  const Relief& relief = world_->scene.relief;
  return {world_->scene.top(), relief.x0, relief.y0, relief.cell,
          survey_from_local(world_->figures)};
}

std::vector<AttitudeReading> Survey::attitude_readings() const {
  return simulate::attitude_readings(world_->path, world_->last_reading(), world_->options.seed);
}

std::vector<DepthReading> Survey::depth_readings() const {
  return simulate::depth_readings(world_->path, -world_->figures.origin.z(), world_->last_reading(),
                                  world_->options.seed);
}

}  // namespace nadir::simulate

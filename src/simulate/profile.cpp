// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "profile.hpp"

#include <cmath>
#include <numbers>

namespace nadir::simulate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

CameraModel brown(int width, int height, std::array<double, 4> matrix, std::array<double, 5> k) {
  const auto [fx, fy, cx, cy] = matrix;
  return {width,
          height,
          fx,
          fy,
          cx,
          cy,
          LensModel::brown_conrady,
          {k[0], k[1], k[2], k[3], k[4], 0, 0, 0}};
}

std::vector<Lamp> pair_of_lamps(double apart, float power, float sharpness) {
  const Eigen::Vector3d inwards = Eigen::Vector3d(0.15, 0.05, 1).normalized();
  const Eigen::Vector3d mirrored(-inwards.x(), inwards.y(), inwards.z());
  return {{{-apart / 2, -0.15, -0.05}, inwards, power, sharpness},
          {{apart / 2, -0.10, -0.05}, mirrored, power * 0.9f, sharpness}};
}

Profile pool() {
  Profile p{};
  p.images = 40, p.interval = 2, p.spacing = 0.25, p.altitude = 1.7, p.azimuth = -28 * kDegree;
  p.wobble = 4 * kDegree, p.heave = 0.08;
  p.origin = {12, -7, -3.4};
  p.cell = 0.02, p.relief = {{1.5, 0.006}, {0.4, 0.002}};
  p.camera = brown(968, 728, {915.6, 914.9, 487.3, 360.4}, {-0.112, 0.095, 6e-4, -4e-4, -0.018});
  p.right_camera =
      brown(968, 728, {917.1, 916.2, 478.8, 366.1}, {-0.109, 0.091, -4e-4, 5e-4, -0.016});
  p.baseline = 0.12;
  p.lamps = pair_of_lamps(0.9, 2.2f, 3);
  p.water = {{0.11f, 0.09f, 0.32f}, {0.060f, 0.052f, 0.022f}, {0.16f, 0.15f, 0.10f}};
  p.snow = 12, p.jpeg = 90, p.target = 0.16, p.targets = 1.6;
  return p;
}

Profile transect() {
  Profile p{};
  p.images = 80, p.interval = 0.5, p.spacing = 0.075, p.altitude = 2.1, p.azimuth = 74 * kDegree;
  p.wobble = 4.5 * kDegree, p.heave = 0.12;
  p.origin = {-20, 35, -24};
  p.cell = 0.02, p.relief = {{3, 0.14}, {0.9, 0.04}, {0.3, 0.012}};
  p.camera = brown(960, 540, {578.2, 577.5, 483.4, 266.9}, {0.111, 0.031, -6e-4, 5e-4, 0.004});
  p.right_camera =
      brown(960, 540, {576.9, 576.3, 475.2, 271.7}, {0.114, 0.034, 5e-4, -6e-4, 0.003});
  p.baseline = 0.12;
  p.lamps = pair_of_lamps(1.1, 4.6f, 7);
  p.water = {{0.26f, 0.15f, 0.42f}, {0.042f, 0.062f, 0.020f}, {0.03f, 0.05f, 0.01f}};
  p.snow = 20, p.jpeg = 88, p.target = 0.2, p.targets = 1.7;
  return p;
}

Profile reef() {
  Profile p{};
  p.images = 60, p.interval = 2, p.spacing = 0.55, p.altitude = 2.9, p.azimuth = -65 * kDegree;
  p.pass_length = 14, p.pass_gap = 1.9;
  p.wobble = 4 * kDegree, p.heave = 0.25;
  p.origin = {40, 18, -11};
  p.cell = 0.03, p.relief = {{9, 0.8}, {2.5, 0.22}, {0.8, 0.05}, {0.25, 0.012}};
  p.camera = brown(920, 690, {654.7, 654.1, 455.9, 347.8}, {-0.091, 0.034, 5e-4, -6e-4, -0.006});
  p.right_camera =
      brown(920, 690, {652.8, 652.0, 463.1, 342.5}, {-0.088, 0.032, -5e-4, 4e-4, -0.005});
  p.baseline = 0.2;
  p.lamps = pair_of_lamps(1.0, 3.0f, 4);
  p.water = {{0.10f, 0.08f, 0.26f}, {0.095f, 0.078f, 0.026f}, {0.50f, 0.46f, 0.22f}};
  p.snow = 15, p.jpeg = 88, p.target = 0.26, p.targets = 5;
  return p;
}

Profile wreck() {
  Profile p{};
  p.images = 40, p.interval = 0.5, p.spacing = 0.16, p.altitude = 1.75, p.azimuth = 112 * kDegree;
  p.wobble = 4 * kDegree, p.heave = 0.08;
  p.origin = {-31, -14, -62};
  p.cell = 0.015, p.relief = {{2.5, 0.05}, {0.7, 0.02}, {0.2, 0.006}};
  p.camera = brown(960, 640, {991.4, 990.8, 473.6, 324.2}, {-0.049, 0.076, -5e-4, 6e-4, -0.027});
  p.right_camera =
      brown(960, 640, {989.3, 988.5, 481.9, 318.7}, {-0.052, 0.081, 4e-4, -5e-4, -0.030});
  p.baseline = 0.2;
  p.lamps = pair_of_lamps(1.0, 2.8f, 5);
  p.water = {{0.13f, 0.12f, 0.36f}, {0.034f, 0.028f, 0.012f}, {0, 0, 0}};
  p.snow = 16, p.jpeg = 90, p.target = 0.12, p.targets = 1.2;
  return p;
}

CameraModel scaled(CameraModel camera, double scale) {
  camera.width = static_cast<int>(std::lround(camera.width * scale));
  camera.height = static_cast<int>(std::lround(camera.height * scale));
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx = (camera.cx + 0.5) * scale - 0.5;
  camera.cy = (camera.cy + 0.5) * scale - 0.5;
  return camera;
}

}  // namespace

const Profile& profile(SceneKind scene) {
  static const Profile profiles[] = {pool(), transect(), reef(), wreck()};
  return profiles[static_cast<int>(scene)];
}

CameraRig rig(const Options& options) {
  const Profile& p = profile(options.scene);
  CameraRig rig;
  rig.left = scaled(p.camera, options.image_scale);
  if (options.stereo) {
    // Real pairs toe in a little and sit a little askew.
    const Eigen::Quaterniond askew(Eigen::AngleAxisd(-0.011, Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitX()) *
                                   Eigen::AngleAxisd(0.003, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector3d baseline(-p.baseline, 0.01 * p.baseline, -0.015 * p.baseline);
    rig.right = {scaled(p.right_camera, options.image_scale), {askew, baseline}};
  }
  return rig;
}

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "path.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "random.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d, std::numbers::pi;

enum Channel { kRoll, kPitch, kHeading, kHeave, kSway, kSurge, kTrigger };

const Matrix3d kSurveyFromNed{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}};

}  // namespace

Rigid3 survey_from_local(const Profile& profile) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(-profile.azimuth, Vector3d::UnitZ())),
          profile.origin};
}

Rigid3 Motion::local_from_camera(const Profile& profile) const {
  const Eigen::Quaterniond survey_from_camera =
      Eigen::Quaterniond(kSurveyFromNed) * attitude.ned_from_body() * CameraRig{}.body_from_camera;
  return {(survey_from_local(profile).rotation.conjugate() * survey_from_camera).normalized(),
          x_in_local};
}

Path::Path(const Profile& profile, std::uint64_t seed, std::function<double(double, double)> ground)
    : profile_(profile), seed_(hash(seed, 'p')), ground_(std::move(ground)) {}

// Three incommensurate sines of random phase, in [-1, 1]; fastest: shortest period, s.
double Path::swing(double seconds, int channel, double fastest) const {
  constexpr double kPeriods[] = {1, 1.83, 3.71}, kWeights[] = {0.3, 0.35, 0.35};
  Random random(hash(seed_, channel));
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double phase = random.uniform(0, 2 * pi);
    sum += kWeights[i] * std::sin(2 * pi * seconds / (fastest * kPeriods[i]) + phase);
  }
  return sum;
}

Path::Course Path::course(double arc) const {
  if (profile_.pass_length <= 0) return {{0, arc}, 0};
  const double length = profile_.pass_length, radius = profile_.pass_gap / 2;
  const double lap = length + pi * radius;
  const double number = std::floor(arc / lap), along = arc - number * lap;
  const bool back = std::fmod(number, 2) != 0;
  const double direction = back ? -1 : 1, x = number * profile_.pass_gap;
  if (along < length) return {{x, back ? length - along : along}, back ? pi : 0};
  const double turned = (along - length) / radius;
  const double end = back ? 0 : length;
  return {{x + radius * (1 - std::cos(turned)), end + direction * radius * std::sin(turned)},
          (back ? pi : 0) + direction * turned};
}

Motion Path::at(double seconds) const {
  const Profile& p = profile_;
  const double pace = p.spacing / p.interval;
  const double surge = 0.15 * p.spacing * swing(seconds, kSurge, 5 * p.interval);
  const Course course = this->course(pace * seconds + surge);
  const Vector2d right(std::cos(course.heading), -std::sin(course.heading));
  const Vector2d xy = course.position + 0.1 * p.altitude * swing(seconds, kSway, 17) * right;
  const double z = ground_(xy.x(), xy.y()) + p.altitude + p.heave * swing(seconds, kHeave, 9);
  Motion motion;
  motion.x_in_local = {xy.x(), xy.y(), z};
  motion.attitude = {
      p.wobble * swing(seconds, kRoll, 4.1), p.wobble * swing(seconds, kPitch, 5.3),
      std::remainder(p.azimuth + course.heading + 1.5 * p.wobble * swing(seconds, kHeading, 7.9),
                     2 * pi)};
  return motion;
}

double Path::seconds(int image) const {
  if (image == 0) return 0;
  const double jitter = Random(hash(seed_, kTrigger, image)).uniform(-0.01, 0.01);
  return std::round((image * profile_.interval + jitter) * 1e4) * 1e-4;  // as the files state it
}

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/attitude_check.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "nadir/core/rounded.hpp"

namespace nadir::reference {
namespace {

using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::size_t kLag = 5;          // images; over fewer they hardly turn
constexpr Time kInterval = 300'000'000;  // of a film not every image

Vector3d rotation_vector(const Quaterniond& rotation) {
  const AngleAxisd turn(rotation);  // 0 to pi
  return turn.angle() * turn.axis();
}

Vector3d turned(const Quaterniond& from, const Quaterniond& to) {
  return rotation_vector(from.conjugate() * to);
}

// Without the heading: z down, x ahead. About its axes an error of the heading is none of the tilt.
Quaterniond level_from_body(const Quaterniond& ned_from_body) {
  const Eigen::Matrix3d r = ned_from_body.toRotationMatrix();
  return AngleAxisd(-std::atan2(r(1, 0), r(0, 0)), Vector3d::UnitZ()) * ned_from_body;
}

}  // namespace

// Between two images, each with its own error.
bool AttitudeCheck::is_far_off(const Vector3d& difference, bool tilt) const {
  constexpr double kSigmas = 4;
  constexpr double kImages_deg = 1;  // of a map that bends, over some images
  const double of_ahrs = tilt ? sigma_.tilt_deg : sigma_.heading_deg;
  const double sigma = std::hypot(of_ahrs, kImages_deg) * kDegree;
  const double off = tilt ? difference.head<2>().norm() : std::abs(difference.z());
  return off > kSigmas * std::numbers::sqrt2 * sigma;
}

std::optional<AttitudeContradiction> AttitudeCheck::tell(bool of_tilt, std::string message) {
  if (std::exchange(of_tilt ? tilt_told_ : heading_told_, true)) return std::nullopt;
  return AttitudeContradiction{"the AHRS contradicts the images: " + std::move(message), of_tilt};
}

std::optional<AttitudeContradiction> AttitudeCheck::observe(const AttitudeSample& sample) {
  if (!recent_.empty() && recent_.back().submap != sample.submap) {
    recent_.clear();
    far_off_tilt_ = far_off_heading_ = 0;
  }
  if (!recent_.empty() && sample.time - recent_.back().time < kInterval) return std::nullopt;
  recent_.push_back(sample);
  if (recent_.size() <= kLag) return std::nullopt;
  const AttitudeSample before = recent_.front();
  const Quaterniond level = level_from_body(before.ned_from_body);
  const Vector3d by_images = level * turned(before.survey_from_body, sample.survey_from_body);
  const Vector3d by_ahrs = level * turned(before.ned_from_body, sample.ned_from_body);
  // The difference as a rotation: rotation vectors near half a turn are not to be subtracted.
  const Quaterniond images = before.survey_from_body.conjugate() * sample.survey_from_body;
  const Quaterniond ahrs = before.ned_from_body.conjugate() * sample.ned_from_body;
  const Vector3d difference = level_from_body(sample.ned_from_body) * turned(images, ahrs);
  recent_.pop_front();

  // A spike of the AHRS is in two pairs that do not follow each other; a jump is in kLag that do.
  constexpr int kPersistent = kLag - 1;
  const bool tilt_off = is_far_off(difference, true), heading_off = is_far_off(difference, false);
  far_off_tilt_ = tilt_off ? far_off_tilt_ + 1 : 0;
  far_off_heading_ = heading_off ? far_off_heading_ + 1 : 0;
  if (far_off_tilt_ >= kPersistent || far_off_heading_ >= kPersistent) {
    const bool of_tilt = far_off_tilt_ >= kPersistent;
    return tell(of_tilt, "over the last " + rounded(seconds(sample.time - before.time), 1) +
                             " s it turned by " + rounded(by_ahrs.norm() / kDegree, 0) +
                             " degrees, they by " + rounded(by_images.norm() / kDegree, 0) +
                             ", and they differ by " + rounded(difference.norm() / kDegree, 0) +
                             (of_tilt ? " with roll or pitch" : " in heading"));
  }
  if (tilt_off || heading_off) return std::nullopt;
  constexpr double kNearHalfATurn = 2.5;  // radians; there rotation vectors change their sign
  if (std::max(by_images.norm(), by_ahrs.norm()) > kNearHalfATurn) return std::nullopt;

  constexpr double kFading = 0.97;  // some thirty images say it
  by_images_ = kFading * by_images_ + by_images * by_images.transpose();
  by_ahrs_ = kFading * by_ahrs_ + by_ahrs * by_ahrs.transpose();
  by_both_ = kFading * by_both_ + by_ahrs * by_images.transpose();
  sum_images_ = kFading * sum_images_ + by_images;
  sum_ahrs_ = kFading * sum_ahrs_ + by_ahrs;
  pairs_ = kFading * pairs_ + 1;
  return regress();
}

std::optional<AttitudeContradiction> AttitudeCheck::regress() {
  constexpr double kFewest = 8, kUnknowns = 4;  // pairs
  constexpr double kAlike = kLag;               // pairs share images: so many count as one
  constexpr double kSigmas = 4;
  constexpr double kLeast = 0.5, kMost = 2;  // true when they agree: 1
  // Less motion may be the images' own error, which tells tilt from sideways motion less well than
  // it tells the heading.
  constexpr std::array<double, 3> kMotion{1.5 * kDegree, 1.5 * kDegree, 0.75 * kDegree};
  constexpr std::array kNames{"roll", "pitch", "heading"};
  if (pairs_ < kFewest) return std::nullopt;
  // About their means: a map that bends turns by as much in each pair.
  const Eigen::Matrix3d images = by_images_ - sum_images_ * sum_images_.transpose() / pairs_;
  const Eigen::Matrix3d ahrs = by_ahrs_ - sum_ahrs_ * sum_ahrs_.transpose() / pairs_;
  const Eigen::Matrix3d both = by_both_ - sum_ahrs_ * sum_images_.transpose() / pairs_;
  // An axis about which nothing turned is the images' noise.
  constexpr double kNoise = 0.05 * kDegree;
  const Eigen::Matrix3d covariance =
      (images + pairs_ * kNoise * kNoise * Eigen::Matrix3d::Identity()).inverse();
  const Eigen::Matrix3d ahrs_from_images = both * covariance;
  for (int axis = 0; axis < 3; ++axis) {
    const double motion = kMotion[static_cast<std::size_t>(axis)];
    if (images(axis, axis) < pairs_ * motion * motion) continue;
    const double share = ahrs_from_images(axis, axis);
    const double squares = ahrs(axis, axis) - ahrs_from_images.row(axis).dot(both.row(axis));
    const double sigma =
        std::sqrt(kAlike * std::max(0.0, squares) / (pairs_ - kUnknowns) * covariance(axis, axis));
    if (share + kSigmas * sigma > kLeast && share - kSigmas * sigma < kMost) continue;
    if (auto told = tell(axis < 2, std::string("where they turn by 1 degree in ") +
                                       kNames[static_cast<std::size_t>(axis)] + " it turns by " +
                                       rounded(share, 2) + ", sigma " + rounded(sigma, 2))) {
      return told;
    }
  }
  return std::nullopt;
}

}  // namespace nadir::reference

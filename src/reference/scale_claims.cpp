// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/scale_claims.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

namespace nadir::reference {
namespace {

// By a pair of cameras or by another program's poses: nothing measured afterwards changes it.
bool is_given(ScaleSource source) {
  return source == ScaleSource::stereo || source == ScaleSource::poses;
}

// Two dots may be mistaken in a few images.
bool is_settled(ScaleSource source, const ScaleMeasure& measure) {
  constexpr std::uint32_t kEnough = 5;
  return source != ScaleSource::laser || measure.images >= kEnough;
}

std::string witness(ScaleSource source) { return std::string(in_words(source)); }

std::string to_check(ScaleSource source) {
  switch (source) {
    case ScaleSource::stereo:
      return "the baseline in the calibration";
    case ScaleSource::poses:
      return "the given poses";
    case ScaleSource::laser:
      return "separation_m in lasers.yml";
    case ScaleSource::typed:
      return "reference.known_length";
    case ScaleSource::altitude:
      return "altitude.csv and reference.altimeter_below_camera_m";
    default:
      return "depth.csv";
  }
}

}  // namespace

ScaleClaims::ScaleClaims(double altimeter_below_camera, const std::optional<KnownLength>& length,
                         const std::optional<calibration::Lasers>& lasers)
    : sensors_(altimeter_below_camera) {
  if (length) typed_.emplace(*length);
  if (lasers) lasers_.emplace(*lasers);
}

void ScaleClaims::observe(const LaserDots& dots) {
  if (!lasers_) return;
  lasers_->observe(dots);
  ++with_dots_;
}

std::optional<ScaleMeasure> ScaleClaims::by_lasers(const Window& initial) {
  if (!lasers_) return std::nullopt;
  lasers_->observe(initial);
  return lasers_->estimate(initial.submap);
}

void ScaleClaims::placed(std::uint32_t submap, double factor, const Scale& told) {
  if (lasers_) lasers_->resized(submap, factor);
  told_[submap] = told;
}

std::vector<Alert> ScaleClaims::observe(const Orientation& orientation) {
  if (orientation.window) {
    const Scale& scale = orientation.window->scale;
    if (is_given(scale.source)) told_[orientation.window->submap] = scale;
  }
  for (const ImagePose& pose : orientation.poses) {
    if (!first_pose_) first_pose_ = newest_pose_ = pose.time;
    newest_pose_ = std::max(newest_pose_, pose.time);
  }
  sensors_.observe(orientation);
  if (typed_) typed_->observe(orientation);
  if (lasers_) lasers_->observe(orientation);
  std::vector<Alert> alerts = failing_sensors(orientation);
  if (orientation.window) newest_ = claims_of(orientation.submap);
  std::ranges::move(conflicts(orientation), std::back_inserter(alerts));
  std::ranges::move(unseen_lasers(orientation), std::back_inserter(alerts));
  return alerts;
}

void ScaleClaims::forget_vertical() {
  sensors_.forget_vertical();
  withdraw(ScaleSource::depth);
}

// Maps that it scaled stay as large until another source claims more.
void ScaleClaims::withdraw(ScaleSource source) {
  for (auto& [submap, told] : told_) {
    if (told.source == source) told.sigma = std::numeric_limits<double>::infinity();
  }
  std::erase_if(newest_, [&](const Claim& claim) { return claim.source == source; });
}

Alert ScaleClaims::alert(const Shot* shot, AlertKind kind, std::string message,
                         std::string remedy) const {
  return {shot ? shot->time : newest_pose_, shot ? std::optional(shot->image) : std::nullopt, kind,
          std::move(message), std::move(remedy)};
}

std::vector<Alert> ScaleClaims::failing_sensors(const Orientation& orientation) {
  std::vector<Alert> alerts;
  const Shot* shot = orientation.shot.get();
  if (!shot) return alerts;
  for (SensorFault& fault : sensors_.new_faults(orientation.submap)) {
    if (fault.source != ScaleSource::none) withdraw(fault.source);
    alerts.push_back(
        alert(shot, AlertKind::sensor_stale, std::move(fault.message), std::move(fault.remedy)));
  }
  return alerts;
}

std::vector<Alert> ScaleClaims::unseen_lasers(const Orientation& orientation) {
  constexpr std::size_t kImages = 20, kFewest = 10;  // of a short dive
  constexpr Time kTime = 5'000'000'000;              // images of a film are soon so many
  constexpr std::size_t kDots = 3;                   // as many images as give a scale
  if (!lasers_ || lasers_told_ || with_dots_ >= kDots) return {};
  for (const ImagePose& pose : orientation.poses) oriented_.insert(pose.image);
  const Shot* shot = orientation.shot.get();
  const bool enough = shot ? oriented_.size() >= kImages && newest_pose_ - *first_pose_ >= kTime
                           : oriented_.size() >= kFewest;
  if (!enough) return {};
  lasers_told_ = true;
  return {alert(shot, AlertKind::sensor_stale,
                "lasers.yml: both dots were found in " + std::to_string(with_dots_) + " of " +
                    std::to_string(oriented_.size()) + " images",
                "see whether the lasers are on and in the picture, and whether colour, "
                "separation_m and origins_camera_m in lasers.yml are theirs; the lasers give the "
                "map no scale")};
}

std::vector<ScaleClaims::Claim> ScaleClaims::claims_of(std::uint32_t submap) const {
  std::vector<Claim> all;
  const auto add = [&](ScaleSource source, const std::optional<ScaleMeasure>& measure) {
    if (measure) all.push_back({source, *measure});
  };
  const auto told = told_.find(submap);
  if (told != told_.end() && is_given(told->second.source)) {
    add(told->second.source, ScaleMeasure{1, told->second.sigma, 1});
  }
  if (typed_) add(ScaleSource::typed, typed_->estimate(submap));
  if (lasers_) add(ScaleSource::laser, lasers_->estimate(submap));
  add(ScaleSource::altitude, sensors_.by_altitude(submap));
  add(ScaleSource::depth, sensors_.by_depth(submap));
  return all;
}

// Of those that measure the map as it is; a given scale is part of it.
std::optional<ScaleClaims::Claim> ScaleClaims::best_of(const std::vector<Claim>& claims) {
  std::optional<Claim> best;
  for (const Claim& claim : claims) {
    if (is_given(claim.source)) continue;
    if (!best || claim.measure.sigma < best->measure.sigma) best = claim;
  }
  return best;
}

// Once for each two sources and sub-map.
std::vector<Alert> ScaleClaims::conflicts(const Orientation& orientation) {
  const Shot* shot = orientation.shot.get();
  std::vector<Alert> alerts;
  const auto add = [&](std::string message, std::string remedy) {
    alerts.push_back(alert(shot, AlertKind::scale_conflict, std::move(message), std::move(remedy)));
  };
  if (!shot && typed_ && !typed_->fault().empty()) {
    add("the known length gives no scale: " + typed_->fault(),
        "correct reference.known_length: the image's number counts from 0");
  }
  if (!orientation.window || !told_.contains(orientation.submap)) return alerts;
  const std::vector<Claim>& all = newest_;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      if (agree(all[i], all[k])) continue;
      const Claim &one = all[i], &other = all[k];
      if (!in_conflict_.insert({orientation.submap, one.source, other.source}).second) continue;
      const double excess = other.measure.ratio / one.measure.ratio - 1;
      const Scale& scale = told_.at(orientation.submap);
      const ScaleSource told = std::isfinite(scale.sigma) ? scale.source : ScaleSource::none;
      const ScaleSource better =
          one.measure.sigma < other.measure.sigma ? one.source : other.source;
      add("by " + witness(other.source) + " the map is " +
              std::to_string(std::lround(100 * std::abs(excess))) + " % " +
              (excess > 0 ? "larger" : "smaller") + " than by " + witness(one.source),
          "check " + to_check(one.source) + " and " + to_check(other.source) +
              "; the map keeps to " + witness(told == ScaleSource::none ? better : told));
    }
  }
  return alerts;
}

// Those that are not settled contradict nothing.
bool ScaleClaims::agree(const Claim& one, const Claim& other) {
  constexpr double kTolerated = 0.02;  // separations and baselines are measured to a hundredth
  constexpr double kSigmas = 3;
  if (!is_settled(one.source, one.measure) || !is_settled(other.source, other.measure)) return true;
  const double sigma = std::hypot(one.measure.sigma, other.measure.sigma);
  return std::abs(std::log(other.measure.ratio / one.measure.ratio)) <
         std::max(kTolerated, kSigmas * sigma);
}

std::vector<ScaleEstimate> ScaleClaims::improved(const Orientation& orientation) {
  constexpr double kClearly = 0.6;  // of the sigma told before
  std::vector<ScaleEstimate> improved;
  const bool last = !orientation.shot;
  if (!last && !orientation.window) return improved;
  for (auto& [submap, told] : told_) {
    if (is_given(told.source)) continue;
    if (!last && submap != orientation.submap) continue;
    const auto claim = best_of(last ? claims_of(submap) : newest_);
    if (!claim) continue;
    const auto& [ratio, sigma, images] = claim->measure;
    const bool better = told.source == ScaleSource::none || sigma < kClearly * told.sigma;
    if (!better && !last) continue;
    told = {claim->source, sigma};
    improved.push_back({submap, ratio, told});
  }
  return improved;
}

}  // namespace nadir::reference

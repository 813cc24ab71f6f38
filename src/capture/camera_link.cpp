// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "camera_link.hpp"

#include <algorithm>
#include <utility>

namespace nadir::capture {
namespace {

constexpr Time kMillisecond = 1'000'000;
constexpr Time kSecond = 1000 * kMillisecond;
constexpr Time kFirstRetry = 250 * kMillisecond, kLastRetry = kSecond;
// USB cameras take their time for the first picture.
constexpr Time kStarting = 3 * kSecond;
constexpr Time kShortestPatience = 600 * kMillisecond;
constexpr Time kUsualPeriod = 100 * kMillisecond;
constexpr Time kMostAhead = kSecond;  // now is asked for once for many pictures

}  // namespace

CameraLink::CameraLink(std::string role, Open open)
    : role_(std::move(role)), open_(std::move(open)), retry_(kFirstRetry), period_(kUsualPeriod) {}

Time CameraLink::patience() const {
  return has_given_ ? std::max(3 * period_, kShortestPatience) : kStarting;
}

void CameraLink::tell_lost(Time now, const std::string& reason, std::vector<Alert>& alerts) {
  if (std::exchange(told_, reason) == reason) return;
  alerts.push_back({now, std::nullopt, AlertKind::camera_lost, role_ + ": " + reason,
                    "check the camera, its cable and capture.camera; it is looked for all the time "
                    "and mapping goes on by itself"});
}

void CameraLink::lose(Time now, const std::string& reason, std::vector<Alert>& alerts) {
  camera_.reset();
  tell_lost(now, reason, alerts);
  due_ = now + retry_;
  retry_ = std::min(2 * retry_, kLastRetry);
}

void CameraLink::keep_open(Time now, std::vector<Alert>& alerts) {
  if (now < due_) return;
  if (camera_) {
    lose(now, "gives no images any more", alerts);
    return;
  }
  OpenedCamera opened = open_();
  if (!opened.camera) {
    lose(now, opened.fault, alerts);
    return;
  }
  camera_ = std::move(opened.camera);
  // What it gives is taken from now on, whatever the last stamp before said.
  if (newest_) newest_ = std::min(*newest_, now);
  ++opened_;
  remarks_ = std::move(opened.remarks);
  if (camera_->rate_hz() > 0) period_ = from_seconds(1 / camera_->rate_hz());
  has_given_ = false;
  due_ = now + patience();
}

std::optional<Picture> CameraLink::take(Time now, std::vector<Alert>& alerts) {
  // A driver in trouble may hand out old pictures as fast as it is given them back.
  constexpr int kMostOld = 16;
  for (int old = 0; camera_ && old < kMostOld; ++old) {
    Camera::Taken taken = camera_->take();
    if (!taken.gone.empty()) lose(now, taken.gone, alerts);
    if (!taken.picture) return std::nullopt;
    if (taken.picture->time > now + kMostAhead) {
      if (std::exchange(ahead_, taken.picture->time) == taken.picture->time) continue;
      // Nothing is measured by it, nor losses by the time that seems to have passed.
      taken.picture->lost_before = 0;
      taken.picture->fault = "the camera's driver says it was taken later than now";
      return std::move(taken.picture);
    }
    if (newest_ && taken.picture->time <= *newest_) continue;
    // A slower camera than it said is believed at once, a faster one by and by.
    const Time gap = taken.picture->time - newest_.value_or(taken.picture->time);
    if (has_given_ && gap > 0) {
      const Time period = gap / (Time{1} + taken.picture->lost_before);
      period_ = std::max(period, period_ + (period - period_) / 8);
    }
    newest_ = taken.picture->time;
    if (!taken.picture->fault.empty()) return std::move(taken.picture);  // no sign of health
    has_given_ = true;
    due_ = now + patience();
    retry_ = kFirstRetry;
    if (!std::exchange(told_, {}).empty()) {
      alerts.push_back({now, std::nullopt, AlertKind::camera_back, role_ + ": gives images again",
                        "none needed"});
    }
    for (const std::string& remark : std::exchange(remarks_, {})) {
      alerts.push_back({now, std::nullopt, AlertKind::camera_back,
                        role_ + ": gives images, but " + remark,
                        "the camera is used as it is; correct the setting"});
    }
    return std::move(taken.picture);
  }
  return std::nullopt;
}

}  // namespace nadir::capture

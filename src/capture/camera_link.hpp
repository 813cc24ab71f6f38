// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Keeps one camera open: opens it again when it fails, is unplugged or says nothing any more.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera.hpp"
#include "nadir/core/alert.hpp"

namespace nadir::capture {

class CameraLink {
 public:
  using Open = std::function<OpenedCamera()>;

  /// role: "camera", or "left camera" and "right camera" of a pair, for alerts.
  CameraLink(std::string role, Open open);

  /// Opens the camera when it is time to. Tells camera_lost of a camera that cannot be opened or
  /// has given no whole picture for three periods, once for each reason, and camera_back with the
  /// first one after it.
  void keep_open(Time now, std::vector<Alert>& alerts);
  /// The next picture waiting. Pictures that are not later than the one before are passed over,
  /// those stamped more than a second later than now are damaged.
  std::optional<Picture> take(Time now, std::vector<Alert>& alerts);

  /// See Camera; none while it is lost.
  std::optional<Camera::Exposing> exposing() const {
    return camera_ ? camera_->exposing() : std::nullopt;
  }
  void expose(const Exposure& exposure) {
    if (camera_) camera_->expose(exposure);
  }
  int opened() const { return opened_; }  ///< how often

  bool is_open() const { return camera_ != nullptr; }
  int descriptor() const { return camera_ ? camera_->descriptor() : -1; }
  /// When keep_open() has something to do.
  Time due() const { return due_; }
  /// Between pictures, as measured; as the camera said before there are two.
  Time period() const { return period_; }

 private:
  void lose(Time now, const std::string& reason, std::vector<Alert>& alerts);
  void tell_lost(Time now, const std::string& reason, std::vector<Alert>& alerts);
  Time patience() const;

  const std::string role_;
  const Open open_;
  std::unique_ptr<Camera> camera_;
  Time due_ = 0, retry_ = 0;
  Time period_ = 0;
  std::optional<Time> newest_;  ///< picture
  std::optional<Time> ahead_;   ///< the last stamp that was later than now
  int opened_ = 0;
  bool has_given_ = false;  ///< a picture since it was opened
  std::string told_;        ///< why it is lost; empty while it is not
  std::vector<std::string> remarks_;
};

}  // namespace nadir::capture

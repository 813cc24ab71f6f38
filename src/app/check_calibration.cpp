// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <map>
#include <opencv2/core/utility.hpp>
#include <set>

#include "configured.hpp"
#include "nadir/capture/source.hpp"
#include "nadir/odometry/self_calibration.hpp"
#include "nadir/odometry/visual_odometry.hpp"
#include "verbs.hpp"

namespace nadir::app {
namespace {

using KeyFrames = std::vector<std::shared_ptr<const SettledKeyFrame>>;

constexpr int kDoubtful = 1;

struct Oriented {
  std::size_t images = 0;
  KeyFrames key_frames;
  std::map<std::string, Alert> suspicions;  ///< of odometry itself, by message
};

// The survey frame is the first camera's: only its own consistency matters here.
SubmapPlacement place(const Window&, const std::vector<std::shared_ptr<const Frame>>&) {
  return {};
}

Oriented orient(capture::Source& source, const odometry::Config& config) {
  Oriented found;
  odometry::VisualOdometry odometry(config, place);
  std::set<std::uint64_t> oriented;
  const auto take = [&](Orientation orientation) {
    for (const ImagePose& pose : orientation.poses) oriented.insert(pose.image);
    for (auto& key_frame : orientation.settled) {
      if (found.key_frames.size() < odometry::kMostKeyFramesFitted) {
        found.key_frames.push_back(std::move(key_frame));
      }
    }
    for (Alert& alert : orientation.alerts) {
      if (alert.kind == AlertKind::calibration_suspect)
        found.suspicions.emplace(alert.message, alert);
    }
  };
  while (auto shot = source.next())
    take(odometry.process(std::make_shared<Shot>(*std::move(shot))));
  take(odometry.finish());
  found.images = oriented.size();
  return found;
}

void print(const odometry::LensFit& lens, const char* camera) {
  std::printf("%s\n  residuals from the centre to the corners", camera);
  for (const double rms : lens.rms_px) {
    if (rms > 0) {
      std::printf(" %.2f", rms);
    } else {
      std::printf(" -");
    }
  }
  std::printf(" px\n  focal length: the images ask for %.4f (+- %.4f) of the calibration's\n",
              lens.focal_ratio.value, lens.focal_ratio.sigma);
  std::printf("  distortion: off by at most %.2f px (+- %.2f)\n", lens.distortion_px.value,
              lens.distortion_px.sigma);
}

void print(const odometry::CalibrationFit& fit) {
  std::printf("%d key frames, %d observations of tie points\n", fit.images, fit.observations);
  std::printf("reprojection residuals %.3f px; with the calibration the images ask for %.3f px\n",
              fit.rms_px, fit.refined_rms_px);
  print(fit.left, fit.right ? "left camera" : "camera");
  if (fit.right) print(*fit.right, "right camera");
  if (!fit.pair) return;
  std::printf("pair\n  epipolar residuals %.3f px, refined %.3f px (medians)\n",
              fit.pair->epipolar_px, fit.pair->refined_epipolar_px);
  if (fit.pair->delay_s.sigma > 0) {
    std::printf("  right images %.2f ms (+- %.2f) after the left ones\n",
                1e3 * fit.pair->delay_s.value, 1e3 * fit.pair->delay_s.sigma);
  }
}

void print(const Alert& alert) {
  std::printf("%s: %s; %s\n", std::string(to_string(alert.kind)).c_str(), alert.message.c_str(),
              alert.remedy.c_str());
}

}  // namespace

int run(const CheckCalibration& verb) {
  Config config = configured(verb.settings);
  if (!config.reference.attitude)
    config.odometry.attitude_sigma_deg = config.odometry.heading_sigma_deg = 0;
  cv::setNumThreads(1);
  const auto opened = capture::open_survey(verb.folder, verb.calibration, config.capture);
  capture::Source& source = *opened;
  const Oriented found = orient(source, config.odometry);
  std::printf("%zu of %zu images oriented\n", found.images, source.size());
  const auto fit = odometry::fit_calibration(found.key_frames);
  if (fit) print(*fit);

  bool doubtful = !found.suspicions.empty();
  for (const auto& [message, alert] : found.suspicions) print(alert);
  if (!fit) {
    std::puts(
        "the calibration could not be checked: too few images are oriented with it; take "
        "some twenty with 60 % overlap over textured ground, or the calibration is wrong");
    return kDoubtful;
  }
  for (const Alert& alert : doubts(*fit)) {
    print(alert);
    doubtful = true;
  }
  if (doubtful) return kDoubtful;
  std::puts("the calibration fits these images");
  return 0;
}

}  // namespace nadir::app

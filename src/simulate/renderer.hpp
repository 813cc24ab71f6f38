// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The camera's picture of a scene: rays through the lens model, light through the water, then the
// sensor. Each pixel averages its centre and the mean of its four corners (quincunx).
#pragma once

#include <opencv2/core/mat.hpp>

#include "nadir/core/camera_model.hpp"
#include "shading.hpp"

namespace nadir::simulate {

class Renderer {
 public:
  /// Both must outlive the renderer.
  Renderer(const Scene& scene, const CameraModel& camera);

  /// Linear B G R, CV_32FC3, at the camera's size. The same bits with any number of threads.
  cv::Mat3f radiance(const Rigid3& local_from_camera, const Light& light) const;

  /// Depth along the optical axis at the pixel centres, metres; 0 where a ray meets nothing.
  cv::Mat1f depth(const Rigid3& local_from_camera) const;

 private:
  template <class Visit>
  void cast(const cv::Mat2f& rays, const Rigid3& local_from_camera, Visit visit) const;
  template <class Visit>
  void cast_tile(const cv::Mat2f& rays, const cv::Rect& tile, const Rigid3& local_from_camera,
                 Visit visit) const;

  const Scene& scene_;
  double focal_length_;          ///< px
  cv::Mat2f centres_, corners_;  ///< of the pixels, as normalised image coordinates
};

/// Drifting particles lit by the lamps, in the left camera's frame.
struct Snow {
  struct Flake {
    Eigen::Vector3d x_in_left;
    double radius;  ///< metres
    float brightness;
  };
  std::vector<Flake> flakes;
};
Snow make_snow(const CameraModel& camera, double altitude, double number, std::uint64_t seed);
void add_snow(cv::Mat3f& radiance, const Snow& snow, const CameraModel& camera,
              const Rigid3& camera_from_left, const cv::Vec3f& white);

/// Photon and read noise (times `noise`), tone curve, 8 bits: CV_8UC3. gain: from radiance to full
/// scale 1.
cv::Mat expose(const cv::Mat3f& radiance, const cv::Vec3f& gain, float noise, std::uint64_t seed);

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// An image on its plane: where its pixels lie in survey XY, and the image resampled there.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "nadir/core/camera_model.hpp"
#include "nadir/core/frame.hpp"
#include "nadir/core/tile.hpp"

namespace nadir::mosaic2d {

struct View {
  CameraModel camera;
  Rigid3 survey_from_camera;
  Plane plane;
  double max_range = 0;  ///< survey units; longer rays are cut
};

/// Where the ray of a pixel meets the plane; none behind the camera, beyond max_range or where the
/// lens model has no inverse.
std::optional<Eigen::Vector3d> ground_point(const View& view, const Eigen::Vector2d& pixel);

/// The image's extent on the ground.
struct Footprint {
  Eigen::Vector2d least = Eigen::Vector2d::Zero();  ///< survey XY
  Eigen::Vector2d most = Eigen::Vector2d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< ground point of the image centre
  double viewing_distance = 0;                       ///< from the camera to it
  double sampling_distance = 0;  ///< of the image itself there, survey units per px
};

/// None when the image centre has no ground point.
std::optional<Footprint> footprint(const View& view);

/// The pixels of the grid's raster that hold the footprint, with a margin of one; none beyond
/// 2^29 px from the raster's origin or for more than max_pixels.
std::optional<cv::Rect> raster(const Footprint& footprint, const MosaicGrid& grid,
                               double max_pixels);

/// The image on those pixels, CV_8UC4, alpha 0 where it does not reach; bilinear, from an image
/// reduced by area averages first where it is much finer than the raster.
ProjectedImage project_image(const cv::Mat& bgr, const View& view, const MosaicGrid& grid,
                             const cv::Rect& raster);

/// Makes a disc of the view's image transparent.
void hide(ProjectedImage& image, const View& view, const Disc& disc);

}  // namespace nadir::mosaic2d

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/corrected.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nadir::mosaic2d {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

Matrix2d linear(const WorldFile& world) { return Matrix2d{{world.a, world.b}, {world.d, world.e}}; }

WorldFile world_of(const Matrix2d& linear, const Vector2d& origin) {
  return {linear(0, 0), linear(1, 0), linear(0, 1), linear(1, 1), origin.x(), origin.y()};
}

}  // namespace

WorldFile moved(const WorldFile& world, const Plane& plane, const Similarity3& correction) {
  // On the plane z is linear in x and y, so that the correction of (x, y) is affine.
  const Eigen::Matrix3d turn = correction.scale * correction.rigid.rotation.toRotationMatrix();
  const Vector2d slope = -plane.normal.head<2>() / plane.normal.z();
  const Matrix2d by = turn.topLeftCorner<2, 2>() + turn.topRightCorner<2, 1>() * slope.transpose();
  const Vector2d shift = turn.topRightCorner<2, 1>() * (plane.offset / plane.normal.z()) +
                         correction.rigid.translation.head<2>();
  return world_of(by * linear(world), by * Vector2d(world.c, world.f) + shift);
}

MosaicGrid moved(MosaicGrid grid, const Similarity3& correction) {
  grid.world = moved(grid.world, grid.plane, correction);
  grid.ground_sampling_distance *= correction.scale;
  Plane& plane = grid.plane;
  plane.normal = correction.rigid.rotation * plane.normal;
  plane.centroid = correction * plane.centroid;
  plane.offset = correction.scale * plane.offset + plane.normal.dot(correction.rigid.translation);
  plane.rms *= correction.scale;
  return grid;
}

MosaicGrid levelled(MosaicGrid grid) {
  const double distance = std::sqrt(std::abs(linear(grid.world).determinant()));
  grid.ground_sampling_distance = distance;
  grid.world = {distance, 0, 0, -distance, grid.world.c, grid.world.f};
  return grid;
}

ProjectedImage aligned(const ProjectedImage& image, const MosaicGrid& grid) {
  const double distance = grid.ground_sampling_distance;
  const auto on_raster = [&](const Vector2d& survey) {
    return Vector2d((survey.x() - grid.world.c) / distance, (grid.world.f - survey.y()) / distance);
  };
  const double right = image.bgra.cols - 1, bottom = image.bgra.rows - 1;
  Vector2d low = on_raster(image.world(0, 0)), high = low;
  for (const auto& [column, row] :
       std::array<std::pair<double, double>, 3>{{{right, 0}, {0, bottom}, {right, bottom}}}) {
    const Vector2d corner = on_raster(image.world(column, row));
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  low = low.array().floor();
  high = high.array().ceil();
  const Vector2d size = high - low + Vector2d::Ones();
  ProjectedImage result{image.image, {}, {}};
  constexpr double kFarthest = 1 << 29, kMostGrowth = 16;
  const bool near = low.cwiseAbs().maxCoeff() < kFarthest && high.cwiseAbs().maxCoeff() < kFarthest;
  const double pixels = static_cast<double>(image.bgra.total());
  if (!near || !(size.prod() < kMostGrowth * pixels + 1e4)) return result;
  const Vector2d origin = grid.world(low.x(), low.y());
  result.world = {distance, 0, 0, -distance, origin.x(), origin.y()};
  const Matrix2d back = linear(image.world).inverse();
  const Matrix2d by = back * linear(result.world);
  const Vector2d shift = back * (origin - Vector2d(image.world.c, image.world.f));
  const cv::Matx23d image_from_result(by(0, 0), by(0, 1), shift.x(), by(1, 0), by(1, 1), shift.y());
  cv::warpAffine(image.bgra, result.bgra, image_from_result,
                 cv::Size(static_cast<int>(size.x()), static_cast<int>(size.y())),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
  // A pixel mixed with what was not seen is not seen.
  cv::Mat alpha, unseen;
  cv::extractChannel(result.bgra, alpha, 3);
  cv::compare(alpha, 255, unseen, cv::CMP_LT);
  result.bgra.setTo(cv::Scalar::all(0), unseen);
  return result;
}

}  // namespace nadir::mosaic2d

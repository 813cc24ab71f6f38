// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "plane_homography.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace nadir::mosaic2d {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

// The lens is exact at the nodes of a lattice and bilinear between: at 16 px and a distortion of
// k1 = 0.3 the error is 16^2 / 8 * 6 k1 r / f, under 0.1 px at f = 500 px.
constexpr int kLattice = 16;

// Homography of the plane: x_in_camera of pixel (column, row, 1) of the raster, in survey units.
Matrix3d camera_from_raster(const View& view, const WorldFile& world) {
  const Plane& plane = view.plane;
  const auto on_plane = [&](double x, double y) {
    const double z =
        (plane.offset - plane.normal.x() * x - plane.normal.y() * y) / plane.normal.z();
    return Vector3d(x, y, z);
  };
  const Vector3d origin = on_plane(world.c, world.f);
  Matrix3d survey_from_raster;
  survey_from_raster << on_plane(world.c + world.a, world.f) - origin,
      on_plane(world.c, world.f + world.e) - origin, origin - view.survey_from_camera.translation;
  return view.survey_from_camera.rotation.conjugate() * survey_from_raster;
}

// Pixel of the image that a pixel of the raster shows.
class ImageFromRaster {
 public:
  ImageFromRaster(const View& view, const WorldFile& world)
      : view_(view), camera_from_raster_(camera_from_raster(view, world)) {}

  std::optional<Vector2d> operator()(double column, double row) const {
    const Vector3d x = camera_from_raster_ * Vector3d(column, row, 1);
    if (!(x.norm() <= view_.max_range)) return std::nullopt;
    return view_.camera.project(x);
  }

 private:
  const View& view_;
  Matrix3d camera_from_raster_;
};

// cv::remap's fixed-point map: whole pixels and an index of 1/32 px fractions.
struct FixedMap {
  cv::Mat pixels, fractions;
  explicit FixedMap(cv::Size size) : pixels(size, CV_16SC2), fractions(size, CV_16UC1) {}
};

constexpr int kFractionBits = cv::INTER_BITS;
constexpr int kFractions = cv::INTER_TAB_SIZE;
constexpr double kOutside = -2;  // px: no weight of an image's pixel reaches so far

void set(cv::Vec2s& pixel, std::uint16_t& fraction, int x, int y) {
  pixel = {static_cast<short>(x >> kFractionBits), static_cast<short>(y >> kFractionBits)};
  fraction =
      static_cast<std::uint16_t>((y & (kFractions - 1)) * kFractions + (x & (kFractions - 1)));
}

int fixed(double px, int most) {
  return static_cast<int>(std::lround(std::clamp(px, kOutside, most + 1.0) * kFractions));
}

struct Lattice {
  int columns, rows;  ///< of nodes
  std::vector<std::optional<Vector2d>> nodes;

  Lattice(const ImageFromRaster& image_from_raster, cv::Size size)
      : columns((size.width - 1) / kLattice + 2), rows((size.height - 1) / kLattice + 2) {
    nodes.reserve(static_cast<std::size_t>(columns * rows));
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        nodes.push_back(image_from_raster(i * kLattice, j * kLattice));
      }
    }
  }
  const std::optional<Vector2d>& at(int i, int j) const {
    return nodes[static_cast<std::size_t>(j * columns + i)];
  }
};

struct Filler {
  const ImageFromRaster& image_from_raster;
  cv::Size image;
  FixedMap& map;

  void point(int column, int row, const Vector2d& p) {
    set(map.pixels.at<cv::Vec2s>(row, column), map.fractions.at<std::uint16_t>(row, column),
        fixed(p.x(), image.width), fixed(p.y(), image.height));
  }
  // At the edge of the lens model or of the range a cell has no four corners: pixel by pixel.
  void exactly(const cv::Rect& cell) {
    for (int row = cell.y; row < cell.y + cell.height; ++row) {
      for (int column = cell.x; column < cell.x + cell.width; ++column) {
        point(column, row, image_from_raster(column, row).value_or(Vector2d::Constant(kOutside)));
      }
    }
  }
  void bilinearly(const cv::Rect& cell, const Vector2d (&corner)[4]) {
    const double u_most = image.width + 1.0, v_most = image.height + 1.0;
    for (int j = 0; j < cell.height; ++j) {
      const double down = static_cast<double>(j) / kLattice;
      const Vector2d left = corner[0] + down * (corner[2] - corner[0]);
      const Vector2d right = corner[1] + down * (corner[3] - corner[1]);
      const Vector2d step = (right - left) * (kFractions / static_cast<double>(kLattice));
      const Vector2d start = left * kFractions + Vector2d::Constant(0.5);
      auto* pixels = map.pixels.ptr<cv::Vec2s>(cell.y + j) + cell.x;
      auto* fractions = map.fractions.ptr<std::uint16_t>(cell.y + j) + cell.x;
      for (int i = 0; i < cell.width; ++i) {
        const double u =
            std::clamp(start.x() + i * step.x(), kOutside * kFractions, u_most * kFractions);
        const double v =
            std::clamp(start.y() + i * step.y(), kOutside * kFractions, v_most * kFractions);
        // Above -2 px a shift keeps the truncation a floor.
        set(pixels[i], fractions[i], static_cast<int>(u + 64) - 64, static_cast<int>(v + 64) - 64);
      }
    }
  }
};

FixedMap fixed_map(const ImageFromRaster& image_from_raster, cv::Size size, cv::Size image) {
  FixedMap map(size);
  Filler fill{image_from_raster, image, map};
  const Lattice lattice(image_from_raster, size);
  for (int j = 0; j + 1 < lattice.rows; ++j) {
    for (int i = 0; i + 1 < lattice.columns; ++i) {
      const cv::Rect cell =
          cv::Rect(i * kLattice, j * kLattice, kLattice, kLattice) & cv::Rect({0, 0}, size);
      const auto &a = lattice.at(i, j), &b = lattice.at(i + 1, j), &c = lattice.at(i, j + 1),
                 &d = lattice.at(i + 1, j + 1);
      if (a && b && c && d) {
        fill.bilinearly(cell, {*a, *b, *c, *d});
      } else {
        fill.exactly(cell);
      }
    }
  }
  return map;
}

// Border pixels are mixed with the nothing outside; what is not wholly image is dropped.
void keep_opaque(cv::Mat& bgra) {
  for (int row = 0; row < bgra.rows; ++row) {
    auto* pixels = bgra.ptr<cv::Vec4b>(row);
    for (int column = 0; column < bgra.cols; ++column) {
      if (pixels[column][3] != 255) pixels[column] = cv::Vec4b::all(0);
    }
  }
}

// The largest of 1, 2, 4 that leaves the image no coarser than the raster.
int reduction(const View& view, const MosaicGrid& grid) {
  const std::optional<Footprint> seen = footprint(view);
  const double ratio = seen ? grid.ground_sampling_distance / seen->sampling_distance : 1;
  return ratio >= 4 ? 4 : ratio >= 2 ? 2 : 1;
}

cv::Mat reduced(const cv::Mat& bgr, int divisor) {
  if (divisor == 1) return bgr;
  const cv::Size size(bgr.cols / divisor, bgr.rows / divisor);
  cv::Mat small;
  cv::resize(bgr(cv::Rect({0, 0}, size * divisor)), small, size, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace

std::optional<Vector3d> ground_point(const View& view, const Vector2d& pixel) {
  const std::optional<Vector2d> image = view.camera.unproject(pixel);
  if (!image) return std::nullopt;
  const Vector3d& camera = view.survey_from_camera.translation;
  const Vector3d ray = view.survey_from_camera.rotation * image->homogeneous().normalized();
  const double range = -view.plane.distance(camera) / view.plane.normal.dot(ray);
  if (!(range > 0 && range <= view.max_range)) return std::nullopt;
  return camera + range * ray;
}

std::optional<Footprint> footprint(const View& view) {
  const double right = view.camera.width - 1, bottom = view.camera.height - 1;
  const auto centre = ground_point(view, {right / 2, bottom / 2});
  if (!centre) return std::nullopt;
  Footprint seen;
  seen.centre = *centre;
  seen.least = seen.most = centre->head<2>();
  seen.viewing_distance = (*centre - view.survey_from_camera.translation).norm();
  seen.sampling_distance =
      (view.survey_from_camera.inverse() * *centre).z() / std::max(view.camera.fx, view.camera.fy);
  constexpr int kSteps = 32;  // an extreme between two of them is off by less than the margin
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const auto x = ground_point(view, {right * i / kSteps, bottom * j / kSteps});
      if (!x) continue;
      seen.least = seen.least.cwiseMin(x->head<2>());
      seen.most = seen.most.cwiseMax(x->head<2>());
    }
  }
  return seen;
}

std::optional<cv::Rect> raster(const Footprint& footprint, const MosaicGrid& grid,
                               double max_pixels) {
  const double gsd = grid.ground_sampling_distance;
  const double left = std::floor((footprint.least.x() - grid.world.c) / gsd) - 1;
  const double right = std::ceil((footprint.most.x() - grid.world.c) / gsd) + 1;
  const double top = std::floor((grid.world.f - footprint.most.y()) / gsd) - 1;
  const double bottom = std::ceil((grid.world.f - footprint.least.y()) / gsd) + 1;
  const double width = right - left + 1, height = bottom - top + 1;
  constexpr double kFarthest = 1 << 29;
  const bool near =
      std::max({std::abs(left), std::abs(right), std::abs(top), std::abs(bottom)}) < kFarthest;
  if (!near || !(width * height <= max_pixels)) return std::nullopt;
  return cv::Rect(static_cast<int>(left), static_cast<int>(top), static_cast<int>(width),
                  static_cast<int>(height));
}

ProjectedImage project_image(const cv::Mat& bgr, const View& view, const MosaicGrid& grid,
                             const cv::Rect& raster) {
  ProjectedImage projected;
  projected.world = grid.world;
  projected.world.c = grid.world.c + raster.x * grid.ground_sampling_distance;
  projected.world.f = grid.world.f - raster.y * grid.ground_sampling_distance;

  const int divisor = reduction(view, grid);
  View seen = view;
  seen.camera = view.camera.reduced(divisor);
  const cv::Mat source = reduced(bgr, divisor);
  cv::Mat opaque;
  cv::cvtColor(source, opaque, cv::COLOR_BGR2BGRA);
  const FixedMap map =
      fixed_map(ImageFromRaster(seen, projected.world), raster.size(), source.size());
  cv::remap(opaque, projected.bgra, map.pixels, map.fractions, cv::INTER_LINEAR,
            cv::BORDER_CONSTANT);
  keep_opaque(projected.bgra);
  return projected;
}

}  // namespace nadir::mosaic2d

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "plane_homography.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "bgra.hpp"
#include "nadir/core/clones.hpp"
#include "nadir/image_io/reduce.hpp"

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

constexpr int kOutside = -2;  // px: bilinear weights of the image do not reach so far

// Border pixels are mixed with the nothing outside; what is not wholly image is dropped.
NADIR_CLONES
void keep_opaque(std::uint8_t* bgra, int count) {
  for (int i = 0; i < count; ++i) {
    std::uint32_t pixel = pixel_at(bgra, i);
    pixel = (pixel & kAlpha) == kAlpha ? pixel : 0;
    std::memcpy(bgra + kChannels * i, &pixel, sizeof pixel);
  }
}

constexpr std::ptrdiff_t kAxes = 2;

// Places of one row of a cell in 1/32 px, evenly spaced: whole pixels and the index of fractions.
NADIR_CLONES
void fill_row(const Eigen::Vector2i& start, const Eigen::Vector2i& step, int bits, int count,
              short* pixels, std::uint16_t* fractions) {
  constexpr int kMask = cv::INTER_TAB_SIZE - 1;
  for (int i = 0; i < count; ++i) {
    const int x = (start.x() + i * step.x()) >> bits, y = (start.y() + i * step.y()) >> bits;
    pixels[kAxes * i] = static_cast<short>(x >> cv::INTER_BITS);
    pixels[kAxes * i + 1] = static_cast<short>(y >> cv::INTER_BITS);
    fractions[i] = static_cast<std::uint16_t>((y & kMask) * cv::INTER_TAB_SIZE + (x & kMask));
  }
}

// Row by row of lattice cells: their part of cv::remap's fixed-point map, whole pixels and an index
// of 1/32 px fractions, then the pixels themselves. Cells that do not touch the image stay empty.
class Warp {
 public:
  Warp(const cv::Mat& image, const ImageFromRaster& image_from_raster, cv::Mat& raster)
      : image_(image),
        image_from_raster_(image_from_raster),
        raster_(raster),
        columns_((raster.cols - 1) / kLattice + 2),
        pixels_(kLattice, raster.cols, CV_16SC2),
        fractions_(kLattice, raster.cols, CV_16UC1) {}

  void run() {
    Nodes upper = nodes(0);
    for (int top = 0; top < raster_.rows; top += kLattice) {
      Nodes lower = nodes(top + kLattice);
      strip(top, upper, lower);
      upper = std::move(lower);
    }
  }

 private:
  using Nodes = std::vector<std::optional<Vector2d>>;
  struct Corners {
    const std::optional<Vector2d>&a, &b, &c, &d;  ///< top left, top right, bottom left and right
  };
  static constexpr int kScaleBits = 10;  // of the fixed point along a row, beyond 1/32 px

  Nodes nodes(int row) const {
    Nodes nodes(static_cast<std::size_t>(columns_));
    for (int i = 0; i < columns_; ++i) {
      nodes[static_cast<std::size_t>(i)] = image_from_raster_(i * kLattice, row);
    }
    return nodes;
  }

  // Between its corners a cell is bent by less than a pixel, so corners beyond one side mean that
  // all of it is. Where the lens model or the range ends there is no telling.
  bool touches_image(const Corners& k) const {
    if (!k.a && !k.b && !k.c && !k.d) return false;
    if (!k.a || !k.b || !k.c || !k.d) return true;
    const Vector2d least = k.a->cwiseMin(*k.b).cwiseMin(k.c->cwiseMin(*k.d));
    const Vector2d most = k.a->cwiseMax(*k.b).cwiseMax(k.c->cwiseMax(*k.d));
    return most.x() > -2 && most.y() > -2 && least.x() < image_.cols + 1 &&
           least.y() < image_.rows + 1;
  }

  bool is_smooth(const Corners& k) const {
    constexpr double kFarthest = 16000;  // px: room in the fixed point and in a short
    const auto fits = [](const std::optional<Vector2d>& p) {
      return p && p->cwiseAbs().maxCoeff() < kFarthest;
    };
    return fits(k.a) && fits(k.b) && fits(k.c) && fits(k.d);
  }

  void strip(int top, const Nodes& upper, const Nodes& lower) {
    const int rows = std::min(kLattice, raster_.rows - top);
    int first = raster_.cols, end = 0;
    for (int i = 0; i + 1 < columns_; ++i) {
      const auto n = static_cast<std::size_t>(i);
      const Corners corners{upper[n], upper[n + 1], lower[n], lower[n + 1]};
      if (!touches_image(corners)) {
        if (end > 0) fill_outside(i);
        continue;
      }
      first = std::min(first, i * kLattice);
      end = std::min((i + 1) * kLattice, raster_.cols);
      is_smooth(corners) ? fill_smooth(i, rows, corners) : fill_exactly(i, top, rows);
    }
    raster_(cv::Rect(0, top, std::min(first, raster_.cols), rows)).setTo(cv::Scalar::all(0));
    if (end == 0) return;
    resample(cv::Rect(first, top, end - first, rows));
    raster_(cv::Rect(end, top, raster_.cols - end, rows)).setTo(cv::Scalar::all(0));
  }

  void fill_outside(int cell) {
    const cv::Rect area =
        cv::Rect(cell * kLattice, 0, kLattice, kLattice) & cv::Rect({0, 0}, pixels_.size());
    pixels_(area).setTo(cv::Scalar::all(kOutside));
    fractions_(area).setTo(0);
  }

  void place(int row, int column, const Eigen::Vector2i& start, const Eigen::Vector2i& step,
             int bits, int count) {
    fill_row(start, step, bits, count, pixels_.ptr<short>(row) + kAxes * column,
             fractions_.ptr<std::uint16_t>(row) + column);
  }

  void fill_exactly(int cell, int top, int rows) {
    const int end = std::min((cell + 1) * kLattice, raster_.cols);
    const Vector2d most(image_.cols + 1, image_.rows + 1);
    for (int j = 0; j < rows; ++j) {
      for (int column = cell * kLattice; column < end; ++column) {
        Vector2d p = image_from_raster_(column, top + j).value_or(Vector2d::Constant(kOutside));
        p = p.cwiseMax(kOutside).cwiseMin(most) * cv::INTER_TAB_SIZE;
        place(j, column, Eigen::Vector2i(cvRound(p.x()), cvRound(p.y())), Eigen::Vector2i::Zero(),
              0, 1);
      }
    }
  }

  void fill_smooth(int cell, int rows, const Corners& k) {
    constexpr double kScale = cv::INTER_TAB_SIZE << kScaleBits;
    constexpr int kHalf = 1 << (kScaleBits - 1);
    const int left = cell * kLattice, width = std::min(kLattice, raster_.cols - left);
    for (int j = 0; j < rows; ++j) {
      const double down = static_cast<double>(j) / kLattice;
      const Vector2d from = *k.a + down * (*k.c - *k.a), to = *k.b + down * (*k.d - *k.b);
      const Eigen::Vector2i start = (from * kScale).cast<int>() + Eigen::Vector2i::Constant(kHalf);
      const Eigen::Vector2i step = ((to - from) * (kScale / kLattice)).cast<int>();
      place(j, left, start, step, kScaleBits, width);
    }
  }

  void resample(const cv::Rect& area) {
    const cv::Rect local(area.x, 0, area.width, area.height);
    cv::Mat pixels = raster_(area);
    cv::remap(image_, pixels, pixels_(local), fractions_(local), cv::INTER_LINEAR,
              cv::BORDER_CONSTANT);
    for (int row = 0; row < pixels.rows; ++row) keep_opaque(pixels.ptr(row), pixels.cols);
  }

  const cv::Mat& image_;
  const ImageFromRaster& image_from_raster_;
  cv::Mat& raster_;
  int columns_;                 ///< of nodes
  cv::Mat pixels_, fractions_;  ///< of one row of cells
};

// The largest of 1, 2, 4 that leaves the image no coarser than the raster.
int reduction(const View& view, const MosaicGrid& grid) {
  const std::optional<Footprint> seen = footprint(view);
  const double ratio = seen ? grid.ground_sampling_distance / seen->sampling_distance : 1;
  return ratio >= 4 ? 4 : ratio >= 2 ? 2 : 1;
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
  const cv::Mat source = image_io::reduce(bgr, divisor);
  cv::Mat opaque;
  cv::cvtColor(source, opaque, cv::COLOR_BGR2BGRA);
  projected.bgra.create(raster.size(), CV_8UC4);
  const ImageFromRaster image_from_raster(seen, projected.world);
  Warp(opaque, image_from_raster, projected.bgra).run();
  return projected;
}

void hide(ProjectedImage& image, const View& view, const Disc& disc) {
  constexpr int kCorners = 24;
  std::vector<cv::Point> outline;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    const auto ground = ground_point(
        view, disc.pixel + disc.radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    if (!ground) return;
    const WorldFile& world = image.world;  // north up
    outline.emplace_back(cvRound((ground->x() - world.c) / world.a),
                         cvRound((ground->y() - world.f) / world.e));
  }
  cv::fillConvexPoly(image.bgra, outline, cv::Scalar::all(0));
}

}  // namespace nadir::mosaic2d

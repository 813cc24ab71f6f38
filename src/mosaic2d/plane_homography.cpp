// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "plane_homography.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "bgra.hpp"
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

constexpr int kUnit = 32;  // of places in an image, in a pixel

// Places along a row, evenly spaced, kBits finer than kUnit.
struct Places {
  static constexpr int kBits = 10;
  Eigen::Vector2i first, step;
};

// Takes bilinear samples of a BGRA image, in a third of cv::remap's time. Beyond its border pixels
// they would be mixed with the nothing outside: transparent.
class Sampler {
 public:
  explicit Sampler(const cv::Mat& bgra)
      : first_(bgra.data),
        row_size_(bgra.step),
        end_(kUnit * (bgra.cols - 1), kUnit * (bgra.rows - 1)) {
    for (int part = 0; part < kUnit; ++part) {
      Weights& weights = weights_[static_cast<std::size_t>(part)];
      weights.here.fill(static_cast<std::uint16_t>(kUnit - part));
      weights.next.fill(static_cast<std::uint16_t>(part));
      weights.both = weights.here;
      std::fill(weights.both.begin() + kChannels, weights.both.end(), weights.next[0]);
    }
  }

  void row(const Places& places, int count, std::uint8_t* to) const {
    const auto at = [&](int i) -> Eigen::Vector2i {
      const Eigen::Vector2i fine = places.first + i * places.step;
      return {fine.x() >> Places::kBits, fine.y() >> Places::kBits};
    };
    const bool all_inside = is_inside(at(0)) && is_inside(at(count - 1));
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2i place = at(i);
      const std::uint32_t pixel = all_inside || is_inside(place) ? sample(place) : 0;
      std::memcpy(to + kChannels * i, &pixel, sizeof pixel);
    }
  }

 private:
  using Eight = std::array<std::uint16_t, 2 * kChannels>;
  struct Weights {
    Eight here, next, both;  ///< of a pixel, of the one after it, of one beside the other
  };

  bool is_inside(const Eigen::Vector2i& place) const {
    return place.x() >= 0 && place.y() >= 0 && place.x() < end_.x() && place.y() < end_.y();
  }

  // Two neighbours at once, eight values of 16 bits: mixed with those below, rounded to a quarter
  // of a grey level, then with each other.
  std::uint32_t sample(const Eigen::Vector2i& place) const {
    const auto x = static_cast<std::size_t>(place.x()), y = static_cast<std::size_t>(place.y());
    const Weights &across = weights_[x % kUnit], &down = weights_[y % kUnit];
    const std::uint8_t* pair = first_ + y / kUnit * row_size_ + x / kUnit * kChannels;
    const auto upper = cv::v_load_expand(pair), lower = cv::v_load_expand(pair + row_size_);
    const auto mixed = cv::v_mul_wrap(upper, cv::v_load(down.here.data())) +
                       cv::v_mul_wrap(lower, cv::v_load(down.next.data())) + cv::v_setall_u16(4);
    const auto parts = cv::v_mul_wrap(cv::v_shr<3>(mixed), cv::v_load(across.both.data()));
    const auto sum = parts + cv::v_rotate_right<kChannels>(parts) + cv::v_setall_u16(64);
    const auto pixel = cv::v_shr<7>(sum);
    return cv::v_reinterpret_as_u32(cv::v_pack(pixel, pixel)).get0();
  }

  const std::uint8_t* first_;
  std::size_t row_size_;
  Eigen::Vector2i end_;  ///< of places that have neighbours
  std::array<Weights, kUnit> weights_;
};

// Cell by cell of the lattice. Cells that do not touch the image stay empty.
class Warp {
 public:
  Warp(const cv::Mat& image, const ImageFromRaster& image_from_raster, cv::Mat& raster)
      : image_(image),
        sampler_(image),
        image_from_raster_(image_from_raster),
        raster_(raster),
        columns_((raster.cols - 1) / kLattice + 2) {}

  void run() {
    Nodes upper = nodes(0);
    for (int top = 0; top < raster_.rows; top += kLattice) {
      Nodes lower = nodes(top + kLattice);
      for (int i = 0; i + 1 < columns_; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const cv::Rect cell =
            cv::Rect(i * kLattice, top, kLattice, kLattice) & cv::Rect({0, 0}, raster_.size());
        fill(cell, {upper[n], upper[n + 1], lower[n], lower[n + 1]});
      }
      upper = std::move(lower);
    }
  }

 private:
  using Nodes = std::vector<std::optional<Vector2d>>;
  struct Corners {
    const std::optional<Vector2d>&a, &b, &c, &d;  ///< top left, top right, bottom left and right
  };

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
    constexpr double kFarthest = 16000;  // px: room in the fixed point
    const auto fits = [](const std::optional<Vector2d>& p) {
      return p && p->cwiseAbs().maxCoeff() < kFarthest;
    };
    return fits(k.a) && fits(k.b) && fits(k.c) && fits(k.d);
  }

  void fill(const cv::Rect& cell, const Corners& corners) {
    if (!touches_image(corners)) {
      raster_(cell).setTo(cv::Scalar::all(0));
    } else if (is_smooth(corners)) {
      fill_smoothly(cell, corners);
    } else {
      fill_exactly(cell);
    }
  }

  void fill_exactly(const cv::Rect& cell) {
    const Vector2d outside = Vector2d::Constant(-1), most(image_.cols, image_.rows);
    for (int row = cell.y; row < cell.br().y; ++row) {
      for (int column = cell.x; column < cell.br().x; ++column) {
        const Vector2d p = image_from_raster_(column, row).value_or(outside);
        sample(row, column, p.cwiseMax(outside).cwiseMin(most), Vector2d::Zero(), 1);
      }
    }
  }

  void fill_smoothly(const cv::Rect& cell, const Corners& k) {
    for (int j = 0; j < cell.height; ++j) {
      const double down = static_cast<double>(j) / kLattice;
      const Vector2d from = *k.a + down * (*k.c - *k.a), to = *k.b + down * (*k.d - *k.b);
      sample(cell.y + j, cell.x, from, (to - from) / kLattice, cell.width);
    }
  }

  void sample(int row, int column, const Vector2d& first, const Vector2d& step, int count) {
    constexpr double kScale = kUnit << Places::kBits;
    constexpr int kHalf = 1 << (Places::kBits - 1);
    const Places places{(first * kScale).cast<int>() + Eigen::Vector2i::Constant(kHalf),
                        (step * kScale).cast<int>()};
    sampler_.row(places, count, raster_.ptr(row) + kChannels * column);
  }

  const cv::Mat& image_;
  Sampler sampler_;
  const ImageFromRaster& image_from_raster_;
  cv::Mat& raster_;
  int columns_;  ///< of nodes
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

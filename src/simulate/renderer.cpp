// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "renderer.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>

#include "nadir/core/check.hpp"
#include "random.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Vector3d;

constexpr int kTile = 32;  // samples

// Rays through a lattice of samples one pixel apart; `first`: the pixel of the first sample.
cv::Mat2f rays_of(const CameraModel& camera, double first, cv::Size size) {
  cv::Mat2f rays(size);
  cv::parallel_for_({0, rays.rows}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int column = 0; column < rays.cols; ++column) {
        const auto ray = camera.unproject({column + first, row + first});
        NADIR_CHECK(ray, row, column);
        rays(row, column) = {static_cast<float>(ray->x()), static_cast<float>(ray->y())};
      }
    }
  });
  return rays;
}

// Solids whose sphere touches the cone around a tile's rays.
std::vector<const Solid*> in_view(const std::vector<Solid>& solids, const Vector3d& eye,
                                  const std::vector<Vector3d>& corners) {
  Vector3d axis = Vector3d::Zero();
  for (const Vector3d& corner : corners) axis += corner.normalized();
  axis.normalize();
  double half = 0;
  for (const Vector3d& corner : corners) {
    half = std::max(half, std::acos(std::min(1.0, axis.dot(corner.normalized()))));
  }
  std::vector<const Solid*> seen;
  for (const Solid& solid : solids) {
    const Vector3d to = solid.centre - eye;
    const double distance = to.norm();
    const double off = std::acos(std::clamp(axis.dot(to) / distance, -1.0, 1.0));
    if (distance <= solid.radius || off - half < std::asin(solid.radius / distance)) {
      seen.push_back(&solid);
    }
  }
  return seen;
}

cv::Vec3f radiance_of(const Scene& scene, const Scene::Meeting& meeting, const Ray& ray,
                      double focal_length, const Light& light) {
  const Vector3d place = ray.at(meeting.hit.t);
  const float open = meeting.solid ? 1.0f : scene.relief.light_at(place.x(), place.y());
  const Skin skin = simulate::skin(scene, meeting, meeting.hit.t / focal_length);
  return radiance(light, skin, place, ray.origin, open);
}

float srgb(float linear) {  // IEC 61966-2-1
  const float v = std::clamp(linear, 0.0f, 1.0f);
  return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}

std::vector<float> tone_curve() {
  std::vector<float> curve(4097);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    curve[i] = 255 * srgb(static_cast<float>(i) / 4096);
  }
  return curve;
}

float toned(float linear) {
  static const std::vector<float> curve = tone_curve();
  const float at = std::clamp(linear, 0.0f, 0.9999f) * 4096;
  const auto i = static_cast<std::size_t>(at);
  return curve[i] + (at - static_cast<float>(i)) * (curve[i + 1] - curve[i]);
}

// Nearly normal, variance 1: the sum of four uniforms.
float noise_from(std::uint64_t bits) {
  const auto part = [&](int shift) { return static_cast<float>((bits >> shift) & 0xffff); };
  return ((part(0) + part(16) + part(32) + part(48)) * 0x1p-16f - 2) * 1.7320508f;
}

}  // namespace

Renderer::Renderer(const Scene& scene, const CameraModel& camera)
    : scene_(scene),
      focal_length_(camera.fx),
      centres_(rays_of(camera, 0, {camera.width, camera.height})),
      corners_(rays_of(camera, -0.5, {camera.width + 1, camera.height + 1})) {}

template <class Visit>
void Renderer::cast(const cv::Mat2f& rays, const Rigid3& local_from_camera, Visit visit) const {
  const int across = (rays.cols + kTile - 1) / kTile, down = (rays.rows + kTile - 1) / kTile;
  cv::parallel_for_({0, across * down}, [&](const cv::Range& tiles) {
    for (int i = tiles.start; i < tiles.end; ++i) {
      const cv::Rect tile(i % across * kTile, i / across * kTile, kTile, kTile);
      cast_tile(rays, tile & cv::Rect({}, rays.size()), local_from_camera, visit);
    }
  });
}

template <class Visit>
void Renderer::cast_tile(const cv::Mat2f& rays, const cv::Rect& tile,
                         const Rigid3& local_from_camera, Visit visit) const {
  const Eigen::Matrix3d turn = local_from_camera.rotation.toRotationMatrix();
  const auto ray_of = [&](int column, int row) {
    const cv::Vec2f& p = rays(row, column);
    return Ray{local_from_camera.translation, turn * Vector3d(p[0], p[1], 1)};
  };
  std::vector<Vector3d> corners;
  for (const int row : {tile.y, tile.br().y - 1}) {
    for (const int column : {tile.x, tile.br().x - 1}) {
      corners.push_back(ray_of(column, row).direction);
    }
  }
  const auto solids = in_view(scene_.solids, local_from_camera.translation, corners);
  double guess = -local_from_camera.translation.z() / corners.front().z();
  for (int row = tile.y; row < tile.br().y; ++row) {
    for (int column = tile.x; column < tile.br().x; ++column) {
      const Ray ray = ray_of(column, row);
      const auto meeting = scene_.meet(ray, solids, guess);
      if (meeting) guess = meeting->hit.t;
      visit(row, column, ray, meeting);
    }
  }
}

cv::Mat3f Renderer::radiance(const Rigid3& local_from_camera, const Light& light) const {
  const auto lattice = [&](const cv::Mat2f& rays) {
    cv::Mat3f seen(rays.size());
    cast(rays, local_from_camera,
         [&](int row, int column, const Ray& ray, const std::optional<Scene::Meeting>& meeting) {
           const float vignette = static_cast<float>(1 / ray.direction.squaredNorm());
           seen(row, column) =
               meeting ? vignette * radiance_of(scene_, *meeting, ray, focal_length_, light)
                       : light.water.veil;
         });
    return seen;
  };
  const cv::Mat3f centres = lattice(centres_), corners = lattice(corners_);
  const cv::Size size = centres.size();
  const auto corner = [&](int x, int y) { return corners(cv::Rect({x, y}, size)); };
  const cv::Mat sum = corner(0, 0) + corner(0, 1) + corner(1, 0) + corner(1, 1);
  cv::Mat picture = sum / 8 + centres / 2;
  return picture;
}

cv::Mat1f Renderer::depth(const Rigid3& local_from_camera) const {
  cv::Mat1f depth(centres_.size());
  cast(centres_, local_from_camera,
       [&](int row, int column, const Ray&, const std::optional<Scene::Meeting>& meeting) {
         depth(row, column) = meeting ? static_cast<float>(meeting->hit.t) : 0.0f;
       });
  return depth;
}

Snow make_snow(const CameraModel& camera, double altitude, double number, std::uint64_t seed) {
  Random random(seed);
  Snow snow;
  // Some images swim through a cloud of it.
  const double dense = random.uniform() < 0.3 ? 3 : 1;
  const int flakes = static_cast<int>(number * dense * random.uniform(0.5, 1.5));
  for (int i = 0; i < flakes; ++i) {
    const double z = altitude * std::cbrt(random.uniform(0.01, 0.85));
    const double x = random.uniform(-0.6, 0.6) * camera.width / camera.fx;
    const double y = random.uniform(-0.6, 0.6) * camera.height / camera.fy;
    snow.flakes.push_back({{x * z, y * z, z},
                           random.uniform(0.0005, 0.0025),
                           static_cast<float>(random.uniform(0.3, 1.2))});
  }
  return snow;
}

void add_snow(cv::Mat3f& radiance, const Snow& snow, const CameraModel& camera,
              const Rigid3& camera_from_left, const cv::Vec3f& white) {
  for (const Snow::Flake& flake : snow.flakes) {
    const Vector3d x = camera_from_left * flake.x_in_left;
    const auto at = camera.project(x);
    if (!at) continue;
    // Near the lens out of focus: wide and faint.
    const double in_focus = camera.fx * flake.radius / x.z();
    const double sigma = std::hypot(std::max(in_focus, 0.6), 0.0022 * camera.fx / x.z());
    const float peak = flake.brightness * static_cast<float>(std::min(
                                              1.0, 2.5 * in_focus * in_focus / (sigma * sigma)));
    const int reach = static_cast<int>(std::ceil(3 * sigma));
    const cv::Point centre(cvRound(at->x()), cvRound(at->y()));
    const cv::Rect box =
        cv::Rect(centre.x - reach, centre.y - reach, 2 * reach + 1, 2 * reach + 1) &
        cv::Rect({}, radiance.size());
    for (int row = box.y; row < box.br().y; ++row) {
      for (int column = box.x; column < box.br().x; ++column) {
        const double squared = std::pow(column - at->x(), 2) + std::pow(row - at->y(), 2);
        const double spread = std::exp(-squared / (2 * sigma * sigma));
        radiance(row, column) += white * (peak * static_cast<float>(spread));
      }
    }
  }
}

cv::Mat expose(const cv::Mat3f& radiance, const cv::Vec3f& gain, float noise, std::uint64_t seed) {
  constexpr float kRead = 0.003f, kPhoton = 2e-4f;  // of full scale: about 2 grey levels at mid
  cv::Mat image(radiance.size(), CV_8UC3);
  cv::parallel_for_({0, image.rows}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        auto& pixel = image.at<cv::Vec3b>(row, column);
        for (int c = 0; c < 3; ++c) {
          const float value = gain[c] * radiance(row, column)[c];
          const float sigma = noise * std::sqrt(kRead * kRead + kPhoton * std::max(value, 0.0f));
          const auto place = (static_cast<std::uint64_t>(row) << 34) |
                             (static_cast<std::uint64_t>(column) << 2) |
                             static_cast<std::uint64_t>(c);
          const float noisy = value + sigma * noise_from(hash(seed, place));
          pixel[c] = cv::saturate_cast<std::uint8_t>(toned(noisy));
        }
      }
    }
  });
  return image;
}

}  // namespace nadir::simulate

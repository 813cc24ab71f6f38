// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A dive of a few tiny images whose every number is known.
#pragma once

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "nadir/record/dive.hpp"

namespace nadir::record {

struct SmallDive {
  int images = 4;
  int rejected = -1;  ///< this image cannot be read
  bool metric = true;
  double far_away = 0;  ///< survey units in x
  int width = 12, height = 8;
  double sampling = 0.01;
  bool with_tiles = true;

  static constexpr std::uint64_t kPointsEach = 3;

  Rigid3 pose(std::uint64_t image) const {
    const double i = static_cast<double>(image);
    return {Eigen::Quaterniond(0.1 * i, 0.9, -0.2, 0.05).normalized(),
            {far_away + 0.25 * i, -0.125, 2.5}};
  }
  Time time(std::uint64_t image) const {
    return 1'700'000'000'123'456'789 + static_cast<Time>(image) * 500'000'001;
  }
  Plane plane() const {
    return {Eigen::Vector3d::UnitZ(), 0.5, {far_away, 0, 0.5}, 9, 0.9, 0.01, 3};
  }

  WorldFile world(std::uint64_t image) const {
    WorldFile world;
    world.a = sampling;
    world.e = -sampling;
    world.c = far_away + sampling * 4 * static_cast<double>(image);
    world.f = 2;
    return world;
  }
  ProjectedImage projected(std::uint64_t image) const {
    cv::Mat bgra(height, width, CV_8UC4, cv::Scalar(10 + 20 * double(image), 60, 90, 255));
    for (int x = 0; x < width; ++x) bgra.at<cv::Vec4b>(x % height, x)[1] = static_cast<uchar>(x);
    bgra.at<cv::Vec4b>(0, 0) = {0, 0, 0, 0};
    return {image, bgra, world(image)};
  }
  MosaicGrid mosaic() const {
    MosaicGrid grid;
    grid.ground_sampling_distance = sampling;
    grid.world = world(0);
    grid.plane = plane();
    return grid;
  }
  std::shared_ptr<const Tile> tile(std::int32_t row, std::int32_t column) const {
    cv::Mat bgra(MosaicGrid::kTileSize, MosaicGrid::kTileSize, CV_8UC4, cv::Scalar::all(0));
    bgra(cv::Rect(10, 20, 100, 50)).setTo(cv::Scalar(1, 2, 3, 255));
    return std::make_shared<const Tile>(Tile{0, column, row, bgra});
  }
  Grid grid(std::uint64_t image) const {
    Grid grid;
    grid.image = image;
    grid.bgr = cv::Mat(3, 4, CV_8UC3, cv::Scalar(5, 6, 7 + double(image)));
    grid.survey_from_grid.row(0) << 0.1, 0, far_away;
    grid.survey_from_grid.row(1) << 0, -0.1, 1;
    grid.survey_from_grid.row(2) << 0, 0, 0.5;
    grid.survey_from_grid.row(3) << 0, 0, 1;
    grid.camera_in_survey = {far_away, 0, 2.5};
    grid.max_range = 100;
    return grid;
  }
  std::shared_ptr<const Window> window(std::uint64_t image) const {
    auto window = std::make_shared<Window>();
    window->axes = SurveyAxes::attitude;
    if (metric) window->scale = {ScaleSource::stereo, 0.001};
    for (std::uint64_t k = 0; k < kPointsEach; ++k) {
      // The last point of a window is seen again, and better, as the first of the next.
      const std::uint64_t id = (kPointsEach - 1) * image + k;
      const double better = k == 0 ? 1 : 0;
      window->tie_points.push_back({id,
                                    {far_away + double(id), double(image), better},
                                    {1, 2, static_cast<std::uint8_t>(id)},
                                    static_cast<std::uint32_t>(2 + k),
                                    0.5});
    }
    return window;
  }

  Entry entry(std::uint64_t image) const {
    auto shot = std::make_shared<Shot>();
    shot->image = image;
    shot->time = time(image);
    shot->name = "dsc," + std::to_string(image);
    auto orientation = std::make_shared<Orientation>();
    orientation->shot = shot;
    auto surface = std::make_shared<Surface>();
    auto cloud = std::make_shared<Cloud>();
    auto update = std::make_shared<MosaicUpdate>();
    if (static_cast<int>(image) == rejected) {
      shot->alerts.push_back({shot->time, image, AlertKind::image_rejected, "damaged", "none"});
    } else {
      shot->frame = std::make_shared<const Frame>();
      orientation->state = TrackingState::tracking;
      orientation->poses.push_back({image, shot->time, 0, pose(image), true, 3, 0.4});
      orientation->health = {3, {1, 1, 1, 0}, 2.5, 0.4, 120.5, 99.25};
      orientation->window = window(image);
      surface->plane = plane();
      cloud->grid = grid(image);
      update->grid = mosaic();
      update->projected = projected(image);
      if (with_tiles) update->tiles = {tile(0, 0), tile(1, static_cast<std::int32_t>(image) - 1)};
    }
    surface->orientation = orientation;
    cloud->surface = surface;
    update->surface = surface;
    return {orientation, surface, cloud, update};
  }

  DiveInfo info() const {
    DiveInfo info;
    info.about = {{"versions", {{"nadir", "0.1.0"}}}, {"configuration", {{"odometry.window", 3}}}};
    return info;
  }
};

/// A folder of its own, in memory where the machine has such a place; gone with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    static std::atomic<int> count = 0;
    const std::filesystem::path memory = "/dev/shm";
    const auto base =
        std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
    name_ = base / ("nadir-record-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
    std::filesystem::remove_all(name_);
    std::filesystem::create_directories(name_);
  }
  ~ScratchFolder() {
    std::error_code error;
    std::filesystem::remove_all(name_, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path operator/(const std::filesystem::path& name) const { return name_ / name; }

 private:
  std::filesystem::path name_;
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

/// Every file of a folder by its relative name.
inline std::map<std::string, std::string> read_all(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& item : std::filesystem::recursive_directory_iterator(folder)) {
    if (!item.is_regular_file()) continue;
    files[std::filesystem::relative(item.path(), folder).string()] = read_text(item.path());
  }
  return files;
}

}  // namespace nadir::record

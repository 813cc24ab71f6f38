// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The rendered pool, whose floor carries coded targets: the white disc of each is where the world
// file of the projected image says.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "mosaic2d/scene.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/mosaic2d/mosaicker.hpp"

namespace nadir::mosaic2d {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

const std::filesystem::path kPool = std::filesystem::path(NADIR_SHARED_DATA) / "rendered/pool";
const CameraModel kCamera{968,
                          728,
                          918.2,
                          917.4,
                          479.6,
                          367.9,
                          LensModel::brown_conrady,
                          {-0.108, 0.089, -5e-4, 6e-4, -0.015}};  // of calib.yml

std::vector<std::vector<std::string>> rows(const std::filesystem::path& file, char separator) {
  std::ifstream in(file);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, separator);) rows.back().push_back(cell);
  }
  return rows;
}

std::vector<Rigid3> poses() {
  std::vector<Rigid3> poses;
  for (const auto& row : rows(kPool / "gt_poses_tum.txt", ' ')) {
    const auto value = [&](std::size_t i) { return std::stod(row.at(i)); };
    poses.push_back({Eigen::Quaterniond(value(7), value(4), value(5), value(6)).normalized(),
                     {value(1), value(2), value(3)}});
  }
  return poses;
}

std::map<std::string, Vector3d> targets_on_the_floor() {
  std::map<std::string, Vector3d> targets;
  for (const auto& row : rows(kPool / "gt_points.csv", ',')) {
    if (row.at(3) != "-3.188000") continue;
    targets[row[0]] = {std::stod(row[1]), std::stod(row[2]), std::stod(row[3])};
  }
  return targets;
}

// Centre of the bright disc that covers a pixel; white is beyond the middle of what is around.
std::optional<Vector2d> disc_at(const ProjectedImage& image, const Vector2d& expected,
                                int radius_px) {
  const cv::Point middle(
      static_cast<int>(std::lround((expected.x() - image.world.c) / image.world.a)),
      static_cast<int>(std::lround((expected.y() - image.world.f) / image.world.e)));
  const cv::Rect around(middle.x - radius_px, middle.y - radius_px, 2 * radius_px + 1,
                        2 * radius_px + 1);
  if ((around & cv::Rect({0, 0}, image.bgra.size())) != around) return std::nullopt;
  cv::Mat grey, white, labels, statistics, centres;
  cv::cvtColor(image.bgra(around), grey, cv::COLOR_BGRA2GRAY);
  double least = 0, most = 0;
  cv::minMaxLoc(grey, &least, &most);
  cv::threshold(grey, white, (least + most) / 2, 255, cv::THRESH_BINARY);
  cv::connectedComponentsWithStats(white, labels, statistics, centres, 4);
  const int disc = labels.at<int>(radius_px, radius_px);
  if (disc == 0) return std::nullopt;
  return image.world(around.x + centres.at<double>(disc, 0),
                     around.y + centres.at<double>(disc, 1));
}

cv::Mat decoded(const std::string& name) {
  std::ifstream in(kPool / "images/left" / (name + ".jpg"), std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  return image_io::decode({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, 968,
                          728, 1, image_io::Colour::bgr)
      .image;
}

TEST(Pool, TargetsLieWithinTwoSamplingDistancesOfTheirPlace) {
  if (!std::filesystem::exists(kPool / "gt_points.csv")) {
    std::cout << "not run: no data\n";
    return;
  }
  const auto targets = targets_on_the_floor();
  const auto trajectory = poses();
  int found = 0, seen = 0;
  double worst = 0;
  for (const auto& row : rows(kPool / "gt_observations.csv", ',')) {
    const auto target = targets.find(row.at(2));
    if (row[1] != "left" || target == targets.end() || std::stoi(row[0]) % 3 != 0) continue;
    test::Scene scene;
    scene.camera = kCamera;
    scene.survey_from_camera = trajectory.at(std::stoul(row[0]));
    scene.plane = test::plane_through(target->second, {0, 0, 1});  // all of them at z = -3.188
    const auto update = Mosaicker{Config{}}.process(test::surface_of(scene, decoded(row[0])));
    ASSERT_TRUE(update.projected);
    ++seen;
    const double gsd = update.grid->ground_sampling_distance;
    const int radius = static_cast<int>(0.03 / gsd);  // the disc's is 0.0224 m
    const auto disc = disc_at(*update.projected, target->second.head<2>(), radius);
    if (!disc) continue;
    ++found;
    worst = std::max(worst, (*disc - target->second.head<2>()).norm() / gsd);
  }
  EXPECT_GE(seen, 10);
  EXPECT_GE(found, seen - 1);
  EXPECT_LT(worst, 0.5);  // the bar is 2; what is left is the disc's own measurement
  std::cout << found << " of " << seen << " targets, at most " << worst
            << " sampling distances off\n";
}

}  // namespace
}  // namespace nadir::mosaic2d

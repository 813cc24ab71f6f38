// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/simulate/write_survey.hpp"

#include <Eigen/Core>
#include <fstream>
#include <opencv2/core/eigen.hpp>
#include <span>

#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"
#include "npz.hpp"
#include "profile.hpp"
#include "text.hpp"

namespace nadir::simulate {
namespace {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError("cannot make the folder " + folder.string() + ": " + error.message() +
                     "; choose another place");
  }
}

void refuse_used(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    throw InputError("the folder " + folder.string() +
                     " is not empty; remove it or choose another");
  }
}

void write(const fs::path& path, std::span<const char> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    throw InputError("cannot write " + path.string() + "; check the disk's space and permissions");
  }
}

void write(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
  write(path, std::span(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void write_texts(const fs::path& folder, const Survey& survey, const Options& options) {
  write(folder / "calib.yml", calibration(*survey.rig()));
  write(folder / "timestamps.csv", timestamps(survey));
  write(folder / "ahrs.csv", attitudes(survey));
  write(folder / "depth.csv", depths(survey));
  write(folder / "README.txt", readme(survey, options));
  write(folder / "gt_poses_tum.txt", poses(survey, options));
  write(folder / "gt_points.csv", points(survey));
  write(folder / "gt_observations.csv", observations(survey));
  if (const auto beams = survey.lasers()) {
    write(folder / "lasers.yml", lasers(*beams));
    write(folder / "gt_laser_dots.csv", dots(survey));
  }
}

void write_height_map(const fs::path& folder, const Survey& survey) {
  const HeightMap map = survey.height_map();
  cv::Mat z_mm, rotation, translation;
  map.z.convertTo(z_mm, CV_16S, 1000);
  cv::eigen2cv(Eigen::Matrix3d(map.survey_from_local.rotation.toRotationMatrix()), rotation);
  cv::eigen2cv(map.survey_from_local.translation, translation);
  const auto scalar = [](double x) { return cv::Mat(1, 1, CV_64F, cv::Scalar(x)); };
  write(folder / "gt_heightmap.npz", npz({{"z_mm", z_mm},
                                          {"x0", scalar(map.x0)},
                                          {"y0", scalar(map.y0)},
                                          {"res", scalar(map.cell)},
                                          {"R_world_local", rotation},
                                          {"t_world_local", translation}}));
}

// First, last and two between.
void write_depth_images(const fs::path& folder, const Survey& survey) {
  make_folder(folder / "gt_depth");
  int before = -1;
  for (int k = 0; k < 4; ++k) {
    const int image = (survey.images() - 1) * k / 3;
    if (image == before) continue;
    before = image;
    cv::Mat millimetres;
    survey.depth(image).convertTo(millimetres, CV_16U, 1000);
    write(folder / "gt_depth" / (survey.name(image) + ".png"),
          image_io::encode_png(millimetres, image_io::PngEffort::small));
  }
}

void write_picture(const fs::path& images, const Survey& survey, int image, int quality) {
  const Picture picture = survey.picture(image);
  const std::string name = survey.name(image) + ".jpg";
  const bool pair = !picture.right.empty();
  write((pair ? images / "left" : images) / name, image_io::encode_jpeg(picture.left, quality));
  if (pair) write(images / "right" / name, image_io::encode_jpeg(picture.right, quality));
}

}  // namespace

void write_survey(const fs::path& folder, const Options& options,
                  const std::function<void(int, int)>& progress) {
  options.check();
  refuse_used(folder);
  make_folder(folder / "images");
  if (options.stereo) {
    make_folder(folder / "images" / "left");
    make_folder(folder / "images" / "right");
  }
  const Survey survey(options);
  write_texts(folder, survey, options);
  write_height_map(folder, survey);
  write_depth_images(folder, survey);
  for (int image = 0; image < survey.images(); ++image) {
    write_picture(folder / "images", survey, image, profile(options.scene).jpeg);
    if (progress) progress(image + 1, survey.images());
  }
}

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A survey folder of small images, made for one test and removed after it.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "nadir/image_io/encode.hpp"

namespace nadir::capture {

class SurveyFolder {
 public:
  static constexpr int kWidth = 50, kHeight = 38;

  SurveyFolder()
      : root_(std::filesystem::temp_directory_path() /
              ("nadir_capture_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
    write("calib.yml", mono_calibration());
  }
  ~SurveyFolder() { std::filesystem::remove_all(root_); }
  SurveyFolder(const SurveyFolder&) = delete;
  SurveyFolder& operator=(const SurveyFolder&) = delete;

  const std::filesystem::path& root() const { return root_; }

  void write(const std::string& name, std::string_view content) const {
    const auto path = root_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
  }
  void write(const std::string& name, const std::vector<std::uint8_t>& content) const {
    write(name, std::string_view(reinterpret_cast<const char*>(content.data()), content.size()));
  }
  /// A uniform PNG or JPEG, by the name's extension.
  void image(const std::string& name, int level = 100, int width = kWidth,
             int height = kHeight) const {
    const cv::Mat picture(height, width, CV_8UC3, cv::Scalar(level, level + 20, level + 40));
    write(name, name.ends_with(".png") ? image_io::encode_png(picture)
                                       : image_io::encode_jpeg(picture, 95));
  }
  /// images/0.png to images/(n - 1).png
  void images(int count) const {
    for (int i = 0; i < count; ++i) image("images/" + std::to_string(i) + ".png");
  }

  static std::string mono_calibration() {
    return R"(%YAML:1.0
---
image_width: 50
image_height: 38
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 40., 0., 24.5, 0., 40., 18.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
)";
  }
  static std::string stereo_calibration() {
    return mono_calibration() + R"(camera_matrix_right: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 41., 0., 24.5, 0., 41., 18.5, 0., 0., 1. ]
distortion_coefficients_right: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.1, 0., 0. ]
)";
  }

 private:
  std::filesystem::path root_;
};

}  // namespace nadir::capture

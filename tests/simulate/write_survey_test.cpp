// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/simulate/write_survey.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>

#include "nadir/core/check.hpp"
#include "nadir/simulate/survey.hpp"

namespace nadir::simulate {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_(fs::temp_directory_path() / (name + "-" + std::to_string(::getpid()))) {
    fs::remove_all(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

Options small(SceneKind scene, bool stereo) {
  Options options;
  options.scene = scene;
  options.images = 3;
  options.stereo = stereo;
  options.image_scale = 0.2;
  return options;
}

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files[fs::relative(entry.path(), folder).string()] =
        std::string(std::istreambuf_iterator<char>(file), {});
  }
  return files;
}

std::vector<std::string> names(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& [name, bytes] : contents(folder)) names.push_back(name);
  return names;
}

TEST(WriteSurvey, WritesAPairWithItsTruth) {
  const Folder folder("simulate-pair");
  int calls = 0;
  write_survey(folder.path(), small(SceneKind::pool, true), [&](int done, int total) {
    EXPECT_EQ(done, ++calls);
    EXPECT_EQ(total, 3);
  });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(
      names(folder.path()),
      (std::vector<std::string>{
          "README.txt", "ahrs.csv", "calib.yml", "depth.csv", "gt_depth/000000.png",
          "gt_depth/000001.png", "gt_depth/000002.png", "gt_heightmap.npz", "gt_observations.csv",
          "gt_points.csv", "gt_poses_tum.txt", "images/left/000000.jpg", "images/left/000001.jpg",
          "images/left/000002.jpg", "images/right/000000.jpg", "images/right/000001.jpg",
          "images/right/000002.jpg", "timestamps.csv"}));
}

TEST(WriteSurvey, WritesTheSameBytesTwice) {
  const Folder first("simulate-first"), second("simulate-second");
  const Options options = small(SceneKind::transect, false);
  write_survey(first.path(), options, {});
  write_survey(second.path(), options, {});
  const auto files = contents(first.path());
  EXPECT_TRUE(files.contains("lasers.yml"));
  EXPECT_TRUE(files.contains("gt_laser_dots.csv"));
  EXPECT_TRUE(files.contains("images/000002.jpg"));
  EXPECT_TRUE(files == contents(second.path()));
}

TEST(WriteSurvey, CalibrationIsReadBackByOpenCv) {
  const Folder folder("simulate-calibration");
  const Options options = small(SceneKind::wreck, true);
  write_survey(folder.path(), options, {});
  const cv::FileStorage file((folder.path() / "calib.yml").string(), cv::FileStorage::READ);
  const Survey survey(options);
  const CameraModel& left = survey.rig()->left;
  const CameraRig::Right& right = *survey.rig()->right;
  cv::Mat1d matrix, distortion, rotation, translation;
  file["camera_matrix_right"] >> matrix;
  file["distortion_coefficients"] >> distortion;
  file["R"] >> rotation;
  file["T"] >> translation;
  EXPECT_EQ(static_cast<int>(file["image_width"]), left.width);
  EXPECT_EQ(matrix(0, 2), right.camera.cx);
  ASSERT_EQ(distortion.size(), cv::Size(5, 1));
  EXPECT_EQ(distortion(0, 4), left.distortion[4]);
  EXPECT_NEAR(rotation(2, 0), right.right_from_left.rotation.toRotationMatrix()(2, 0), 1e-15);
  EXPECT_EQ(translation(0, 0), right.right_from_left.translation.x());
}

TEST(WriteSurvey, RefusesAFolderInUseAndAPlaceItCannotWrite) {
  const Folder folder("simulate-used");
  fs::create_directories(folder.path());
  std::ofstream(folder.path() / "notes.txt") << "mine\n";
  EXPECT_THROW(write_survey(folder.path(), small(SceneKind::pool, false), {}), InputError);
  EXPECT_THROW(write_survey(folder.path() / "notes.txt", small(SceneKind::pool, false), {}),
               InputError);
  EXPECT_THROW(
      write_survey(folder.path() / "notes.txt" / "below", small(SceneKind::pool, false), {}),
      InputError);
  EXPECT_EQ(names(folder.path()), std::vector<std::string>{"notes.txt"});
}

// The true poses and targets judged as if they were an estimate: nothing but rounding is left.
TEST(WriteSurvey, TheJudgeReadsItsTruth) {
  const fs::path judge = fs::path(NADIR_SHARED_DATA) / ".." / "tools" / "evaluate.py";
  if (!fs::exists(judge) || std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) {
    std::puts("not run: no data");
    return;
  }
  const Folder folder("simulate-judged");
  Options options = small(SceneKind::reef, false);
  options.images = 12;
  write_survey(folder.path(), options, {});
  const Survey survey(options);
  const fs::path cloud = folder.path() / "cloud.ply", result = folder.path() / "result.json";
  std::ofstream ply(cloud);
  const cv::Mat1f depth = survey.depth(0);
  ply << "ply\nformat ascii 1.0\nelement vertex " << depth.total()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (int row = 0; row < depth.rows; ++row) {
    for (int column = 0; column < depth.cols; ++column) {
      const Eigen::Vector3d ray = survey.rig()->left.unproject({column, row})->homogeneous();
      ply << (survey.survey_from_camera(0) * (static_cast<double>(depth(row, column)) * ray))
                 .transpose()
          << '\n';
    }
  }
  ply.close();
  const std::string command = "/usr/bin/python3 " + judge.string() + " " + folder.path().string() +
                              " " + (folder.path() / "gt_poses_tum.txt").string() +
                              " --align se3 --ply " + cloud.string() + " --points " +
                              (folder.path() / "gt_points.csv").string() + " --json " +
                              result.string() + " >/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const cv::FileStorage json(result.string(), cv::FileStorage::READ);
  EXPECT_EQ(static_cast<double>(json["posed_percent"]), 100);
  EXPECT_LT(static_cast<double>(json["se3"]["ate_rmse_m"]), 1e-6);
  EXPECT_LT(static_cast<double>(json["targets"]["own_se3"]["rms_m"]), 1e-6);
  EXPECT_LT(static_cast<double>(json["surface_se3"]["median_m"]), 1e-3);
}

}  // namespace
}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Videos made by ffmpeg without loss, so that every pixel is known.
#include "nadir/capture/video_source.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <opencv2/core.hpp>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = SurveyFolder::kWidth, kHeight = SurveyFolder::kHeight, kImages = 30;

// A square of a brightness and place that tell the image's number.
cv::Mat picture(int image) {
  cv::Mat bgr(kHeight, kWidth, CV_8UC3, cv::Scalar(20, 40, 60));
  bgr(cv::Rect(image, 10, 12, 12)).setTo(cv::Scalar(100 + image, 200, 255 - image));
  return bgr;
}

void run(const std::string& command) {
  ASSERT_EQ(system((command + " 2>/dev/null </dev/null").c_str()), 0)
      << command << ": install ffmpeg";
}

/// Where the video lies, for all tests of the program.
class VideoFolder : public testing::Environment {
 public:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("nadir_video_" + std::to_string(getpid()));
    fs::create_directories(root_);
    const fs::path raw_file = root_ / "raw";
    std::ofstream raw(raw_file, std::ios::binary);
    for (int i = 0; i < kImages; ++i) {
      const cv::Mat bgr = picture(i);
      raw.write(reinterpret_cast<const char*>(bgr.data),
                static_cast<std::streamsize>(bgr.total() * bgr.elemSize()));
    }
    raw.close();
    run("ffmpeg -f rawvideo -pix_fmt bgr24 -s " + std::to_string(kWidth) + 'x' +
        std::to_string(kHeight) + " -r 15 -i '" + raw_file.string() +
        "' -c:v ffv1 -pix_fmt bgr0 '" + video().string() + "'");
  }
  void TearDown() override { fs::remove_all(root_); }

  static fs::path video() { return root_ / "dive 1.mkv"; }

 private:
  static inline fs::path root_;
};

const auto* const kVideoFolder = testing::AddGlobalTestEnvironment(new VideoFolder);

fs::path video() { return VideoFolder::video(); }

std::vector<Shot> shots_of(const fs::path& file, const Config& config = {}) {
  const SurveyFolder calibrated;
  VideoSource source(file, calibrated.root() / "calib.yml", config);
  std::vector<Shot> shots;
  while (auto shot = source.next()) shots.push_back(*std::move(shot));
  EXPECT_FALSE(source.next());
  return shots;
}

double difference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

Config every_image() {
  Config config;
  config.rate_hz = 0;
  return config;
}

std::string refusal(const fs::path& file, const fs::path& calibration) {
  try {
    const VideoSource source(file, calibration, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(VideoSource, GivesEveryImageWithItsTime) {
  const std::vector<Shot> shots = shots_of(video(), every_image());
  ASSERT_EQ(shots.size(), std::size_t{kImages});
  for (int i = 0; i < kImages; ++i) {
    const Shot& shot = shots[static_cast<std::size_t>(i)];
    ASSERT_TRUE(shot.frame) << i;
    EXPECT_TRUE(shot.alerts.empty()) << i;
    EXPECT_EQ(shot.image, static_cast<std::uint64_t>(i));
    EXPECT_NEAR(seconds(shot.time), i / 15.0, 0.001);  // the container counts milliseconds
    EXPECT_EQ(difference(shot.frame->colour, picture(i)), 0) << i;
    EXPECT_EQ(shot.frame->time, shot.time);
  }
  EXPECT_EQ(shots[7].name, "dive 1-000007");
}

TEST(VideoSource, TakesImagesAtTheRateAskedFor) {
  Config config;
  config.rate_hz = 5;
  const std::vector<Shot> shots = shots_of(video(), config);
  ASSERT_EQ(shots.size(), std::size_t{kImages / 3});
  for (std::size_t i = 0; i < shots.size(); ++i) {
    EXPECT_NEAR(seconds(shots[i].time), static_cast<double>(i) / 5, 0.001);
    EXPECT_EQ(difference(shots[i].frame->colour, picture(3 * static_cast<int>(i))), 0) << i;
  }
  const SurveyFolder calibrated;
  const VideoSource source(video(), calibrated.root() / "calib.yml", config);
  EXPECT_EQ(source.size(), std::size_t{kImages / 3});
}

TEST(VideoSource, ReducesImagesAndCameraAlike) {
  Config config = every_image();
  config.scale = 0.5;
  const std::vector<Shot> shots = shots_of(video(), config);
  ASSERT_FALSE(shots.empty());
  EXPECT_EQ(shots[0].frame->colour.cols, kWidth / 2);
  EXPECT_EQ(shots[0].frame->rig->left.width, kWidth / 2);
}

TEST(VideoSource, ReadsTheLogsBesideIt) {
  const SurveyFolder folder;
  fs::copy(video(), folder.root() / "dive.mkv");
  folder.write("depth.csv", "seconds,depth\n0,10\n0.4,10.4\n0.8,10.8\n1.2,11.2\n1.6,11.6\n2,12\n");
  VideoSource source(folder.root() / "dive.mkv", {}, {});
  while (const auto shot = source.next()) {
    ASSERT_TRUE(shot->frame->depth);
    EXPECT_NEAR(*shot->frame->depth, 10 + seconds(shot->time), 1e-6);
  }
}

TEST(VideoSource, OfAnotherSizeIsRefusedNamingBoth) {
  const SurveyFolder folder;
  std::string calibration = SurveyFolder::mono_calibration();
  calibration.replace(calibration.find("image_height: 38"), 16, "image_height: 40");
  folder.write("calib.yml", calibration);
  const std::string message = refusal(video(), folder.root() / "calib.yml");
  EXPECT_NE(message.find("is 50 x 38 px"), std::string::npos) << message;
  EXPECT_NE(message.find("for 50 x 40 px"), std::string::npos) << message;
}

TEST(VideoSource, WhatIsNoVideoIsRefused) {
  const SurveyFolder folder;
  folder.write("text.mp4", "no video");
  folder.write("empty.mp4", "");
  for (const char* name : {"text.mp4", "empty.mp4"}) {
    const std::string message = refusal(folder.root() / name, folder.root() / "calib.yml");
    EXPECT_NE(message.find("is no video that ffmpeg can read"), std::string::npos) << message;
  }
}

// A list of videos that names one on another machine: here, a port that would hear of it.
TEST(VideoSource, NothingIsFetchedFromElsewhere) {
  const int server = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(server, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(server, 4), 0);
  ASSERT_EQ(getsockname(server, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const SurveyFolder folder;
  folder.write("list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nhttp://127.0.0.1:" +
                                std::to_string(ntohs(address.sin_port)) +
                                "/x.ts\n#EXT-X-ENDLIST\n");
  EXPECT_NE(refusal(folder.root() / "list.m3u8", folder.root() / "calib.yml"), "");
  EXPECT_EQ(accept(server, nullptr, nullptr), -1);
  EXPECT_EQ(errno, EAGAIN);
  close(server);
}

// Microseconds still count after hours.
TEST(VideoSource, TimesAreExactInALongVideo) {
  const fs::path late = video().parent_path() / "late pts_time:9.mkv";
  run("ffmpeg -i '" + video().string() + "' -c copy -output_ts_offset 20000 '" + late.string() +
      "'");
  const std::vector<Shot> shots = shots_of(late, every_image());
  ASSERT_EQ(shots.size(), std::size_t{kImages});
  for (std::size_t i = 1; i < shots.size(); ++i) {
    EXPECT_TRUE(shots[i].frame) << i;
    EXPECT_NEAR(seconds(shots[i].time - shots[0].time), static_cast<double>(i) / 15, 0.0015) << i;
  }
}

TEST(VideoSource, CutOffGivesTheImagesBeforeTheCut) {
  const fs::path cut = video().parent_path() / "cut.mkv";
  fs::copy(video(), cut);
  fs::resize_file(cut, fs::file_size(cut) / 2);
  const std::vector<Shot> shots = shots_of(cut, every_image());
  EXPECT_GT(shots.size(), std::size_t{kImages / 4});
  EXPECT_LT(shots.size(), std::size_t{kImages});
  for (std::size_t i = 0; i + 1 < shots.size(); ++i)
    EXPECT_EQ(difference(shots[i].frame->colour, picture(static_cast<int>(i))), 0) << i;
}

TEST(VideoSource, LeftInTheMiddleLeavesNoProcess) {
  {
    const SurveyFolder calibrated;
    VideoSource source(video(), calibrated.root() / "calib.yml", every_image());
    EXPECT_TRUE(source.next());
  }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(OpenSurvey, TakesAFolderOrAVideo) {
  const SurveyFolder folder;
  folder.image("images/1.png");
  EXPECT_TRUE(open_survey(video(), folder.root() / "calib.yml", {})->images().empty());
  EXPECT_EQ(open_survey(folder.root(), {}, {})->images().size(), 1u);
}

}  // namespace
}  // namespace nadir::capture

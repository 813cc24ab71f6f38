// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The whole program on the rendered and real sequences, where they are at hand: what each must
// reach with the defaults.
#include <gtest/gtest.h>

#include <iostream>
#include <opencv2/imgproc.hpp>
#include <set>

#include "nadir/core/tile.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/header.hpp"
#include "support/dive_folder.hpp"

namespace nadir {
namespace {

using namespace support;

const fs::path kData = NADIR_SHARED_DATA;

struct Dive {
  fs::path survey, folder;
  nlohmann::json json;
};

// None where all data are absent; a sequence that is missing among others, or a replay that fails,
// is a failed test.
std::optional<Dive> dive_of(const std::string& sequence) {
  static std::map<std::string, Dive> made;
  if (!fs::exists(kData)) {
    std::cout << "not run: no data\n";
    return std::nullopt;
  }
  Dive& dive = made[sequence];
  if (!dive.folder.empty()) return dive;
  const std::string name = fs::path(sequence).filename();
  dive = {kData / sequence, fresh_folder(name), {}};
  const fs::path log = fresh_folder(name + ".log");
  const int status = run(std::string("'" NADIR_PROGRAM "' replay '") + dive.survey.string() +
                             "' --out '" + dive.folder.string() + "'",
                         log);
  EXPECT_EQ(status, 0) << contents(log);
  dive.json = dive_json(dive.folder);
  return dive;
}

int longest_submap(const nlohmann::json& dive) {
  int longest = 0;
  for (const auto& submap : dive["submaps"]) {
    longest =
        std::max(longest, submap["last_image"].get<int>() - submap["first_image"].get<int>() + 1);
  }
  return longest;
}

int oriented_in_submaps_of_five(const Dive& dive) {
  std::map<std::string, int> oriented;
  for (const auto& row : rows_of(dive.folder / "health.csv")) {
    if (row.at(4) == "1") ++oriented[row.at(5)];
  }
  int sum = 0;
  for (const auto& [submap, count] : oriented) sum += count >= 5 ? count : 0;
  return sum;
}

using Ranges = std::vector<std::pair<int, int>>;  // of images, first and last

Fit fit_of(const Dive& dive, bool free_scale, const Ranges& ranges = {}) {
  return fit(dive.folder / "trajectory.tum", dive.survey / "gt_poses_tum.txt", free_scale, ranges);
}

std::vector<int> images_lost_at(const Dive& dive) {
  std::vector<int> images;
  std::istringstream lines(contents(dive.folder / "alerts.jsonl"));
  for (std::string line; std::getline(lines, line);) {
    const auto alert = nlohmann::json::parse(line);
    if (alert["kind"] == "tracking_lost") images.push_back(alert["image"]);
  }
  return images;
}

struct Rendered {
  std::string name;
  int least_oriented;
  std::string scale;  ///< its source
  double rmse;        ///< metres, after rotation and translation, and scale where nothing gives it
  double rmse_free;   ///< after scale, too
  double scale_error;
  int least_windows;
  double least_planes;  ///< share of the windows
};

class RenderedSequence : public testing::TestWithParam<Rendered> {};

INSTANTIATE_TEST_SUITE_P(
    All, RenderedSequence,
    testing::Values(Rendered{"pool", 81, "stereo", 0.005, 0.005, 6e-4, 70, 0.95},
                    Rendered{"wreck", 40, "stereo", 0.0011, 0.0011, 5e-4, 20, 0},
                    Rendered{"transect", 159, "laser", 0.03, 0.003, 8e-3, 20, 0.8},
                    Rendered{"reef", 99, "none", 0.015, 0.015, 1e9, 20, 0}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(RenderedSequence, IsOrientedWholeAndExact) {
  const Rendered& expected = GetParam();
  const auto dive = dive_of("rendered/" + expected.name);
  if (!dive) return;
  const auto& counts = dive->json["counts"];
  EXPECT_GE(counts["oriented"], expected.least_oriented);
  EXPECT_EQ(dive->json["scale"]["source"], expected.scale);
  EXPECT_EQ(dive->json["submaps"].size(), 1u);
  const Fit with_scale = fit_of(*dive, true);
  EXPECT_LT(with_scale.rmse, expected.rmse_free);
  EXPECT_LT(fit_of(*dive, expected.scale == "none").rmse, expected.rmse);
  EXPECT_LT(std::abs(with_scale.scale - 1), expected.scale_error);
  if (expected.scale != "none") {
    const double sigma = dive->json["scale"]["sigma"];
    EXPECT_LT(std::abs(with_scale.scale - 1), 2 * sigma);
  }
  EXPECT_GE(counts["windows"], expected.least_windows);
  EXPECT_GE(counts["planes"].get<double>(),
            expected.least_planes * counts["windows"].get<double>());
}

// The share of consecutive images whose relative pose is as well known as the table of health says.
TEST_P(RenderedSequence, KnowsHowWellItKnowsEachStep) {
  const auto dive = dive_of("rendered/" + GetParam().name);
  if (!dive) return;
  const auto found = poses(dive->folder / "trajectory.tum");
  const auto exact = poses(dive->survey / "gt_poses_tum.txt");
  const double scale = GetParam().scale == "none" ? 1 / fit_of(*dive, true).scale : 1;
  std::map<long, std::pair<double, double>> sigmas;  // position and rotation, by time
  for (const auto& row : rows_of(dive->folder / "health.csv")) {
    if (row.at(15).empty()) continue;
    sigmas[std::lround(1000 * std::stod(row[2]))] = {std::stod(row[15]), std::stod(row[16])};
  }
  ASSERT_GE(found.size(), static_cast<std::size_t>(GetParam().least_oriented));
  int steps = 0, position_within = 0, rotation_within = 0;
  double position_squares = 0, rotation_squares = 0;  // of errors in sigmas
  for (auto before = found.begin(), now = std::next(before); now != found.end(); ++before, ++now) {
    const auto sigma = sigmas.find(now->first);
    if (sigma == sigmas.end()) continue;
    const Eigen::Isometry3d step = before->second.inverse() * now->second;
    const Eigen::Isometry3d truth = exact.at(before->first).inverse() * exact.at(now->first);
    const double error = (scale * step.translation() - truth.translation()).norm();
    const double turn = Eigen::AngleAxisd(step.linear().transpose() * truth.linear()).angle();
    const double position = error / (scale * sigma->second.first);
    const double rotation = turn * 180 / M_PI / sigma->second.second;
    ++steps;
    position_within += position < 2;
    rotation_within += rotation < 2;
    position_squares += position * position;
    rotation_squares += rotation * rotation;
  }
  EXPECT_GE(steps + 1, GetParam().least_oriented);
  EXPECT_GE(position_within, 0.85 * steps) << "of " << steps;
  EXPECT_GE(rotation_within, 0.85 * steps) << "of " << steps;
  // They are 1 on average; a quarter would be sigmas twice too large.
  EXPECT_GT(position_squares, 0.25 * steps);
  EXPECT_GT(rotation_squares, 0.25 * steps);
}

TEST(FailureSequence, JumpIsNoticedAndBothSidesAreMapped) {
  const auto dive = dive_of("rendered/failure_jump");
  if (!dive) return;
  EXPECT_EQ(dive->json["counts"]["oriented"], 40);
  EXPECT_EQ(dive->json["submaps"].size(), 2u);
  for (const auto& submap : dive->json["submaps"]) EXPECT_TRUE(submap["joined"].is_null());
  ASSERT_EQ(images_lost_at(*dive).size(), 1u);
  EXPECT_NEAR(images_lost_at(*dive)[0], 20, 1);
  EXPECT_LT(fit_of(*dive, false, {{0, 19}}).rmse, 0.02);
  EXPECT_LT(fit_of(*dive, false, {{20, 39}}).rmse, 0.02);
}

TEST(FailureSequence, BlindedImagesAreLostAndTheRestIsOriented) {
  const auto dive = dive_of("rendered/failure_blank");
  if (!dive) return;
  EXPECT_EQ(dive->json["counts"]["oriented"], 28);
  EXPECT_EQ(dive->json["submaps"].size(), 1u);
  EXPECT_NE(contents(dive->folder / "alerts.jsonl").find("blank image"), std::string::npos);
  ASSERT_EQ(images_lost_at(*dive).size(), 1u);
  EXPECT_NEAR(images_lost_at(*dive)[0], 14, 1);
  EXPECT_LT(fit_of(*dive, false, {{0, 13}, {26, 39}}).rmse, 0.02);
}

TEST(FailureSequence, ReturnIsOrientedWholeAndJoined) {
  const auto dive = dive_of("rendered/failure_return");
  if (!dive) return;
  EXPECT_EQ(dive->json["counts"]["oriented"], 60);
  const auto& submaps = dive->json["submaps"];
  ASSERT_EQ(submaps.size(), 3u);
  EXPECT_TRUE(submaps[1]["joined"].is_null());
  EXPECT_EQ(submaps[2]["first_image"], 40);
  EXPECT_EQ(submaps[2]["joined"], 0);
  EXPECT_FALSE(submaps[2]["uncertain"]);
  ASSERT_EQ(images_lost_at(*dive).size(), 2u);
  EXPECT_NEAR(images_lost_at(*dive)[0], 20, 1);
  EXPECT_NEAR(images_lost_at(*dive)[1], 40, 1);
  EXPECT_LT(fit_of(*dive, false, {{0, 19}, {40, 59}}).rmse, 0.02);
  EXPECT_LT(fit_of(*dive, false, {{20, 39}}).rmse, 0.02);
}

struct Real {
  std::string name;
  int least_oriented;
  bool one_map;
};

class RealSequence : public testing::TestWithParam<Real> {};

INSTANTIATE_TEST_SUITE_P(
    All, RealSequence,
    testing::Values(Real{"seabed-strip-1", 8, true}, Real{"seabed-strip-3", 8, true},
                    Real{"seabed-strip-5", 8, true}, Real{"seabed-strip-7", 8, true},
                    Real{"seabed-strip-9", 8, true}, Real{"wreck-jason", 100, false},
                    Real{"amphora-20fps", 80, false}, Real{"cave-sparus", 20, false},
                    Real{"beach-aerial", 30, false}),
    [](const auto& tested) {
      std::string name = tested.param.name;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

TEST_P(RealSequence, IsOriented) {
  const auto dive = dive_of("real/" + GetParam().name);
  if (!dive) return;
  EXPECT_GE(dive->json["counts"]["oriented"], GetParam().least_oriented);
  if (GetParam().one_map) {
    EXPECT_EQ(longest_submap(dive->json), 8);
  }
  EXPECT_GE(oriented_in_submaps_of_five(*dive), GetParam().least_oriented);
}

TEST(OpenWater, RaisesTheAlertAndMakesNoMap) {
  const auto dive = dive_of("real/open-water");
  if (!dive) return;
  EXPECT_EQ(dive->json["counts"]["oriented"], 0);
  EXPECT_EQ(dive->json["submaps"].size(), 0u);
  EXPECT_NE(contents(dive->folder / "alerts.jsonl").find("blank image"), std::string::npos);
}

// --- the pool's targets through the world files
// -----------------------------------------------------------------

WorldFile world_file(const fs::path& file) {
  WorldFile world;
  std::istringstream(contents(file)) >> world.a >> world.d >> world.b >> world.e >> world.c >>
      world.f;
  return world;
}

cv::Mat grey_png(const fs::path& file) {
  const std::string bytes = contents(file);
  const std::span<const std::uint8_t> span(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                           bytes.size());
  const auto header = image_io::read_header(span).header;
  if (!header) return {};
  return image_io::decode(span, header->width, header->height, 1, image_io::Colour::grey).image;
}

// Centre of the white disc nearest to a place, on the raster; none where the image ends.
std::optional<Eigen::Vector2d> disc_near(const cv::Mat& grey, const Eigen::Vector2d& place,
                                         int reach) {
  const cv::Rect around(static_cast<int>(std::lround(place.x())) - reach,
                        static_cast<int>(std::lround(place.y())) - reach, 2 * reach + 1,
                        2 * reach + 1);
  if ((around & cv::Rect({0, 0}, grey.size())) != around) return std::nullopt;
  cv::Mat white, labels, statistics, centres;
  double least = 0, most = 0;
  cv::minMaxLoc(grey(around), &least, &most);
  if (least == 0) return std::nullopt;  // beyond the image's edge
  cv::threshold(grey(around), white, (least + most) / 2, 255, cv::THRESH_BINARY);
  cv::connectedComponentsWithStats(white, labels, statistics, centres, 4);
  const int disc = labels.at<int>(reach, reach);
  if (disc == 0) return std::nullopt;
  return Eigen::Vector2d(around.x + centres.at<double>(disc, 0),
                         around.y + centres.at<double>(disc, 1));
}

Eigen::Matrix4d survey_from_truth(const Dive& dive) {
  const auto estimated = positions(dive.folder / "trajectory.tum"),
             exact = positions(dive.survey / "gt_poses_tum.txt");
  Eigen::Matrix3Xd from(3, estimated.size()), to(3, estimated.size());
  Eigen::Index i = 0;
  for (const auto& [time, x] : estimated) {
    from.col(i) = exact.at(time);
    to.col(i++) = x;
  }
  return Eigen::umeyama(from, to, false);
}

// The strip is nearly straight, so a rigid alignment of the positions alone leaves the roll about
// it free within the noise: over the strip's half width of 1 m that is the largest part of the 2
// cm.
TEST(PoolTargets, LieWithinTwoCentimetresThroughTheWorldFiles) {
  const auto dive = dive_of("rendered/pool");
  if (!dive) return;
  const Eigen::Matrix4d alignment = survey_from_truth(*dive);
  std::map<std::string, Eigen::Vector3d> targets;
  for (const auto& row : rows_of(dive->survey / "gt_points.csv")) {
    if (row.at(3) == "-3.188000")
      targets[row[0]] = {std::stod(row[1]), std::stod(row[2]), std::stod(row[3])};
  }
  int found = 0;
  double worst = 0;
  for (const auto& row : rows_of(dive->survey / "gt_observations.csv")) {
    const auto target = targets.find(row.at(2));
    const fs::path image = dive->folder / "projected" / (row[0] + ".png");
    if (row[1] != "left" || target == targets.end() || !fs::exists(image)) continue;
    const WorldFile world = world_file(fs::path(image).replace_extension(".pgw"));
    const Eigen::Vector3d expected = (alignment * target->second.homogeneous()).head<3>();
    const Eigen::Vector2d place((expected.x() - world.c) / world.a,
                                (expected.y() - world.f) / world.e);
    const auto disc = disc_near(grey_png(image), place,
                                static_cast<int>(0.03 / world.a));  // the disc's radius: 0.0224 m
    if (!disc) continue;
    ++found;
    worst = std::max(worst, (world(disc->x(), disc->y()) - expected.head<2>()).norm());
  }
  EXPECT_GE(found, 20);
  EXPECT_LT(worst, 0.02);
  std::cout << found << " sightings, at most " << 100 * worst << " cm off\n";
}

struct Verdict {
  int status = 0;
  std::string text;
};

Verdict check_calibration(const fs::path& survey, const fs::path& calibration) {
  const fs::path log = fresh_folder("check.log");
  const int status = run(std::string("'" NADIR_PROGRAM "' check-calibration '") + survey.string() +
                             "' --calib '" + calibration.string() + "'",
                         log);
  return {status, contents(log)};
}

TEST(CheckCalibration, TrueOnesFitAndPoolWithoutK3IsDoubted) {
  if (!fs::exists(kData)) {
    std::cout << "not run: no data\n";
    return;
  }
  for (const char* name : {"pool", "transect"}) {
    const fs::path survey = kData / "rendered" / name;
    const Verdict verdict = check_calibration(survey, survey / "calib.yml");
    EXPECT_EQ(verdict.status, 0) << verdict.text;
  }
  std::string calibration = contents(kData / "rendered/pool/calib.yml");
  for (const char* k3 : {"-1.4999999999999999e-02", "-1.9000000000000000e-02"}) {
    const auto at = calibration.find(k3);
    ASSERT_NE(at, std::string::npos) << k3;
    calibration.replace(at, std::string(k3).size(), "0.");
  }
  const fs::path without_k3 = fresh_folder("without_k3.yml");
  std::ofstream(without_k3) << calibration;
  const Verdict verdict = check_calibration(kData / "rendered/pool", without_k3);
  EXPECT_EQ(verdict.status, 1) << verdict.text;
  EXPECT_NE(verdict.text.find("left camera: the distortion is off"), std::string::npos)
      << verdict.text;
  EXPECT_NE(verdict.text.find("right camera: the distortion is off"), std::string::npos);
}

}  // namespace
}  // namespace nadir

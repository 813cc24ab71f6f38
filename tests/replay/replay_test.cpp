// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The whole program on simulated surveys, judged by their truth.
#include <gtest/gtest.h>
#include <signal.h>

#include <iomanip>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "nadir/simulate/write_survey.hpp"
#include "support/dive_folder.hpp"

namespace nadir {
namespace {

using namespace support;

const std::string kNadir = NADIR_PROGRAM;

// Surveys are rendered once for all tests of this program.
const fs::path& survey(simulate::SceneKind scene, bool stereo, int images) {
  static std::map<std::tuple<simulate::SceneKind, bool, int>, fs::path> made;
  fs::path& folder = made[{scene, stereo, images}];
  if (folder.empty()) {
    cv::setNumThreads(1);  // the thread sanitizer does not see how TBB synchronises
    folder = fresh_folder("survey-" + std::to_string(made.size()));
    simulate::Options options;
    options.scene = scene;
    options.stereo = stereo;
    options.images = images;
    options.image_scale = 0.5;
    simulate::write_survey(folder, options, {});
  }
  return folder;
}

const fs::path& pool() { return survey(simulate::SceneKind::pool, true, 12); }
const fs::path& reef() { return survey(simulate::SceneKind::reef, false, 10); }

struct Dive {
  fs::path folder, log;
  int status;
};

Dive replay(const fs::path& folder, const std::string& name, const std::string& options = "") {
  Dive dive{fresh_folder(name), fresh_folder(name + ".log"), 0};
  dive.status = run("'" + kNadir + "' replay '" + folder.string() + "' --out '" +
                        dive.folder.string() + "' " + options,
                    dive.log);
  return dive;
}

void expect_counts_add_up(const nlohmann::json& dive) {
  const auto& counts = dive["counts"];
  std::uint64_t dropped = 0;
  for (const auto& [cause, count] : counts["dropped"].items())
    dropped += count.get<std::uint64_t>();
  EXPECT_EQ(counts["captured"].get<std::uint64_t>(),
            counts["oriented"].get<std::uint64_t>() + counts["lost"].get<std::uint64_t>() + dropped)
      << counts;
  EXPECT_EQ(counts["dropped"]["storage"], 0) << "an image is missing that nobody gave up";
}

TEST(Replay, StereoSurveyIsMappedInMetres) {
  const Dive dive = replay(pool(), "pool");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  expect_counts_add_up(json);
  EXPECT_EQ(json["counts"]["oriented"], 12);
  EXPECT_GE(json["counts"]["planes"], 8);
  EXPECT_EQ(json["scale"]["source"], "stereo");
  EXPECT_EQ(json["survey_axes"], "attitude");
  const Fit rigid = fit(dive.folder / "trajectory.tum", pool() / "gt_poses_tum.txt", false);
  EXPECT_EQ(rigid.images, 12u);
  EXPECT_LT(rigid.rmse,
            0.02);  // half-size images: twice the noise of the full ones, on a path of 3 m
}

// Metres east and north of the first image, from latitudes and longitudes.
std::vector<Eigen::Vector2d> east_north_of(const fs::path& track) {
  constexpr double kDegree = M_PI / 180, kAxis = 6'378'137, kEccentricity2 = 0.00669437999;
  std::vector<Eigen::Vector2d> places;
  for (const auto& row : rows_of(track))
    places.emplace_back(std::stod(row.at(6)) * kDegree, std::stod(row.at(5)) * kDegree);
  if (places.empty()) return places;
  const Eigen::Vector2d first = places.front();
  const double sine = std::sin(first.y());
  const double w = std::sqrt(1 - kEccentricity2 * sine * sine);
  for (Eigen::Vector2d& place : places) {
    const Eigen::Vector2d way = place - first;
    place = {way.x() * kAxis / w * std::cos(first.y()),
             way.y() * kAxis * (1 - kEccentricity2) / (w * w * w)};
  }
  return places;
}

// The grid's north is 5 degrees west of true north here, and yet every image lies in its direction
// from the first.
TEST(Replay, WithAnOriginTheMapIsOnTheUtmGridAndTrueOnTheEarth) {
  const Dive plain = replay(pool(), "plain"),
             dive = replay(pool(), "utm", "--set reference.origin='60.4 3.2'");
  ASSERT_EQ(plain.status, 0) << contents(plain.log);
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  EXPECT_EQ(contents(dive.folder / "alerts.jsonl"), contents(plain.folder / "alerts.jsonl"));
  const auto json = dive_json(dive.folder);
  EXPECT_EQ(json["origin"]["placed"], true);
  EXPECT_EQ(json["origin"]["epsg"], 32632);
  EXPECT_FALSE(dive_json(plain.folder).contains("origin"));
  EXPECT_FALSE(fs::exists(plain.folder / "track.csv"));

  std::vector<Eigen::Vector2d> expected;
  for (const auto& [ms, pose] : poses(plain.folder / "trajectory.tum"))
    expected.push_back(pose.translation().head<2>());
  const std::vector<Eigen::Vector2d> track = east_north_of(dive.folder / "track.csv");
  ASSERT_EQ(track.size(), 12u);
  ASSERT_EQ(expected.size(), 12u);
  EXPECT_GT((expected.back() - expected.front()).norm(), 1);
  // Turned axes round otherwise, and robust choices may fall otherwise; 5 degrees would be 9 cm a
  // metre.
  for (std::size_t i = 0; i < track.size(); ++i)
    EXPECT_LT((track[i] - (expected[i] - expected[0])).norm(), 0.01) << i;

  // The mosaics lie around the origin, on the grid.
  std::ifstream world(dive.folder / "mosaic2d" / "mosaic-000.pgw");
  double a = 0, d = 0, b = 0, e = 0, easting = 0, northing = 0;
  ASSERT_TRUE(world >> a >> d >> b >> e >> easting >> northing);
  EXPECT_NEAR(easting, json["origin"]["easting_m"].get<double>(), 10);
  EXPECT_NEAR(northing, json["origin"]["northing_m"].get<double>(), 10);
  EXPECT_NE(contents(dive.folder / "mosaic2d" / "mosaic-000.png.aux.xml").find("UTM zone 32N"),
            std::string::npos);

  // And so they are once recovered.
  const fs::path again = fresh_folder("utm-recovered");
  fs::copy(dive.folder, again, fs::copy_options::recursive);
  for (const char* name : {"dive.json", "track.csv", "mosaic2d/mosaic-000.pgw"})
    fs::remove(again / name);
  ASSERT_EQ(run("'" + kNadir + "' recover '" + again.string() + "'", fresh_folder("recover.log")),
            0);
  for (const char* name : {"track.csv", "mosaic2d/mosaic-000.pgw"})
    EXPECT_EQ(contents(again / name), contents(dive.folder / name)) << name;
  EXPECT_EQ(dive_json(again)["origin"], json["origin"]);
}

TEST(Replay, WindowsOfOtherLengthsMapAsWell) {
  for (const int window : {3, 10}) {
    const std::string of = std::to_string(window);
    const Dive dive = replay(pool(), "window-" + of, "--set odometry.window=" + of);
    ASSERT_EQ(dive.status, 0) << contents(dive.log);
    const auto json = dive_json(dive.folder);
    expect_counts_add_up(json);
    EXPECT_EQ(json["counts"]["oriented"], 12) << window;
    EXPECT_EQ(json["scale"]["source"], "stereo") << window;
    const Fit rigid = fit(dive.folder / "trajectory.tum", pool() / "gt_poses_tum.txt", false);
    EXPECT_EQ(rigid.images, 12u) << window;
    EXPECT_LT(rigid.rmse, 0.02) << window;  // as with the default one
  }
}

TEST(Replay, MonoSurveyIsMappedUnscaledAndSaysSo) {
  const fs::path without_depth = fresh_folder("without_depth");
  fs::copy(reef(), without_depth, fs::copy_options::recursive);
  fs::remove(without_depth / "depth.csv");
  const Dive dive = replay(without_depth, "reef");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  expect_counts_add_up(json);
  EXPECT_EQ(json["counts"]["oriented"], 10);
  EXPECT_EQ(json["scale"]["source"], "none");
  const Fit similar = fit(dive.folder / "trajectory.tum", reef() / "gt_poses_tum.txt", true);
  EXPECT_LT(similar.rmse, 0.05);
  EXPECT_NE(contents(dive.folder / "sparse.ply").find("unscaled"), std::string::npos);
  EXPECT_NE(contents(dive.folder / "projection3d.ply").find("unscaled"), std::string::npos);
}

TEST(Replay, TwiceGivesTheSameBytes) {
  const Dive first = replay(pool(), "first"), second = replay(pool(), "second");
  auto a = all_files(first.folder), b = all_files(second.folder);
  auto json_a = nlohmann::json::parse(a["dive.json"]),
       json_b = nlohmann::json::parse(b["dive.json"]);
  json_a.erase("rates");
  json_b.erase("rates");
  EXPECT_EQ(json_a, json_b);
  a.erase("dive.json");
  b.erase("dive.json");
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) EXPECT_TRUE(bytes == b[name]) << name << " differs";
}

// By line: printed poses are equal up to the last digit.
void expect_equal_trajectories(const fs::path& one, const fs::path& other) {
  std::ifstream a(one), b(other);
  for (std::string line_a, line_b; std::getline(a, line_a);) {
    ASSERT_TRUE(std::getline(b, line_b));
    if (line_a.starts_with('#')) continue;
    std::istringstream values_a(line_a), values_b(line_b);
    for (double x = 0, y = 0; values_a >> x;) {
      ASSERT_TRUE(values_b >> y);
      EXPECT_NEAR(x, y, 2e-6) << line_a << '\n' << line_b;
    }
  }
}

TEST(Replay, GivenPosesReplaceOdometryAndAllElseIsMapped) {
  const Dive own = replay(pool(), "own");
  ASSERT_EQ(own.status, 0) << contents(own.log);
  const fs::path tum = own.folder / "trajectory.tum";
  const Dive given = replay(pool(), "given", "--poses '" + tum.string() + "'");
  ASSERT_EQ(given.status, 0) << contents(given.log);
  expect_equal_trajectories(tum, given.folder / "trajectory.tum");
  const auto json = dive_json(given.folder);
  expect_counts_add_up(json);
  EXPECT_EQ(json["counts"]["oriented"], 12);
  EXPECT_GE(json["counts"]["planes"], 8);
  EXPECT_EQ(json["engine"], "poses " + tum.string());
  EXPECT_EQ(json["scale"]["source"], "poses");
  EXPECT_EQ(json["survey_axes"], "poses");
  EXPECT_EQ(dive_json(own.folder)["engine"], "odometry");
  EXPECT_TRUE(fs::exists(given.folder / "mosaic2d" / "mosaic-000.png"));
  EXPECT_GT(fs::file_size(given.folder / "projection3d.ply"), 100'000u);
  EXPECT_EQ(contents(given.folder / "alerts.jsonl"), contents(own.folder / "alerts.jsonl"));
}

// A COLMAP text model of the true poses in a frame of another origin, axes and unit.
fs::path colmap_model(const fs::path& survey, const std::string& name) {
  fs::path model = fresh_folder(name);
  fs::create_directories(model);
  std::ifstream truth(survey / "gt_poses_tum.txt");
  std::ofstream images(model / "images.txt");
  images.precision(12);
  const Eigen::Quaterniond turn(0.5, -0.5, 0.5, 0.5);
  int id = 0;
  for (std::string line; std::getline(truth, line);) {
    double t = 0;
    Eigen::Vector3d x;
    Eigen::Quaterniond q;
    if (!(std::istringstream(line) >> t >> x.x() >> x.y() >> x.z() >> q.x() >> q.y() >> q.z() >>
          q.w()))
      continue;
    const Eigen::Quaterniond back = (turn * q).conjugate();
    const Eigen::Vector3d shift = -(back * (0.3 * (turn * x) + Eigen::Vector3d(1, 2, 3)));
    std::array<char, 16> number{};
    std::snprintf(number.data(), number.size(), "%06d", id++);
    images << id << ' ' << back.w() << ' ' << back.vec().transpose() << ' ' << shift.transpose()
           << " 1 left/" << number.data() << ".jpg\n\n";
  }
  return model;
}

TEST(Replay, ColmapModelOfPairsIsMappedInMetres) {
  const Dive dive =
      replay(pool(), "colmap", "--colmap '" + colmap_model(pool(), "model").string() + "'");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  expect_counts_add_up(json);
  EXPECT_EQ(json["counts"]["oriented"], 12);
  EXPECT_GE(json["counts"]["planes"], 8);
  EXPECT_EQ(json["scale"]["source"], "stereo");
  EXPECT_EQ(json["survey_axes"], "attitude");
  // The poses are exact, the pair of half-size images tells the scale.
  EXPECT_LT(fit(dive.folder / "trajectory.tum", pool() / "gt_poses_tum.txt", true).rmse, 1e-4);
  const Fit rigid = fit(dive.folder / "trajectory.tum", pool() / "gt_poses_tum.txt", false);
  EXPECT_LT(rigid.rmse, 0.01);
}

TEST(Replay, ColmapModelOfSingleImagesIsMappedUnscaled) {
  const Dive dive =
      replay(reef(), "colmap-mono", "--colmap '" + colmap_model(reef(), "model").string() + "'");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  EXPECT_EQ(json["counts"]["oriented"], 10);
  EXPECT_EQ(json["scale"]["source"], "none");
  EXPECT_LT(fit(dive.folder / "trajectory.tum", reef() / "gt_poses_tum.txt", true).rmse, 1e-4);
}

TEST(Replay, PosesThatCannotBeReadAreRefusedBeforeTheDive) {
  const fs::path file = fresh_folder("poses.tum");
  std::ofstream(file) << "0 1 2 3 one 0 0 0\n";
  const Dive malformed = replay(reef(), "malformed", "--poses '" + file.string() + "'");
  EXPECT_EQ(malformed.status, 1);
  EXPECT_NE(contents(malformed.log).find(file.string() + ":1:"), std::string::npos);
  EXPECT_FALSE(fs::exists(malformed.folder));
  EXPECT_EQ(replay(reef(), "both", "--poses a.tum --colmap b").status, 2);
}

bool alerts_of(const Dive& dive, const std::string& kind) {
  return contents(dive.folder / "alerts.jsonl").find('"' + kind + '"') != std::string::npos;
}

TEST(Replay, LasersGiveASingleCameraItsScale) {
  const fs::path& folder = survey(simulate::SceneKind::transect, false, 14);
  const Dive dive = replay(folder, "lasers");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  EXPECT_EQ(json["scale"]["source"], "laser");
  EXPECT_EQ(json["survey_unit"], "metres");
  const double sigma = json["scale"]["sigma"].get<double>();
  EXPECT_LT(sigma, 0.02);
  const Fit free = fit(dive.folder / "trajectory.tum", folder / "gt_poses_tum.txt", true);
  EXPECT_NEAR(free.scale, 1, 3 * sigma);
  EXPECT_FALSE(alerts_of(dive, "scale_conflict"));
}

// The left images of the pool and what the vehicle knows of its attitude.
fs::path single_camera(const std::string& name) {
  fs::path folder = fresh_folder(name);
  fs::create_directories(folder);
  fs::copy(pool() / "images" / "left", folder / "images");
  for (const char* file : {"calib.yml", "timestamps.csv", "ahrs.csv"}) {
    fs::copy(pool() / file, folder / file);
  }
  return folder;
}

// As good as it says, which is better than useless.
void expect_scaled_by(const std::string& source, const Dive& dive, const fs::path& survey) {
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  EXPECT_EQ(json["counts"]["lost"], 0);
  EXPECT_EQ(json["scale"]["source"], source);
  EXPECT_EQ(json["survey_unit"], "metres");
  ASSERT_TRUE(json["scale"]["sigma"].is_number());
  const double sigma = json["scale"]["sigma"].get<double>();
  EXPECT_GT(sigma, 0);
  EXPECT_LT(sigma, 0.05);
  const Fit free = fit(dive.folder / "trajectory.tum", survey / "gt_poses_tum.txt", true);
  EXPECT_NEAR(free.scale, 1, 3 * sigma);
  EXPECT_FALSE(alerts_of(dive, "scale_conflict"));
}

constexpr double kPoolFloor = -3.4;  // its relief: 8 mm

// Between the centres of the plates farthest apart in an image of the left camera. A plate on a box
// stands above the surface that is laid through the tie points around it.
std::string length_between_plates() {
  std::map<std::string, Eigen::Vector3d> plates;
  for (const auto& row : rows_of(pool() / "gt_points.csv")) {
    const Eigen::Vector3d x(std::stod(row.at(1)), std::stod(row.at(2)), std::stod(row.at(3)));
    if (std::abs(x.z() - kPoolFloor) < 0.02) plates[row.at(0)] = x;
  }
  struct Seen {
    std::string image, plate;
    Eigen::Vector2d pixel;
  };
  std::vector<Seen> seen;
  for (const auto& row : rows_of(pool() / "gt_observations.csv")) {
    if (row.at(1) != "left" || !plates.contains(row.at(2))) continue;
    seen.push_back({row.at(0), row.at(2), {std::stod(row.at(3)), std::stod(row.at(4))}});
  }
  double longest = 0;
  std::ostringstream text;
  for (const Seen& one : seen) {
    for (const Seen& other : seen) {
      const double apart = (one.pixel - other.pixel).norm();
      if (one.image != other.image || !(apart > longest)) continue;
      longest = apart;
      text.str("");
      text << std::stoi(one.image) << ' ' << one.pixel.transpose() << ' ' << other.pixel.transpose()
           << ' ' << (plates[one.plate] - plates[other.plate]).norm();
    }
  }
  return text.str();
}

TEST(Replay, KnownLengthGivesASingleCameraItsScale) {
  const Dive dive = replay(single_camera("plates"), "typed",
                           "--set reference.known_length=\"" + length_between_plates() + '"');
  expect_scaled_by("typed", dive, pool());
}

// What a sensor says around each image, to the millimetre.
template <class Says>
void write_log(const fs::path& file, const fs::path& survey, Says says) {
  std::ofstream log(file);
  log << "seconds," << file.stem().string() << '\n' << std::fixed << std::setprecision(3);
  for (const auto& [ms, pose] : poses(survey / "gt_poses_tum.txt")) {
    for (const long at : {ms - 100, ms + 100}) {
      log << 1e-3 * static_cast<double>(at) << ',' << says(pose) << '\n';
    }
  }
}

TEST(Replay, AltimeterGivesASingleCameraItsScale) {
  const fs::path folder = single_camera("altimeter");
  write_log(folder / "altitude.csv", pool(), [](const Eigen::Isometry3d& pose) {
    const Eigen::Vector3d beam = pose.linear().col(2);
    return (kPoolFloor - pose.translation().z()) / beam.z();
  });
  expect_scaled_by("altitude", replay(folder, "altitude"), pool());
}

// Of the 0.4 m that the reef rises and falls, the simulated gauge's noise of 10 mm leaves too
// little: here is a better gauge.
TEST(Replay, ChangesOfDepthGiveASingleCameraItsScale) {
  const fs::path folder = fresh_folder("gauge");
  fs::copy(reef(), folder, fs::copy_options::recursive);
  write_log(folder / "depth.csv", reef(),
            [](const Eigen::Isometry3d& pose) { return -pose.translation().z(); });
  expect_scaled_by("depth", replay(folder, "depth"), reef());
}

TEST(Replay, LasersThatContradictThePairRaiseScaleConflict) {
  const fs::path& good = survey(simulate::SceneKind::transect, true, 14);
  EXPECT_FALSE(alerts_of(replay(good, "agreeing"), "scale_conflict"));

  // 110 mm given for 100, in all that says so.
  const fs::path wrong = fresh_folder("wrong-separation");
  fs::copy(good, wrong, fs::copy_options::recursive);
  std::ofstream(wrong / "lasers.yml")
      << "%YAML:1.0\n---\nseparation_m: 0.11\ncolour: green\nparallel_to_optical_axis: 1\n"
         "origins_camera_m: !!opencv-matrix\n   rows: 2\n   cols: 3\n   dt: d\n"
         "   data: [ -0.055, 0.062, 0.09, 0.055, 0.062, 0.09 ]\n";
  const Dive separated = replay(wrong, "separated");
  ASSERT_EQ(separated.status, 0) << contents(separated.log);
  EXPECT_TRUE(alerts_of(separated, "scale_conflict"));
  EXPECT_EQ(dive_json(separated.folder)["scale"]["source"], "stereo");

  // A baseline 5 % too long.
  const fs::path stretched = fresh_folder("wrong-baseline");
  fs::copy(good, stretched, fs::copy_options::recursive);
  std::string calibration = contents(stretched / "calib.yml");
  const auto key = calibration.find("\nT: ");
  ASSERT_NE(key, std::string::npos) << calibration;
  const auto from = calibration.find('[', key) + 1, to = calibration.find(',', from);
  const double along = std::stod(calibration.substr(from, to - from));
  calibration.replace(from, to - from, std::to_string(1.05 * along));
  std::ofstream(stretched / "calib.yml") << calibration;
  const Dive dive = replay(stretched, "stretched");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  EXPECT_TRUE(alerts_of(dive, "scale_conflict"));
}

TEST(Replay, AtAGivenRateCountsWhatItDrops) {
  const Dive dive = replay(pool(), "fast", "--rate 1000");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  expect_counts_add_up(json);
  EXPECT_EQ(json["counts"]["captured"], 12);
  EXPECT_GT(json["counts"]["dropped"]["queue_full"], 0);
  int told = 0;
  std::istringstream alerts(contents(dive.folder / "alerts.jsonl"));
  for (std::string line; std::getline(alerts, line);) {
    const auto alert = nlohmann::json::parse(line);
    if (alert["kind"] == "images_dropped") told += std::stoi(alert["message"].get<std::string>());
  }
  EXPECT_EQ(told, json["counts"]["dropped"]["queue_full"]);
}

TEST(Replay, DamagedImagesAreSkippedByName) {
  const fs::path folder = fresh_folder("damaged");
  fs::copy(reef(), folder, fs::copy_options::recursive);
  const fs::path image = folder / "images" / "000004.jpg";
  ASSERT_TRUE(fs::exists(image));
  fs::resize_file(image, fs::file_size(image) / 2);
  const Dive dive = replay(folder, "damaged-dive");
  ASSERT_EQ(dive.status, 0) << contents(dive.log);
  const auto json = dive_json(dive.folder);
  expect_counts_add_up(json);
  EXPECT_EQ(json["counts"]["dropped"]["image_rejected"], 1);
  EXPECT_NE(contents(dive.folder / "alerts.jsonl").find("000004"), std::string::npos);
}

TEST(Replay, WhatCannotStartExitsWithOneAndSaysWhy) {
  const Dive nothing = replay("/nonexistent", "nothing");
  EXPECT_EQ(nothing.status, 1);
  EXPECT_NE(contents(nothing.log).find("/nonexistent"), std::string::npos);

  Dive taken{fresh_folder("taken"), fresh_folder("taken.log"), 0};
  fs::create_directories(taken.folder);
  std::ofstream(taken.folder / "precious.txt") << "mine";
  taken.status =
      run("'" + kNadir + "' replay '" + pool().string() + "' --out '" + taken.folder.string() + "'",
          taken.log);
  EXPECT_EQ(taken.status, 1);
  EXPECT_EQ(contents(taken.folder / "precious.txt"), "mine");
  EXPECT_EQ(replay(pool(), "wrong", "--set odometry.windo=3").status, 2);
  EXPECT_EQ(replay(pool(), "wrong", "--set odometry.window=1").status, 2);
  EXPECT_EQ(replay(pool(), "wrong", "--serve nowhere:80").status, 2);
  EXPECT_EQ(replay(pool(), "wrong", "--rate never").status, 2);
}

// Ends a replay that is on its way, by a signal, and returns its exit status.
int interrupted(const fs::path& folder, const fs::path& dive, int signal) {
  const pid_t child = fork();
  if (child == 0) {
    const std::string out = dive.string(), in = folder.string();
    if (!std::freopen("/dev/null", "w", stderr)) _exit(126);
    execl(kNadir.c_str(), "nadir", "replay", in.c_str(), "--out", out.c_str(), "--rate", "4",
          nullptr);
    _exit(127);
  }
  // Far enough for some images to be recorded: a second projected image has its world file.
  const auto recorded = [&] {
    std::error_code none_yet;
    return std::count_if(fs::directory_iterator(dive / "projected", none_yet),
                         fs::directory_iterator(),
                         [](const auto& file) { return file.path().extension() == ".pgw"; });
  };
  for (int i = 0; i < 600 && recorded() < 2; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(Replay, TerminationEndsInGoodOrderWithAWholeDive) {
  const fs::path dive = fresh_folder("terminated");
  EXPECT_EQ(interrupted(pool(), dive, SIGTERM), 0);
  const auto json = dive_json(dive);
  expect_counts_add_up(json);
  EXPECT_GE(json["counts"]["oriented"], 3);
}

TEST(Replay, ServingReplayEndsAtTheFirstSignalAfterTheDive) {
  const fs::path dive = fresh_folder("served");
  const std::string out = dive.string(),
                    in = reef().string();  // rendered by this process, not the child
  const pid_t child = fork();
  if (child == 0) {
    if (!std::freopen("/dev/null", "w", stderr)) _exit(126);
    execl(kNadir.c_str(), "nadir", "replay", in.c_str(), "--out", out.c_str(), "--serve",
          "127.0.0.1:0", "--keep-serving", nullptr);
    _exit(127);
  }
  for (int i = 0; i < 2400 && !fs::exists(dive / "dive.json"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  kill(child, SIGTERM);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  // The page's edges take part in the timing, never in the result.
  const Dive unserved = replay(reef(), "unserved", "--set serve.port=0");
  auto a = all_files(dive), b = all_files(unserved.folder);
  a.erase("dive.json");
  b.erase("dive.json");
  EXPECT_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) EXPECT_TRUE(bytes == b[name]) << name << " differs";
}

TEST(Replay, KilledDiveIsMadeWholeByRecover) {
  const fs::path dive = fresh_folder("killed");
  EXPECT_EQ(interrupted(pool(), dive, SIGKILL), -SIGKILL);
  ASSERT_FALSE(fs::exists(dive / "dive.json"));
  EXPECT_EQ(run("'" + kNadir + "' recover '" + dive.string() + "'", fresh_folder("recover.log")),
            0);
  const auto json = dive_json(dive);
  expect_counts_add_up(json);
  EXPECT_GE(json["counts"]["oriented"], 3);
  EXPECT_TRUE(fs::exists(dive / "mosaic2d" / "mosaic-000.png"));
  EXPECT_LT(fit(dive / "trajectory.tum", pool() / "gt_poses_tum.txt", false).rmse, 0.02);
}

struct Verdict {
  int status;
  std::string text;
};

// Of the folder's own calibration with one text replaced by another.
Verdict check_calibration(const fs::path& folder, const std::string& name,
                          const std::string& from = "", const std::string& to = "") {
  std::string calibration = contents(folder / "calib.yml");
  if (!from.empty()) {
    const auto at = calibration.find(from);
    EXPECT_NE(at, std::string::npos) << calibration;
    calibration.replace(at, from.size(), to);
  }
  const fs::path file = fresh_folder(name + ".yml"), log = fresh_folder(name + ".log");
  std::ofstream(file) << calibration;
  const int status = run("'" + kNadir + "' check-calibration '" + folder.string() + "' --calib '" +
                             file.string() + "'",
                         log);
  return {status, contents(log)};
}

// The first number behind a key of the pool's calib.yml, as it is written there.
std::string number_after(const std::string& key) {
  const std::string calibration = contents(pool() / "calib.yml");
  const auto begin = calibration.find('[', calibration.find(key)) + 1;
  const auto end = calibration.find(',', begin);
  return calibration.substr(begin, end - begin);
}

TEST(CheckCalibration, TrueOneFitsAndTellsItsResiduals) {
  const Verdict verdict = check_calibration(pool(), "true");
  EXPECT_EQ(verdict.status, 0) << verdict.text;
  EXPECT_NE(verdict.text.find("12 of 12 images oriented"), std::string::npos) << verdict.text;
  EXPECT_NE(verdict.text.find("the calibration fits these images"), std::string::npos);
  for (const char* told : {"left camera", "right camera", "epipolar residuals", "focal length"}) {
    EXPECT_NE(verdict.text.find(told), std::string::npos) << told;
  }
}

TEST(CheckCalibration, BentLensIsDoubted) {
  const std::string k1 = number_after("distortion_coefficients:");
  const Verdict verdict = check_calibration(pool(), "bent", k1, " 0.0");
  EXPECT_EQ(verdict.status, 1) << verdict.text;
  EXPECT_NE(verdict.text.find("calibration_suspect: left camera: the distortion is off"),
            std::string::npos)
      << verdict.text;
}

TEST(CheckCalibration, AbsurdOneIsRefusedByName) {
  const std::string fx = number_after("camera_matrix:");
  const Verdict verdict = check_calibration(pool(), "absurd", fx, " 12572.0");
  EXPECT_EQ(verdict.status, 1) << verdict.text;
  EXPECT_NE(verdict.text.find("absurd"), std::string::npos) << verdict.text;  // the file's name
  EXPECT_NE(verdict.text.find("focal length"), std::string::npos) << verdict.text;
}

}  // namespace
}  // namespace nadir

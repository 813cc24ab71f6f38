// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Every file of a finished dive, read back by readers that are not the program's own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <clocale>
#include <cstdio>
#include <cstring>
#include <locale>
#include <sstream>

#include "nadir/core/check.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/record/recover.hpp"
#include "record/small_dive.hpp"
#include "support/failing_folder.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;
using std::filesystem::path;

void record_all(const SmallDive& small, const path& folder) {
  Dive dive(folder, small.info(), {});
  for (int i = 0; i < small.images; ++i) {
    ASSERT_TRUE(dive.add(small.entry(static_cast<std::uint64_t>(i))).empty());
  }
  EXPECT_EQ(dive.saved(), static_cast<std::uint64_t>(small.images));
  ASSERT_TRUE(dive.finish({{"images_hz", 2.0}}).empty());
}

struct Recorded {
  explicit Recorded(const SmallDive& small_dive) : small(small_dive) {
    record_all(small, scratch / "dive");
  }
  path operator/(const path& name) const { return scratch / "dive" / name; }
  json dive_json() const { return json::parse(read_text(*this / "dive.json")); }

  SmallDive small;
  ScratchFolder scratch;
};

std::vector<std::vector<double>> rows_of(const path& file) {
  std::vector<std::vector<double>> rows;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    rows.emplace_back();
    for (double value; words >> value;) rows.back().push_back(value);
  }
  return rows;
}

// Binary little-endian PLY with one element, by the format's description.
struct Ply {
  explicit Ply(const path& file) {
    std::istringstream in(read_text(file));
    std::string line, word;
    std::size_t count = 0;
    std::vector<std::string> types;
    while (std::getline(in, line) && line != "end_header") {
      std::istringstream words(line);
      words >> word;
      if (word == "comment") comment += line;
      if (word == "element") words >> word >> count;
      if (word == "property") {
        words >> types.emplace_back() >> names.emplace_back();
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      rows.emplace_back();
      for (const std::string& type : types) rows.back().push_back(number(in, type));
    }
    EXPECT_TRUE(in.good());
    EXPECT_EQ(in.peek(), EOF);
    type_of_x = types.front();
  }

  template <class T>
  static double raw(std::istream& in) {
    T value{};
    in.read(reinterpret_cast<char*>(&value), sizeof value);
    return static_cast<double>(value);
  }
  static double number(std::istream& in, const std::string& type) {
    if (type == "float") return raw<float>(in);
    if (type == "double") return raw<double>(in);
    if (type == "uchar") return raw<std::uint8_t>(in);
    EXPECT_EQ(type, "uint");
    return raw<std::uint32_t>(in);
  }

  std::string comment, type_of_x;
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
};

std::string output_of(const std::string& command) {
  std::string output;
  std::FILE* pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
  if (!pipe) return output;
  char buffer[4096];
  while (const std::size_t size = std::fread(buffer, 1, sizeof buffer, pipe)) {
    output.append(buffer, size);
  }
  ::pclose(pipe);
  return output;
}

TEST(Trajectory, HasOnePoseOfEachOrientedImageToTheNanometreAndNanosecond) {
  SmallDive small;
  small.rejected = 1;
  const Recorded dive(small);
  const auto rows = rows_of(dive / "trajectory.tum");
  ASSERT_EQ(rows.size(), 3u);
  const std::string text = read_text(dive / "trajectory.tum");
  EXPECT_NE(text.find("\n1700000000.123456789 "), std::string::npos);
  EXPECT_NE(text.find("\n1700000001.123456791 "), std::string::npos);
  const std::vector<std::uint64_t> images{0, 2, 3};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 8u);
    const Rigid3 pose = small.pose(images[i]);
    EXPECT_NEAR(rows[i][1], pose.translation.x(), 1e-9);
    EXPECT_NEAR(rows[i][3], pose.translation.z(), 1e-9);
    const Eigen::Quaterniond q(rows[i][7], rows[i][4], rows[i][5], rows[i][6]);
    EXPECT_NEAR(q.norm(), 1, 1e-8);
    EXPECT_GE(q.w(), 0);
    EXPECT_NEAR(q.angularDistance(pose.rotation), 0, 1e-7);
  }
}

TEST(Trajectory, KeepsTheLivePosesBesideTheCorrectedOnes) {
  const SmallDive small;
  const ScratchFolder scratch;
  {
    Dive dive(scratch / "dive", small.info(), {});
    ASSERT_TRUE(dive.add(small.entry(0)).empty());
    const Entry next = small.entry(1);
    auto corrected = std::make_shared<Orientation>(*next.orientation);
    corrected->poses.push_back(small.entry(0).orientation->poses.front());
    corrected->poses.back().survey_from_camera.translation.x() = 42;
    ASSERT_TRUE(dive.add({corrected, next.surface, next.cloud, next.mosaic}).empty());
    ASSERT_TRUE(dive.finish({}).empty());
  }
  EXPECT_EQ(rows_of(scratch / "dive/trajectory.tum")[0][1], 42);
  EXPECT_EQ(rows_of(scratch / "dive/trajectory_live.tum")[0][1], 0);
}

TEST(Sparse, HasEachTiePointOnceInItsNewestState) {
  const Recorded dive({});
  const Ply ply(dive / "sparse.ply");
  EXPECT_EQ(ply.names, (std::vector<std::string>{"x", "y", "z", "red", "green", "blue",
                                                 "observations", "submap"}));
  ASSERT_EQ(ply.rows.size(), 9u);
  for (const auto& row : ply.rows) {
    const auto id = static_cast<std::uint64_t>(row[0]);
    EXPECT_EQ(row[5], static_cast<double>(id));
    const bool again = id % 2 == 0 && id < 8;  // shared by two windows, or the first of all
    EXPECT_EQ(row[2], again ? 1 : 0) << id;
    EXPECT_EQ(row[6], again ? 2 : id == 8 ? 4 : 3) << id;
  }
  EXPECT_EQ(dive.dive_json()["counts"]["tie_points"], 9);
}

TEST(Projection3d, HasThePointsOfEveryGrid) {
  const Recorded dive({});
  const Ply ply(dive / "projection3d.ply");
  EXPECT_EQ(ply.names, (std::vector<std::string>{"x", "y", "z", "red", "green", "blue", "image"}));
  EXPECT_EQ(ply.type_of_x, "float");
  EXPECT_NE(ply.comment.find("metres"), std::string::npos);
  ASSERT_EQ(ply.rows.size(), 4u * 12u);
  for (std::size_t i = 0; i < ply.rows.size(); ++i) {
    const std::size_t image = i / 12, cell = i % 12;
    EXPECT_NEAR(ply.rows[i][0], 0.1 * static_cast<double>(cell % 4), 1e-6);
    EXPECT_NEAR(ply.rows[i][1], 1 - 0.1 * static_cast<double>(cell / 4), 1e-6);
    EXPECT_EQ(ply.rows[i][3], 7 + static_cast<double>(image));
    EXPECT_EQ(ply.rows[i][6], static_cast<double>(image));
  }
}

TEST(Projection3d, KeepsMillimetresAThousandKilometresAway) {
  SmallDive small;
  small.far_away = 1e6;
  const Recorded dive(small);
  const Ply ply(dive / "projection3d.ply");
  EXPECT_NEAR(ply.rows[1][0], 1e6 + 0.1, 1e-4);
  EXPECT_NEAR(Ply(dive / "sparse.ply").rows[1][0], 1e6 + 1, 1e-4);
}

TEST(Alerts, AreOneObjectALine) {
  SmallDive small;
  small.rejected = 2;
  const Recorded dive(small);
  const json alert = json::parse(read_text(dive / "alerts.jsonl"));
  EXPECT_EQ(alert["kind"], "image_rejected");
  EXPECT_EQ(alert["image"], 2);
  EXPECT_EQ(alert["message"], "damaged");
  EXPECT_EQ(alert["remedy"], "none");
  EXPECT_NEAR(alert["time_s"].get<double>(), 1700000001.123456791, 1e-6);
}

TEST(SparseCloud, LeavesOutWhatALaterWindowGaveUp) {
  const SmallDive small;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {});
  ASSERT_TRUE(dive.add(small.entry(0)).empty());
  Entry entry = small.entry(1);
  auto orientation = std::make_shared<Orientation>(*entry.orientation);
  auto window = std::make_shared<Window>(*orientation->window);
  window->given_up = {0};
  orientation->window = window;
  entry.orientation = orientation;
  ASSERT_TRUE(dive.add(entry).empty());
  ASSERT_TRUE(dive.finish({}).empty());
  const std::size_t left = 2 * SmallDive::kPointsEach - 2;  // one seen twice, one given up
  EXPECT_EQ(Ply(scratch / "dive/sparse.ply").rows.size(), left);
  const json found = json::parse(read_text(scratch / "dive/dive.json"));
  EXPECT_EQ(found["counts"]["tie_points"], left);
}

TEST(HealthTable, HasALineOfEachImage) {
  SmallDive small;
  small.rejected = 1;
  const Recorded dive(small);
  std::istringstream in(read_text(dive / "health.csv"));
  std::string line;
  std::getline(in, line);
  EXPECT_TRUE(line.starts_with("image,name,seconds,state,oriented,submap,tie_points,"));
  std::getline(in, line);
  EXPECT_EQ(line,
            "0,\"dsc,0\",1700000000.123456789,tracking,1,0,3,1,1,1,0,2.5,0.400,120.500,99.250,,,");
  std::getline(in, line);
  EXPECT_TRUE(line.starts_with("1,\"dsc,1\",1700000000.623456790,rejected,0,"));
}

TEST(HealthTable, NamesWhatIsWeakAndTheDiveCountsIt) {
  const SmallDive small;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {});
  for (int i = 0; i < small.images; ++i) {
    Entry entry = small.entry(i);
    auto orientation = std::make_shared<Orientation>(*entry.orientation);
    if (i < 2) orientation->health.add(Weakness::dark);
    if (i == 1) orientation->health.add(Weakness::few_tie_points);
    entry.orientation = orientation;
    ASSERT_TRUE(dive.add(entry).empty());
  }
  ASSERT_TRUE(dive.finish({}).empty());
  const std::string table = read_text(scratch / "dive/health.csv");
  EXPECT_NE(table.find(",dark\n1,"), std::string::npos) << table;
  EXPECT_NE(table.find(",few_tie_points dark\n2,"), std::string::npos) << table;
  const json weak = json::parse(read_text(scratch / "dive/dive.json"))["weak_images"];
  EXPECT_EQ(weak["dark"], 2);
  EXPECT_EQ(weak["few_tie_points"], 1);
  EXPECT_EQ(weak["bright"], 0);
}

// Key frames 0 and 3; 1 and 2 are measured from 0, and 4 from 3.
TEST(HealthTable, HoldsTheSigmaRelativeToTheImageBefore) {
  SmallDive small;
  small.images = 5;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {});
  for (int i = 0; i < small.images; ++i) {
    Entry entry = small.entry(i);
    auto orientation = std::make_shared<Orientation>(*entry.orientation);
    ImagePose& pose = orientation->poses.front();
    pose.key_frame = i == 0 || i == 3;
    pose.sigma_position = i == 0 ? 0 : i == 2 ? 0.04 : 0.03;
    pose.sigma_rotation = pose.sigma_position / 2;
    pose.survey_from_camera.translation = {0.25 * i, 0, 2};
    entry.orientation = orientation;
    ASSERT_TRUE(dive.add(entry).empty());
  }
  ASSERT_TRUE(dive.finish({}).empty());
  std::istringstream table(read_text(scratch / "dive/health.csv"));
  std::vector<std::string> sigmas;
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    const std::size_t start = line.find("99.250,") + 7;
    sigmas.push_back(line.substr(start, line.find(',', start) - start));
  }
  EXPECT_EQ(sigmas, (std::vector<std::string>{"", "0.030000", "0.050000", "0.050000", "0.030000"}));

  // Of the one step between key frames, and its turn over the quarter metre that follows.
  const json drift = json::parse(read_text(scratch / "dive/dive.json"))["drift"];
  ASSERT_EQ(drift.size(), 1u);
  EXPECT_NEAR(drift[0]["path_survey_units"].get<double>(), 1.0, 1e-9);
  const double expected = std::sqrt(0.03 * 0.03 + 2.0 / 3 * 0.015 * 0.015 * 0.25 * 0.25);
  EXPECT_NEAR(drift[0]["sigma_survey_units"].get<double>(), expected, 1e-9);
  EXPECT_NEAR(drift[0]["sigma_percent"].get<double>(), 100 * expected, 1e-7);
}

TEST(HealthTable, TakesWhatIsKnownOnlyLater) {
  const SmallDive small;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {});
  for (int i = 0; i < 2; ++i) {
    Entry entry = small.entry(i);
    auto orientation = std::make_shared<Orientation>(*entry.orientation);
    if (i == 0) orientation->health = {};
    if (i == 1) orientation->later_health = {{0, {9, {3, 2, 2, 2}, 4, 0.25, 120.5, 99.25}}};
    entry.orientation = orientation;
    ASSERT_TRUE(dive.add(entry).empty());
  }
  ASSERT_TRUE(dive.finish({}).empty());
  EXPECT_NE(read_text(scratch / "dive/health.csv").find(",9,3,2,2,2,4.0,0.250,120.500,99.250,"),
            std::string::npos);
}

TEST(DiveJson, TellsWhereLostImagesMayLieAndRecoveryDoesToo) {
  const SmallDive small;
  const ScratchFolder scratch;
  {
    Dive dive(scratch / "dive", small.info(), {});
    Entry entry = small.entry(0);
    ASSERT_TRUE(dive.add(entry).empty());
    entry = small.entry(1);
    auto lost = std::make_shared<Orientation>();
    lost->shot = entry.orientation->shot;
    lost->state = TrackingState::lost;
    lost->lost = {1};
    lost->dead_reckoned =
        DeadReckoned{1, 0, {Eigen::Quaterniond::Identity(), {1.5, -2, 0.25}}, 0.4};
    ASSERT_TRUE(dive.add({lost, nullptr, nullptr, nullptr}).empty());
    // Lost at first, and found in the end.
    entry = small.entry(2);
    auto found = std::make_shared<Orientation>(*entry.orientation);
    found->dead_reckoned = DeadReckoned{2, 0, {Eigen::Quaterniond::Identity(), {9, 9, 9}}, 0.4};
    ASSERT_TRUE(dive.add({found, entry.surface, entry.cloud, entry.mosaic}).empty());
    ASSERT_TRUE(dive.finish({}).empty());
  }
  const auto check = [&] {
    const json places = json::parse(read_text(scratch / "dive/dive.json"))["dead_reckoned"];
    ASSERT_EQ(places.size(), 1u) << places;
    EXPECT_EQ(places[0]["image"], 1);
    EXPECT_EQ(places[0]["position_survey_units"], (json{1.5, -2.0, 0.25}));
    EXPECT_EQ(places[0]["sigma_survey_units"], 0.4);
  };
  check();
  std::filesystem::remove(scratch / "dive/dive.json");
  recover(scratch / "dive");
  check();
}

TEST(DiveJson, CountsEveryImageOnce) {
  SmallDive small;
  small.rejected = 1;
  const ScratchFolder scratch;
  {
    Dive dive(scratch / "dive", small.info(), {});
    for (const std::uint64_t i : {0u, 1u, 5u, 6u}) {
      const Entry made = small.entry(i);
      auto orientation = std::make_shared<Orientation>(*made.orientation);
      if (i == 5) {
        auto shot = std::make_shared<Shot>(*orientation->shot);
        shot->dropped_before = 1;
        shot->missed_before = 2;
        orientation->shot = shot;
      }
      if (i == 6) {
        orientation->poses.clear();
        orientation->lost = {6};
      }
      ASSERT_TRUE(dive.add({orientation, made.surface, nullptr, nullptr}).empty());
    }
    ASSERT_TRUE(dive.finish({}, 2).empty());
  }
  const json counts = json::parse(read_text(scratch / "dive/dive.json"))["counts"];
  EXPECT_EQ(counts["captured"], 9);
  EXPECT_EQ(counts["oriented"], 2);
  EXPECT_EQ(counts["lost"], 1);
  EXPECT_EQ(counts["dropped"],
            (json{{"image_rejected", 1}, {"queue_full", 3}, {"camera", 2}, {"storage", 0}}));
}

TEST(DiveJson, SaysWhatTheDiveIs) {
  const Recorded dive({});
  const json found = dive.dive_json();
  EXPECT_EQ(found["counts"]["planes"], 4);
  EXPECT_EQ(found["counts"]["windows"], 4);
  EXPECT_EQ(found["counts"]["mosaic_tiles"], 5);
  EXPECT_EQ(found["submaps"], (json::array({{{"id", 0},
                                             {"first_image", 0},
                                             {"last_image", 3},
                                             {"joined", nullptr},
                                             {"uncertain", false},
                                             {"scale", found["scale"]}}})));
  EXPECT_EQ(found["scale"], (json{{"source", "stereo"}, {"sigma", 0.001}}));
  EXPECT_EQ(found["survey_axes"], "attitude");
  EXPECT_NEAR(found["area_m2"].get<double>(), 5 * 100 * 50 * 1e-4, 1e-9);
  EXPECT_EQ(found["rates"]["images_hz"], 2.0);
  EXPECT_TRUE(found["drift"].empty());  // no sigmas are known here
  EXPECT_EQ(found["configuration"]["odometry.window"], 3);
  EXPECT_EQ(found["versions"]["nadir"], "0.1.0");
}

void expect_said(const std::filesystem::path& file, std::string_view text) {
  EXPECT_NE(read_text(file).find(text), std::string::npos) << file << ": " << text;
}

TEST(Scale, IsSaidInEveryProductWithSourceAndSigma) {
  const Recorded dive(SmallDive{});
  for (const char* name :
       {"trajectory.tum", "trajectory_live.tum", "sparse.ply", "projection3d.ply",
        "mosaic2d/mosaic-000.png.aux.xml", "projected/000003.png.aux.xml"}) {
    expect_said(dive / name, "metres, scale from the pair of cameras, sigma 0.100 %");
  }
}

// A map that is measured only after its images were projected. Live poses stay as they were told.
TEST(Scale, MeasuredLaterIsSaidInAllThatIsMadeFromIt) {
  SmallDive small;
  small.metric = false;
  const ScratchFolder scratch;
  const auto folder = scratch / "dive";
  Revision measured;
  measured.corrections = {{0, 0, Similarity3{2, {}}}};
  measured.scales = {{0, {ScaleSource::altitude, 0.02}}};
  {
    Dive dive(folder, small.info(), {});
    for (std::uint64_t i = 0; i < 4; ++i) ASSERT_TRUE(dive.add(small.entry(i)).empty());
    Entry last;
    last.orientation = std::make_shared<const Orientation>();
    last.revisions = {std::make_shared<const Revision>(measured)};
    ASSERT_TRUE(dive.add(last).empty());
    ASSERT_TRUE(dive.finish({}).empty());
  }
  const auto check = [&] {
    for (const char* name : {"trajectory.tum", "sparse.ply", "projection3d.ply",
                             "mosaic2d/mosaic-000.png.aux.xml", "projected/000003.png.aux.xml"}) {
      expect_said(folder / name, "metres, scale from the altimeter, sigma 2.000 %");
    }
    expect_said(folder / "trajectory_live.tum", "unscaled");
  };
  check();
  std::filesystem::remove(folder / "dive.json");
  std::filesystem::remove(folder / "projected/000003.png.aux.xml");
  recover(folder);
  check();
}

// Sub-maps of an image each, of which one has a scale; then what the revision says.
void record_submaps(const std::filesystem::path& folder, int count, Revision revision,
                    int metric = 0) {
  const SmallDive small;
  Dive dive(folder, small.info(), {});
  for (int i = 0; i < count; ++i) {
    const Entry made = small.entry(static_cast<std::uint64_t>(i));
    auto orientation = std::make_shared<Orientation>(*made.orientation);
    auto window = std::make_shared<Window>(*orientation->window);
    orientation->poses[0].submap = window->submap = static_cast<std::uint32_t>(i);
    if (i != metric) window->scale = {};
    orientation->window = window;
    ASSERT_TRUE(dive.add({orientation, nullptr, nullptr, nullptr}).empty());
  }
  Entry last;
  last.orientation = std::make_shared<const Orientation>();
  last.revisions = {std::make_shared<const Revision>(std::move(revision))};
  ASSERT_TRUE(dive.add(last).empty());
  ASSERT_TRUE(dive.finish({}).empty());
}

// The third is measured in the end.
TEST(DiveJson, TellsTheScaleOfEverySubmapAndRecoveryDoesToo) {
  const ScratchFolder scratch;
  Revision revision;
  revision.scales = {{2, {ScaleSource::laser, 0.02}}};
  record_submaps(scratch / "dive", 3, revision);
  const auto check = [&] {
    const json submaps = json::parse(read_text(scratch / "dive/dive.json"))["submaps"];
    ASSERT_EQ(submaps.size(), 3u) << submaps;
    EXPECT_EQ(submaps[0]["scale"], (json{{"source", "stereo"}, {"sigma", 0.001}}));
    EXPECT_EQ(submaps[1]["scale"], (json{{"source", "none"}, {"sigma", nullptr}}));
    EXPECT_EQ(submaps[2]["scale"], (json{{"source", "laser"}, {"sigma", 0.02}}));
  };
  check();
  std::filesystem::remove(scratch / "dive/dive.json");
  recover(scratch / "dive");
  check();
}

// What gave them was found wrong on the way: not even the first mosaic has its north from it.
TEST(DiveJson, TellsTheAxesAsLastKnown) {
  const SmallDive small;
  const ScratchFolder scratch;
  {
    Dive dive(scratch / "dive", small.info(), {});
    for (std::uint64_t i = 0; i < 4; ++i) {
      Entry entry = small.entry(i);
      auto orientation = std::make_shared<Orientation>(*entry.orientation);
      orientation->axes = i < 2 ? SurveyAxes::attitude : SurveyAxes::doubtful;
      entry.orientation = orientation;
      ASSERT_TRUE(dive.add(entry).empty());
    }
    ASSERT_TRUE(dive.finish({}).empty());
  }
  EXPECT_EQ(json::parse(read_text(scratch / "dive/dive.json"))["survey_axes"], "doubtful");
  expect_said(scratch / "dive/mosaic2d/mosaic-000.png.aux.xml", "AXIS[\"x\"");
}

// Whichever of them a pair has measured.
TEST(DiveJson, JoinedSubmapsHaveOneScale) {
  for (const int metric : {0, 1, 2}) {
    const ScratchFolder scratch;
    Revision revision;
    revision.joins = {{1, 0}, {2, 1}};
    revision.corrections = {{1, 1, Similarity3{}}};
    record_submaps(scratch / "dive", 3, revision, metric);
    const json found = json::parse(read_text(scratch / "dive/dive.json"));
    for (const json& submap : found["submaps"])
      EXPECT_EQ(submap["scale"], (json{{"source", "stereo"}, {"sigma", 0.001}})) << metric;
    EXPECT_EQ(found["survey_unit"], "metres");
  }
}

TEST(Unscaled, IsSaidInEveryProduct) {
  SmallDive small;
  small.metric = false;
  const Recorded dive(small);
  EXPECT_TRUE(dive.dive_json()["area_m2"].is_null());
  EXPECT_TRUE(dive.dive_json()["scale"]["sigma"].is_null());
  EXPECT_EQ(dive.dive_json()["submaps"][0]["scale"],
            (json{{"source", "none"}, {"sigma", nullptr}}));
  for (const char* name :
       {"dive.json", "trajectory.tum", "trajectory_live.tum", "sparse.ply", "projection3d.ply",
        "mosaic2d/mosaic-000.png.aux.xml", "projected/000003.png.aux.xml"}) {
    EXPECT_NE(read_text(dive / name).find("unscaled"), std::string::npos) << name;
    EXPECT_EQ(read_text(dive / name).find("metre"), std::string::npos) << name;
  }
}

TEST(Rasters, AreReadByGdalAtTheirPlace) {
  ASSERT_FALSE(output_of("gdalinfo --version").empty()) << "install gdal-bin";
  const Recorded dive({});
  // Tiles (0, 0) and (1, -1) to (1, 2): the raster starts one tile left of pixel (0, 0).
  const json mosaic =
      json::parse(output_of("gdalinfo -json " + (dive / "mosaic2d/mosaic-000.png").string()));
  EXPECT_EQ(mosaic["size"], (json::array({4 * 256, 2 * 256})));
  const json place = mosaic["geoTransform"];
  EXPECT_NEAR(place[0].get<double>(), -2.56 - 0.005, 1e-9);
  EXPECT_NEAR(place[1].get<double>(), 0.01, 1e-12);
  EXPECT_NEAR(place[3].get<double>(), 2.005, 1e-9);
  EXPECT_NEAR(place[5].get<double>(), -0.01, 1e-12);
  EXPECT_EQ(mosaic["bands"].size(), 4u);
  const char* scale = "metres, scale from the pair of cameras, sigma 0.100 %";
  EXPECT_EQ(mosaic["metadata"][""]["SCALE"], scale);
  EXPECT_NE(mosaic["coordinateSystem"]["wkt"].get<std::string>().find("nadir survey"),
            std::string::npos);
  const json image =
      json::parse(output_of("gdalinfo -json " + (dive / "projected/000003.png").string()));
  EXPECT_NEAR(image["geoTransform"][0].get<double>(), 0.12 - 0.005, 1e-9);
  EXPECT_EQ(image["metadata"][""]["SCALE"], scale);
  const std::string colour = output_of("gdallocationinfo -valonly -geoloc " +
                                       (dive / "mosaic2d/mosaic-000.png").string() + " 0.5 1.5");
  EXPECT_EQ(colour, "3\n2\n1\n255\n");
}

TEST(Files, KeepThePointInEveryLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Recorded plain({});
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  const Recorded german({});
  std::setlocale(LC_ALL, "C");
  std::locale::global(before);
  EXPECT_EQ(read_all(plain / ""), read_all(german / ""));
}

TEST(Files, AreTheSameBytesForTheSameEntries) {
  SmallDive small;
  small.rejected = 1;
  const Recorded one(small), other(small);
  const auto files = read_all(one / "");
  EXPECT_EQ(files, read_all(other / ""));
  EXPECT_EQ(files.size(), 20u);
  for (const auto& [name, text] : files) {
    EXPECT_EQ(name.find("/."), std::string::npos) << name;
    EXPECT_EQ(text.find("nan"), std::string::npos) << name;
  }
}

TEST(Files, HoldNoNumberThatIsNotFinite) {
  const SmallDive small;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {});
  const Entry made = small.entry(0);
  auto orientation = std::make_shared<Orientation>(*made.orientation);
  orientation->poses.front().survey_from_camera.translation.x() = NAN;
  auto window = std::make_shared<Window>(*orientation->window);
  window->tie_points.front().x_in_survey.y() = INFINITY;
  orientation->window = window;
  orientation->health.rms_px = NAN;
  ASSERT_TRUE(dive.add({orientation, made.surface, made.cloud, made.mosaic}).empty());
  ASSERT_TRUE(dive.finish({}).empty());
  EXPECT_TRUE(rows_of(scratch / "dive/trajectory.tum").empty());
  EXPECT_EQ(Ply(scratch / "dive/sparse.ply").rows.size(), 2u);
  EXPECT_NE(read_text(scratch / "dive/health.csv").find("1,1,1,0,2.5,,120.500"), std::string::npos);
  EXPECT_EQ(json::parse(read_text(scratch / "dive/dive.json"))["counts"]["lost"], 1);
}

TEST(Dive, NeverWritesOverWhatIsThere) {
  const SmallDive small;
  const Recorded recorded(small);
  const auto before = read_all(recorded / "");
  EXPECT_THROW(Dive(recorded / "", small.info(), {}), InputError);
  EXPECT_EQ(read_all(recorded / ""), before);
  const ScratchFolder scratch;
  write_text(scratch / "notes.txt", "mine");
  EXPECT_THROW(Dive(scratch / "", small.info(), {}), InputError);
  EXPECT_THROW(Dive(scratch / "notes.txt/dive", small.info(), {}), InputError);
  EXPECT_EQ(read_all(scratch / "").size(), 1u);
}

TEST(Dive, TakesNoFolderThatCannotBeRead) {
  const ScratchFolder scratch;
  const SmallDive small;
  std::filesystem::create_directories(scratch / "a");
  std::filesystem::create_directories(scratch / "b");
  const support::FailingFolder failing(scratch / "");
  EXPECT_THROW(Dive(scratch / "", small.info(), {}), InputError);
}

TEST(Dive, TakesAnEmptyFolder) {
  const ScratchFolder scratch;
  const SmallDive small;
  Dive dive(scratch / "", small.info(), {});
  EXPECT_TRUE(dive.add(small.entry(0)).empty());
  EXPECT_THROW(Dive(scratch / "", small.info(), {}), InputError) << "while it is recorded";
}

}  // namespace
}  // namespace nadir::record

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/recover.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <sstream>

#include "facts.hpp"
#include "journal.hpp"
#include "nadir/core/check.hpp"
#include "nadir/mosaic2d/mosaic.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"
#include "support/failing_folder.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

// As the pipeline makes them: the tiles of each update come from its projected image.
std::vector<Entry> mosaicked(const SmallDive& small) {
  mosaic2d::Mosaic mosaic(small.mosaic());
  std::vector<Entry> entries;
  for (int i = 0; i < small.images; ++i) {
    Entry entry = small.entry(static_cast<std::uint64_t>(i));
    auto update = std::make_shared<MosaicUpdate>(*entry.mosaic);
    update->tiles = mosaic.add(*update->projected);
    entry.mosaic = update;
    entries.push_back(entry);
  }
  return entries;
}

SmallDive larger() {
  SmallDive small;
  small.width = 200;
  small.height = 150;
  small.images = 6;
  return small;
}

class Recovering : public testing::Test {
 protected:
  void record(bool finish) {
    Dive dive(folder_, small_.info(), {});
    for (const Entry& entry : mosaicked(small_)) ASSERT_TRUE(dive.add(entry).empty());
    EXPECT_TRUE(!finish || dive.finish({{"images_hz", 2.5}}).empty());
  }
  static json without_rates(const std::string& dive_json) {
    json dive = json::parse(dive_json);
    dive.erase("rates");
    dive.erase("cut_off");
    return dive;
  }

  SmallDive small_ = larger();
  ScratchFolder scratch_;
  path folder_ = scratch_ / "dive";
};

// Whole records by their checksums, of which no dive can tell.
TEST_F(Recovering, ComesToAnEndWhateverTheJournalSays) {
  std::filesystem::create_directory(folder_);
  JournalWriter writer(system_disk(), folder_);
  for (std::uint64_t image = 0; image < 3; ++image) {
    Facts facts = facts_of(small_.entry(image));
    facts.poses[0].survey_from_camera.translation.setConstant(std::nan(""));
    facts.health.tracked_length = std::nan("");
    facts.joins = {{3, 1, 3, 1}, {1, 2, 1, 2}, {1, 3, 1, 3}, {2, 2, 2, 2}};
    ASSERT_EQ(writer.append(RecordType::shot, encode(facts)), 0);
  }
  writer.close();
  const Recovery recovery = recover(folder_);
  EXPECT_EQ(recovery.captured, 3u);
  EXPECT_EQ(recovery.lost, 3u);
  for (const auto& [name, text] : read_all(folder_)) {
    if (name.ends_with(".nadir")) continue;
    EXPECT_EQ(text.find("nan"), std::string::npos) << name;
  }
  EXPECT_TRUE(is_complete(folder_));
}

TEST_F(Recovering, MakesTheFilesTheDiveWouldHaveMade) {
  record(true);
  auto finished = read_all(folder_);
  ScratchFolder other;
  folder_ = other / "dive";
  record(false);
  const Recovery recovery = recover(folder_);
  EXPECT_EQ(recovery.oriented, 6u);
  EXPECT_EQ(recovery.projected, 6u);
  EXPECT_FALSE(recovery.was_complete);
  EXPECT_TRUE(recovery.whole());
  auto recovered = read_all(folder_);
  EXPECT_EQ(without_rates(recovered["dive.json"]), without_rates(finished["dive.json"]));
  for (auto* files : {&finished, &recovered}) {
    files->erase("dive.json");
    files->erase("journal-000.nadir");  // without its last record
  }
  EXPECT_EQ(recovered, finished);
  EXPECT_TRUE(recovered.contains("mosaic2d/mosaic-000.png"));
}

TEST_F(Recovering, ACompleteDiveChangesNothing) {
  record(true);
  const auto before = read_all(folder_);
  const Recovery recovery = recover(folder_);
  EXPECT_TRUE(recovery.was_complete);
  EXPECT_TRUE(recovery.whole());
  EXPECT_TRUE(recovery.made.empty());
  EXPECT_EQ(read_all(folder_), before);
}

TEST_F(Recovering, AnUnfinishedDiveTwiceIsTheSameAsOnce) {
  record(false);
  (void)recover(folder_);
  const auto once = read_all(folder_);
  EXPECT_TRUE(is_complete(folder_));
  const Recovery again = recover(folder_);
  EXPECT_TRUE(again.made.empty());
  EXPECT_TRUE(again.cut_off);
  EXPECT_EQ(read_all(folder_), once);
}

TEST_F(Recovering, IsNotEndedByAFolderThatCannotBeRead) {
  record(false);
  const support::FailingFolder failing(folder_ / "projected");
  EXPECT_TRUE(recover(folder_).whole());
}

TEST_F(Recovering, MakesTheMosaicsWhereTheirFolderWasLost) {
  record(true);
  const auto before = read_all(folder_);
  std::filesystem::remove_all(folder_ / "mosaic2d");
  const Recovery recovery = recover(folder_);
  EXPECT_TRUE(recovery.whole());
  EXPECT_EQ(read_all(folder_).at("mosaic2d/mosaic-000.png"), before.at("mosaic2d/mosaic-000.png"));
}

// The disk had no room for two of its images: made again, the mosaic is not the same.
TEST_F(Recovering, SaysWhichMosaicsLackImages) {
  {
    Dive dive(folder_, small_.info(), {});
    int image = 0;
    for (Entry entry : mosaicked(small_)) {
      if (image == 2 || image == 3) {
        auto update = std::make_shared<MosaicUpdate>(*entry.mosaic);
        update->projected.reset();
        entry.mosaic = update;
      }
      ++image;
      ASSERT_TRUE(dive.add(entry).empty());
    }
    ASSERT_TRUE(dive.finish({}).empty());
  }
  EXPECT_TRUE(recover(folder_).whole());
  std::filesystem::remove(folder_ / "mosaic2d/mosaic-000.png");
  const Recovery recovery = recover(folder_);
  EXPECT_EQ(recovery.damaged,
            (std::vector<std::string>{"mosaic2d/mosaic-000.png: lacks 2 of its images, whose files "
                                      "could not be saved"}));
  EXPECT_FALSE(recovery.whole());
}

TEST_F(Recovering, MakesAgainWhatIsMissingOrDamagedAndKeepsWhatChanged) {
  record(true);
  const auto before = read_all(folder_);
  for (const auto& [name, text] : before) {
    if (name.starts_with("journal") || name.ends_with(".png") || name == "dive.json") continue;
    std::filesystem::remove(folder_ / name);
    (void)recover(folder_);
    EXPECT_EQ(read_all(folder_), before) << name;
  }
  write_text(folder_ / "trajectory.tum", "mine");
  write_text(folder_ / "mosaic2d/mosaic-000.png", "torn");
  const Recovery recovery = recover(folder_);
  EXPECT_EQ(recovery.made, (std::vector<std::string>{"mosaic2d/mosaic-000.png", "trajectory.tum"}));
  auto after = read_all(folder_);
  EXPECT_EQ(after["trajectory.tum.changed"], "mine");
  after.erase("trajectory.tum.changed");
  after.erase("mosaic2d/mosaic-000.png.changed");
  EXPECT_EQ(after, before);
}

TEST_F(Recovering, NeverReplacesGoodFilesFromABadJournal) {
  record(true);
  auto before = read_all(folder_);
  std::string journal = before["journal-000.nadir"];
  for (std::size_t at = journal.size() / 3; at < journal.size(); at += 1000) journal[at] ^= 1;
  write_text(folder_ / "journal-000.nadir", journal);
  before["journal-000.nadir"] = journal;
  const Recovery recovery = recover(folder_);
  EXPECT_FALSE(recovery.whole());
  EXPECT_GT(recovery.missing_records, 0u);
  EXPECT_EQ(read_all(folder_), before);
}

TEST_F(Recovering, CountsWhatCannotBeMadeAgain) {
  record(false);
  std::string image = read_text(folder_ / "projected/000002.png");
  image[image.size() / 2] ^= 1;
  write_text(folder_ / "projected/000002.png", image);
  std::filesystem::remove(folder_ / "projected/000003.png");
  const Recovery recovery = recover(folder_);
  EXPECT_EQ(recovery.damaged,
            (std::vector<std::string>{"projected/000002.png", "projected/000003.png"}));
  EXPECT_EQ(recovery.projected, 4u);
  EXPECT_EQ(recovery.oriented, 6u);
  EXPECT_FALSE(recovery.whole());
}

TEST_F(Recovering, LeavesADiveAloneThatIsBeingRecorded) {
  Dive dive(folder_, small_.info(), {});
  ASSERT_TRUE(dive.add(small_.entry(0)).empty());
  const auto before = read_all(folder_);
  EXPECT_THROW((void)recover(folder_), InputError);
  EXPECT_EQ(read_all(folder_), before);
}

TEST_F(Recovering, RefusesAJournalWithoutAWholeRecordAndTouchesNothing) {
  record(true);
  const auto size = read_text(folder_ / "journal-000.nadir").size();
  for (const std::string& text : {std::string(), std::string(size, 'x')}) {
    write_text(folder_ / "journal-000.nadir", text);
    const auto before = read_all(folder_);
    EXPECT_THROW((void)recover(folder_), InputError) << text.size();
    EXPECT_EQ(read_all(folder_), before);
  }
}

TEST_F(Recovering, SaysWhichMosaicCannotBeMadeAgain) {
  record(false);
  std::filesystem::remove_all(folder_ / "projected");
  const Recovery recovery = recover(folder_);
  EXPECT_FALSE(recovery.whole());
  EXPECT_EQ(std::ranges::count(recovery.damaged, "mosaic2d/mosaic-000.png"), 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mosaic2d/mosaic-000.pgw"));
}

TEST_F(Recovering, RefusesAJournalThatIsNoFileAtOnce) {
  std::filesystem::create_directories(folder_);
  ASSERT_EQ(::mkfifo((folder_ / "journal-000.nadir").c_str(), 0600), 0);
  EXPECT_THROW((void)recover(folder_), InputError);
}

TEST_F(Recovering, CountsTheFirstRecordWhenTheJournalsBeginningIsDamaged) {
  record(false);
  std::string journal = read_text(folder_ / "journal-000.nadir");
  journal.replace(0, 60, 60, 'x');
  write_text(folder_ / "journal-000.nadir", journal);
  const Recovery recovery = recover(folder_);
  EXPECT_EQ(recovery.oriented, 6u);
  EXPECT_EQ(recovery.missing_records, 1u);
}

TEST_F(Recovering, RefusesAFolderThatIsNoDive) {
  EXPECT_THROW((void)recover(scratch_ / ""), InputError);
  EXPECT_THROW((void)recover(scratch_ / "nowhere"), InputError);
}

// Reports through the pipe each image that is acknowledged, until it is killed.
[[noreturn]] void record_for_ever(const SmallDive& small, const path& folder, int pipe) {
  QuickDisk disk;
  Dive dive(folder, small.info(), {}, disk);
  for (std::uint64_t i = 0;; ++i) {
    (void)dive.add(small.entry(i));
    if (::write(pipe, "+", 1) != 1) ::_exit(1);
  }
}

std::uint64_t count_bytes(int pipe) {
  std::uint64_t count = 0;
  char buffer[256];
  for (ssize_t size; (size = ::read(pipe, buffer, sizeof buffer)) > 0;) {
    count += static_cast<std::uint64_t>(size);
  }
  return count;
}

TEST(Killed, AtARandomInstantKeepsEveryAcknowledgedImage) {
  std::mt19937 random(3);
  SmallDive small;
  small.with_tiles = false;
  for (int round = 0; round < 25; ++round) {
    const ScratchFolder scratch;
    int pipe[2];
    ASSERT_EQ(::pipe(pipe), 0);
    const pid_t child = ::fork();
    if (child == 0) record_for_ever(small, scratch / "dive", pipe[1]);
    ::close(pipe[1]);
    char first = 0;
    ASSERT_EQ(::read(pipe[0], &first, 1), 1);
    ::usleep(static_cast<useconds_t>(random() % 20000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const std::uint64_t acknowledged = 1 + count_bytes(pipe[0]);
    ::close(pipe[0]);
    QuickDisk disk;
    const Recovery recovery = recover(scratch / "dive", disk);
    EXPECT_GE(recovery.oriented, acknowledged);
    EXPECT_GE(recovery.projected, acknowledged);
    EXPECT_TRUE(recovery.whole());
  }
}

// Corrections of two key frames, told with the end of the dive; they count for the images up to the
// next.
std::vector<Correction> two_corrections() {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  return {{0, 0, {1, {Eigen::Quaterniond::Identity(), {0.05, 0.02, 0.01}}}},
          {3, 0, {1.1, {turn, {0.2, 0, 0}}}}};
}

Entry last_entry() {
  auto revision = std::make_shared<Revision>();
  revision->corrections = two_corrections();
  Entry entry;
  entry.orientation = std::make_shared<const Orientation>();
  entry.revisions = {revision};
  return entry;
}

std::vector<double> numbers_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double number; in >> number;) numbers.push_back(number);
  return numbers;
}

struct Vertex {
  Eigen::Vector3d x;
  std::array<std::uint8_t, 3> rgb;
  std::uint32_t first;  ///< of the properties after the colour
};

// A cloud of single precision.
std::vector<Vertex> vertices_of(const path& ply, std::size_t last_properties) {
  const std::string bytes = read_text(ply), end = "end_header\n";
  const std::size_t size = 15 + 4 * last_properties;
  std::vector<Vertex> vertices;
  for (std::size_t at = bytes.find(end) + end.size(); at + size <= bytes.size(); at += size) {
    std::array<float, 3> x;
    Vertex& vertex = vertices.emplace_back();
    std::memcpy(x.data(), &bytes[at], 12);
    std::memcpy(vertex.rgb.data(), &bytes[at + 12], 3);
    std::memcpy(&vertex.first, &bytes[at + 15], 4);
    vertex.x = Eigen::Vector3f(x[0], x[1], x[2]).cast<double>();
  }
  return vertices;
}

constexpr double kFloatRounding = 1e-6;  // of coordinates below 16 m

const Similarity3& correction_of(std::uint64_t image) {
  static const auto corrections = two_corrections();
  return corrections[image < 3 ? 0 : 1].corrected_from_live;
}

void expect_corrected_surface(const SmallDive& small, const path& ply) {
  const auto vertices = vertices_of(ply, 1);
  auto vertex = vertices.begin();
  for (std::uint64_t image = 0; image < 6; ++image) {
    for (const CloudPoint& point : small.grid(image).points()) {
      ASSERT_NE(vertex, vertices.end());
      EXPECT_EQ(vertex->first, image);
      EXPECT_LT((vertex->x - correction_of(image) * point.x_in_survey).norm(), kFloatRounding);
      ++vertex;
    }
  }
  EXPECT_EQ(vertex, vertices.end());
}

// A tie point is moved with the image whose window told of it last; its number is its blue.
void expect_corrected_tie_points(const SmallDive& small, const path& ply) {
  const auto vertices = vertices_of(ply, 2);
  EXPECT_EQ(vertices.size(), 13u);
  for (const Vertex& vertex : vertices) {
    const std::uint64_t id = vertex.rgb[2], last = std::min<std::uint64_t>(id / 2, 5);
    const TiePoint point = small.window(last)->tie_points.at(id - 2 * last);
    ASSERT_EQ(point.id, id);
    EXPECT_EQ(vertex.first, point.images);
    EXPECT_LT((vertex.x - correction_of(last) * point.x_in_survey).norm(), kFloatRounding) << id;
  }
}

TEST(CorrectedDive, HoldsEveryProductWhereItWasCorrectedToAndIsRecoveredSo) {
  const SmallDive small = larger();
  ScratchFolder scratch;
  const auto folder = scratch / "dive";
  {
    Dive dive(folder, small.info(), {});
    for (const Entry& entry : mosaicked(small)) ASSERT_TRUE(dive.add(entry).empty());
    ASSERT_TRUE(dive.add(last_entry()).empty());
    ASSERT_TRUE(dive.finish({{"images_hz", 2.5}}).empty());
  }
  std::istringstream poses(read_text(folder / "trajectory.tum"));
  std::string line;
  std::getline(poses, line);
  for (std::uint64_t image = 0; image < 6; ++image) {
    const Similarity3& by = correction_of(image);
    std::getline(poses, line);
    const auto row = numbers_of(line);
    const Rigid3 pose = by * small.pose(image);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(row.at(1 + k), pose.translation[k], 1e-9) << image;
    // The upper left pixel of the projected image, on its plane z = 0.5.
    const std::string name = "projected/00000" + std::to_string(image) + ".pgw";
    const auto world = numbers_of(read_text(folder / name));
    const WorldFile was = small.world(image);
    const Eigen::Vector3d corner = by * Eigen::Vector3d(was.c, was.f, 0.5);
    EXPECT_NEAR(world.at(4), corner.x(), 1e-9) << image;
    EXPECT_NEAR(world.at(5), corner.y(), 1e-9) << image;
  }
  expect_corrected_surface(small, folder / "projection3d.ply");
  expect_corrected_tie_points(small, folder / "sparse.ply");
  // North up again, for all that the images are turned.
  const auto mosaic = numbers_of(read_text(folder / "mosaic2d/mosaic-000.pgw"));
  EXPECT_EQ(mosaic.at(1), 0);
  EXPECT_EQ(mosaic.at(2), 0);

  const auto finished = read_all(folder);
  for (const auto& [name, bytes] : finished) {
    if (!name.starts_with("journal-") && !name.ends_with(".png")) {
      std::filesystem::remove(folder / name);
    }
  }
  std::filesystem::remove(folder / "mosaic2d/mosaic-000.png");
  const Recovery recovery = recover(folder);
  EXPECT_TRUE(recovery.damaged.empty());
  for (const auto& [name, bytes] : finished) {
    if (name == "dive.json") continue;
    EXPECT_TRUE(read_text(folder / name) == bytes) << name << " differs";
  }
  const json before = json::parse(finished.at("dive.json"));
  const json after = json::parse(read_text(folder / "dive.json"));
  EXPECT_EQ(before["counts"], after["counts"]);
  EXPECT_EQ(before["files"], after["files"]);
}

}  // namespace
}  // namespace nadir::record

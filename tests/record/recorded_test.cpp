// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/recorded.hpp"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "nadir/core/check.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

using std::filesystem::path;

struct Given {
  std::vector<Entry> entries;
  std::vector<std::pair<MosaicGrid, std::shared_ptr<const Tile>>> tiles;
  std::vector<std::pair<std::size_t, Mark>> marks;  ///< after so many entries
  GivenAgain found;
};

Given give(const path& dive, const std::stop_token& stop = {}) {
  Given given;
  given.found =
      give_again(dive,
                 {[&](const Entry& entry) { given.entries.push_back(entry); },
                  [&](const MosaicGrid& grid, const auto& tiles) {
                    for (const auto& tile : tiles) given.tiles.emplace_back(grid, tile);
                  },
                  [&](const Mark& mark) { given.marks.emplace_back(given.entries.size(), mark); }},
                 stop);
  return given;
}

class RecordedDive : public testing::Test {
 protected:
  void record(bool finish, const DiveInfo& info) {
    Dive dive(folder_, info, {});
    dive.add(Alert{7, std::nullopt, AlertKind::camera_lost, "unplugged", "plug it in"});
    for (int i = 0; i < small_.images; ++i) {
      Entry entry = small_.entry(static_cast<std::uint64_t>(i));
      if (corrected_ && i == 2) {
        auto revision = std::make_shared<Revision>();
        revision->corrections = {{1, 0, {1, {Eigen::Quaterniond::Identity(), {0, 0, 0.5}}}}};
        entry.revisions = {revision};
      }
      ASSERT_TRUE(dive.add(entry).empty());
      if (i == 1) {
        EXPECT_TRUE(dive.add(Mark{.id = 3, .image = 0, .position = {1, 2, 3}}));
      }
    }
    EXPECT_TRUE(!finish || dive.finish({{"images_hz", 2.5}}).empty());
  }

  SmallDive small_;
  bool corrected_ = false;
  ScratchFolder scratch_;
  path folder_ = scratch_ / "dive";
};

TEST_F(RecordedDive, IsGivenAsItWasPublished) {
  small_.rejected = 1;
  corrected_ = true;
  record(true, small_.info());
  const Given given = give(folder_);
  ASSERT_EQ(given.entries.size(), 4u);
  EXPECT_EQ(given.entries[0].orientation->alerts.at(0).message, "unplugged");
  EXPECT_EQ(given.entries[1].orientation->shot->frame, nullptr);
  EXPECT_EQ(given.entries[1].orientation->alerts.at(0).kind, AlertKind::image_rejected);
  EXPECT_EQ(
      given.entries[2].revisions.at(0)->corrections.at(0).corrected_from_live.rigid.translation.z(),
      0.5);
  const Entry& last = given.entries[3];
  EXPECT_EQ(last.orientation->shot->name, "dsc,3");
  EXPECT_EQ(last.orientation->shot->time, small_.time(3));
  ASSERT_NE(last.orientation->shot->frame, nullptr);
  EXPECT_EQ(last.orientation->poses.at(0).survey_from_camera.translation,
            small_.pose(3).translation);
  EXPECT_EQ(last.orientation->window->tie_points.at(2).x_in_survey,
            small_.window(3)->tie_points.at(2).x_in_survey);
  ASSERT_EQ(given.marks.size(), 1u);
  EXPECT_EQ(given.marks[0].first, 2u);
  EXPECT_EQ(given.marks[0].second.id, 3u);
  EXPECT_EQ(given.found.captured, 4u);
  EXPECT_EQ(given.found.missing_records, 0u);
  EXPECT_EQ(given.found.mosaics_left_out, 0u);
  ASSERT_TRUE(last.cloud->grid);
  EXPECT_EQ(last.cloud->grid->survey_from_grid, small_.grid(3).survey_from_grid);
  EXPECT_EQ(cv::norm(last.cloud->grid->bgr, small_.grid(3).bgr, cv::NORM_INF), 0);
}

// The colour at a survey position, by the tiles that were given.
std::optional<cv::Vec4b> colour_at(const Given& given, double x, double y) {
  for (const auto& [grid, tile] : given.tiles) {
    const int column = static_cast<int>(std::lround((x - grid.world.c) / grid.world.a)) -
                       tile->column * MosaicGrid::kTileSize;
    const int row = static_cast<int>(std::lround((y - grid.world.f) / grid.world.e)) -
                    tile->row * MosaicGrid::kTileSize;
    const cv::Rect all(0, 0, MosaicGrid::kTileSize, MosaicGrid::kTileSize);
    if (all.contains({column, row})) return tile->bgra.at<cv::Vec4b>(row, column);
  }
  return std::nullopt;
}

TEST_F(RecordedDive, HasItsMosaicsWhereTheyAreOnTheSurvey) {
  for (const bool on_earth : {false, true}) {
    DiveInfo info = small_.info();
    if (on_earth) info.origin = {.latitude_deg = 60.4, .longitude_deg = 5.3, .height = 0};
    std::filesystem::remove_all(folder_);
    record(true, info);
    const Given given = give(folder_);
    const WorldFile world = small_.mosaic().world;
    // Of the tile in column 0, row 0, which has colours in columns 10 to 109, rows 20 to 69.
    const Eigen::Vector2d inside = world(15, 25);
    EXPECT_EQ(colour_at(given, inside.x(), inside.y()), cv::Vec4b(1, 2, 3, 255)) << on_earth;
    const Eigen::Vector2d beside = world(5, 25);
    EXPECT_EQ(colour_at(given, beside.x(), beside.y()), cv::Vec4b(0, 0, 0, 0)) << on_earth;
    EXPECT_FALSE(given.tiles.empty());
    EXPECT_TRUE(std::ranges::all_of(given.tiles, [](const auto& tile) {
      cv::Mat alpha;
      cv::extractChannel(tile.second->bgra, alpha, 3);
      return cv::countNonZero(alpha) > 0;
    }));
  }
}

TEST_F(RecordedDive, IsGivenAsFarAsItGoesWhenItWasCutOff) {
  record(false, small_.info());
  const Given given = give(folder_);
  EXPECT_EQ(given.entries.size(), 4u);
  EXPECT_TRUE(given.tiles.empty());
}

TEST_F(RecordedDive, LeavesOutAMosaicWhoseFileIsDamaged) {
  record(true, small_.info());
  const path png = folder_ / "mosaic2d/mosaic-000.png";
  for (const std::uintmax_t size : {0, 30, 200}) {
    ASSERT_GT(std::filesystem::file_size(png), size);
    std::filesystem::resize_file(png, size);
    EXPECT_TRUE(give(folder_).tiles.empty()) << size;
    EXPECT_EQ(give(folder_).entries.size(), 4u);
    EXPECT_EQ(give(folder_).found.mosaics_left_out, 1u);
    write_text(png, std::string(1000, 'x'));
  }
}

TEST_F(RecordedDive, IsGivenWithoutWhatIsDamaged) {
  record(true, small_.info());
  const path journal = folder_ / "journal-000.nadir";
  std::string text = read_text(journal);
  text[text.find("dsc,2")] ^= 1;
  write_text(journal, text);
  const Given given = give(folder_);
  EXPECT_EQ(given.entries.size(), 3u);
  EXPECT_EQ(given.found.missing_records, 1u);
}

TEST_F(RecordedDive, TellsHowManyImagesItOnceHadWhenTheEndOfItsJournalIsMissing) {
  record(true, small_.info());
  EXPECT_FALSE(give(folder_).found.captured_once);
  const path journal = folder_ / "journal-000.nadir";
  std::filesystem::resize_file(journal, read_text(journal).find("dsc,2"));
  const Given given = give(folder_);
  EXPECT_EQ(given.found.captured, 2u);
  EXPECT_EQ(given.found.captured_once, 4u);
}

TEST_F(RecordedDive, IsNotWaitedForWhereAPipeIsInThePlaceOfAFile) {
  record(true, small_.info());
  for (const char* name : {"mosaic2d/mosaic-000.png", "mosaic2d/mosaic-000.pgw", "dive.json"}) {
    std::filesystem::remove(folder_ / name);
    ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
    EXPECT_EQ(give(folder_).found.mosaics_left_out, 1u);
  }
}

TEST_F(RecordedDive, IsNotFollowedOutOfItsFolder) {
  record(true, small_.info());
  const auto leave_a_link = [&](const char* name) {
    const path elsewhere = scratch_ / path(name).filename();
    std::filesystem::rename(folder_ / name, elsewhere);
    std::filesystem::create_symlink(elsewhere, folder_ / name);
  };
  leave_a_link("mosaic2d/mosaic-000.png");
  EXPECT_EQ(give(folder_).found.mosaics_left_out, 1u);
  leave_a_link("journal-000.nadir");
  EXPECT_THROW(give(folder_), InputError);
}

TEST_F(RecordedDive, IsGivenNoFurtherWhenToldToStop) {
  record(true, small_.info());
  std::stop_source stop;
  std::size_t entries = 0;
  give_again(folder_,
             {[&](const Entry&) {
                if (++entries == 2) stop.request_stop();
              },
              [](const MosaicGrid&, const auto&) { FAIL(); }},
             stop.get_token());
  EXPECT_EQ(entries, 2u);
  EXPECT_TRUE(give(folder_, stop.get_token()).entries.empty());
}

TEST_F(RecordedDive, IsRefusedWhenItIsNone) {
  EXPECT_THROW(give(scratch_ / "nothing"), InputError);
}

}  // namespace
}  // namespace nadir::record

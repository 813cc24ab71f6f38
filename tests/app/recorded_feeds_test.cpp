// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Recorded dives as viewers of a real server see them.
#include "recorded_feeds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <thread>

#include "desk.hpp"
#include "device_token.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/record/recover.hpp"
#include "nadir/wire/records.hpp"
#include "record/small_dive.hpp"
#include "serve/raw_client.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using record::ScratchFolder;
using record::SmallDive;

/// The newest of each kind that a viewer was sent.
struct Seen {
  std::optional<wire::State> state;
  std::optional<wire::Recording> recording;
  std::map<std::uint64_t, ImagePose> poses;
  std::map<std::uint64_t, wire::PlaneGrid> grids;
  std::map<std::uint64_t, wire::TiePoints> blocks;
  std::map<std::uint64_t, Mark> marks;
  std::map<std::uint32_t, MosaicGrid> mosaics;
  std::map<std::pair<int, int>, wire::MosaicTile> tiles;
  std::map<std::pair<int, int>, wire::MosaicOverview> overviews;
  std::vector<Alert> alerts, alerts_after_end;
  std::set<int> types;
  bool refused = false, sent_away = false;
  std::uint64_t let_go = 0;

  void take(const wire::Bytes& bytes) {
    types.insert(bytes[0]);
    if (const auto now = wire::decode_state(bytes)) state = now;
    if (const auto now = wire::decode_recording(bytes)) recording = now;
    if (const auto pose = wire::decode_pose(bytes)) poses[pose->image] = *pose;
    if (const auto grid = wire::decode_plane_grid(bytes)) grids[grid->image] = *grid;
    if (const auto block = wire::decode_tie_points(bytes)) blocks[block->block] = *block;
    if (const auto mark = wire::decode_mark(bytes)) marks[mark->id] = *mark;
    if (const auto mosaic = wire::decode_mosaic(bytes)) mosaics[mosaic->mosaic] = *mosaic;
    if (const auto tile = wire::decode_mosaic_tile(bytes)) tiles[{tile->row, tile->column}] = *tile;
    if (const auto far = wire::decode_mosaic_overview(bytes))
      overviews[{far->row, far->column}] = *far;
    if (const auto alert = wire::decode_alert(bytes)) {
      (state && state->finished ? alerts_after_end : alerts).push_back(alert->alert);
    }
    if (const auto caught_up = wire::decode_caught_up(bytes)) let_go = caught_up->evicted;
  }
};

class RecordedDives : public testing::Test {
 protected:
  RecordedDives() {
    fs::create_directories(scratch / "dives");
    small.rejected = 1;
  }

  fs::path folder(const std::string& name) const { return scratch / "dives" / name; }

  /// Corrected at its third image by half a metre in height, with a mark before and one after.
  void record(const std::string& name, bool finish = true) const {
    record::Dive dive(folder(name), small.info(), {});
    for (int i = 0; i < small.images; ++i) {
      record::Entry entry = small.entry(static_cast<std::uint64_t>(i));
      if (i == 2 && corrected) {
        auto revision = std::make_shared<Revision>();
        revision->corrections = {{0, 0, {1, {Eigen::Quaterniond::Identity(), {0, 0, 0.5}}}}};
        entry.revisions = {revision};
        EXPECT_TRUE(dive.add(Mark{.id = 0, .image = 0, .position = {1, 2, 3}, .note = "before"}));
      }
      ASSERT_TRUE(dive.add(entry).empty());
    }
    EXPECT_TRUE(dive.add(Mark{.id = 1, .image = 0, .position = {1, 2, 3}, .note = "after"}));
    EXPECT_TRUE(dive.add(Mark{.id = 2, .position = {0, 0, 0}}));
    EXPECT_TRUE(dive.add(Mark{.id = 2, .position = {0, 0, 0}, .removed = true}));
    EXPECT_TRUE(!finish || dive.finish({}).empty());
  }

  static serve::Call call(const std::string& method, const std::string& path) {
    return {method, "/api/" + path, "", "", "session-ann", "", "127.0.0.1", true, ""};
  }
  std::string target(const std::string& name) {
    const serve::Answer answer = desk.answer(call("GET", "dives"));
    for (const auto& dive : nlohmann::json::parse(answer.text)) {
      if (dive["name"] == name) return "/feed?dive=" + dive["id"].get<std::string>();
    }
    return "/feed?dive=none";
  }

  /// All that a viewer is sent of a dive until it is whole, with what is said of its faults.
  Seen watch(serve::RawClient& viewer, const std::string& name, std::size_t faults = 0) {
    Seen seen;
    seen.refused = viewer.join(0, 0, target(name)).feed == 0;
    bool whole = seen.refused;
    while (!whole) {
      const auto message = viewer.next();
      if (!message || message->opcode == serve::RawClient::kClose) break;
      seen.take(message->bytes);
      whole = seen.state && seen.state->finished && seen.alerts_after_end.size() >= faults &&
              message->type() == wire::kCaughtUpType;
    }
    EXPECT_TRUE(whole) << name;
    return seen;
  }
  Seen watch(const std::string& name, std::size_t faults = 0) {
    serve::RawClient viewer(server->port());
    return watch(viewer, name, faults);
  }
  /// Whether it is sent away within the patience of a client.
  static bool is_sent_away(serve::RawClient& viewer) {
    while (const auto message = viewer.next()) {
      if (message->opcode == serve::RawClient::kClose) return true;
    }
    return false;
  }

  static serve::Config any_port() {
    serve::Config config;
    config.port = 0;
    return config;
  }

  SmallDive small;
  bool corrected = true;
  ScratchFolder scratch;
  Desk desk{scratch / "dives", new_token(), {}};
  std::optional<serve::WebServer> server{
      std::in_place,          any_port(),     std::vector<serve::Asset>(), std::nullopt,
      serve::Listen::at_once, desk.handlers()};
  std::size_t retained = 64u << 20;
  void open() { desk.serve_by(*server, retained); }
};

TEST_F(RecordedDives, AreShownAsTheyWereCorrected) {
  open();
  record("dive-0001");
  const Seen seen = watch("dive-0001");
  ASSERT_EQ(seen.poses.size(), 3u);
  for (const auto& [image, pose] : seen.poses) {
    const Eigen::Vector3d placed = small.pose(image).translation + Eigen::Vector3d(0, 0, 0.5);
    EXPECT_LT((pose.survey_from_camera.translation - placed).norm(), 1e-9) << image;
  }
  ASSERT_EQ(seen.grids.size(), 3u);
  EXPECT_NEAR(seen.grids.at(3).survey_from_grid(2, 2), 1, 1e-9);
  ASSERT_EQ(seen.blocks.size(), 1u);
  const wire::TiePoints& block = seen.blocks.at(0);
  EXPECT_EQ(block.points.size(), 8u) << "of three windows of three, one of them in two";
  EXPECT_NEAR(block.origin.z() + double(block.points.back().offset[2]), 0.5, 1e-6);
  EXPECT_EQ(seen.marks.at(0).position, Eigen::Vector3d(1, 2, 3.5));
  EXPECT_EQ(seen.marks.at(0).note, "before");
  EXPECT_EQ(seen.marks.at(1).position, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(!seen.marks.contains(2) || seen.marks.at(2).removed);
}

TEST_F(RecordedDives, HaveTheMosaicOfTheDiskWhereItIsOnTheSurvey) {
  corrected = false;
  open();
  record("dive-0001");
  const Seen seen = watch("dive-0001");
  ASSERT_EQ(seen.mosaics.size(), 1u);
  const MosaicGrid& grid = seen.mosaics.at(0);
  EXPECT_EQ(seen.state->mosaic_tiles, seen.tiles.size());
  // Of the tile in column 0, row 0, which has colours in 100 x 50 pixels.
  const Eigen::Vector2d inside = small.mosaic().world(15, 25);
  const int column = static_cast<int>(std::lround((inside.x() - grid.world.c) / grid.world.a));
  const int row = static_cast<int>(std::lround((inside.y() - grid.world.f) / grid.world.e));
  constexpr int kSide = MosaicGrid::kTileSize;
  ASSERT_TRUE(seen.tiles.contains({row / kSide, column / kSide}));
  const wire::MosaicTile& tile = seen.tiles.at({row / kSide, column / kSide});
  const cv::Mat mask =
      image_io::decode(tile.mask_png, kSide, kSide, 1, image_io::Colour::grey).image;
  EXPECT_EQ(mask.at<std::uint8_t>(row % kSide, column % kSide), 255);
  EXPECT_EQ(cv::countNonZero(mask), 100 * 50);
  // The same from afar, an eighth as large.
  const auto far = seen.overviews.find({row / 8 / kSide, column / 8 / kSide});
  ASSERT_NE(far, seen.overviews.end());
  const cv::Mat how_much =
      image_io::decode(far->second.mask_png, kSide, kSide, 1, image_io::Colour::grey).image;
  EXPECT_GT(how_much.at<std::uint8_t>(row / 8 % kSide, column / 8 % kSide), 0);
  const cv::Mat of_tile = how_much(
      {kSide / 8 * (column / kSide % 8), kSide / 8 * (row / kSide % 8), kSide / 8, kSide / 8});
  EXPECT_NEAR(cv::sum(of_tile)[0] / 255, 100 * 50 / 64.0, 0.5);
}

TEST_F(RecordedDives, HaveTheirMosaicCorrectedOnce) {
  open();
  record("dive-0001");
  const Seen seen = watch("dive-0001");
  EXPECT_FALSE(seen.tiles.empty());
  ASSERT_EQ(seen.mosaics.size(), 1u);
  EXPECT_NEAR(seen.mosaics.at(0).plane.offset, small.plane().offset + 0.5, 1e-9);
}

TEST_F(RecordedDives, SayWhatTheyAreAndNothingOfNow) {
  open();
  record("dive-0001");
  const Seen seen = watch("dive-0001");
  ASSERT_TRUE(seen.recording && seen.state);
  EXPECT_EQ(seen.recording->phase, wire::Phase::ended);
  EXPECT_EQ(seen.recording->name, "dive-0001");
  EXPECT_EQ(seen.recording->saved, 4u);
  EXPECT_FALSE(seen.recording->controllable);
  EXPECT_EQ(seen.state->input, "dive-0001");
  EXPECT_EQ(seen.state->captured, 4u);
  EXPECT_EQ(seen.state->images_total, 4u);
  EXPECT_EQ(seen.state->oriented, 3u);
  EXPECT_EQ(seen.state->rate_hz, 0);
  EXPECT_EQ(seen.alerts.size(), 1u) << "of the image that could not be read";
  EXPECT_TRUE(seen.alerts_after_end.empty());
  constexpr int kLiveImage = 12, kMeasures = 16, kLastView = 21, kWayBack = 22;
  for (const int type : {kLiveImage, kMeasures, kLastView, kWayBack}) {
    EXPECT_FALSE(seen.types.contains(type)) << type;
  }
}

TEST_F(RecordedDives, SayWhatIsDamagedAndShowTheRest) {
  open();
  record("dive-0001");
  const fs::path journal = folder("dive-0001") / "journal-000.nadir";
  std::string text = record::read_text(journal);
  const std::size_t third = text.find("dsc,2");
  ASSERT_NE(third, text.npos);
  text[third] ^= 1;
  record::write_text(journal, text);
  fs::remove(folder("dive-0001") / "mosaic2d/mosaic-000.png");
  const Seen seen = watch("dive-0001", 2);
  EXPECT_EQ(seen.poses.size(), 2u);
  ASSERT_EQ(seen.alerts_after_end.size(), 2u);
  EXPECT_THAT(seen.alerts_after_end[0].message, testing::HasSubstr("1 record of its journal"));
  EXPECT_THAT(seen.alerts_after_end[1].message, testing::HasSubstr("1 mosaic missing"));
  for (const Alert& alert : seen.alerts_after_end) {
    EXPECT_EQ(alert.kind, AlertKind::storage);
    EXPECT_THAT(alert.remedy, testing::HasSubstr("nadir recover " + folder("dive-0001").string()));
  }
}

TEST_F(RecordedDives, SayWhenTheEndOfTheirJournalIsMissing) {
  open();
  record("dive-0001");
  const fs::path journal = folder("dive-0001") / "journal-000.nadir";
  fs::resize_file(journal, record::read_text(journal).find("dsc,2"));
  const Seen seen = watch("dive-0001", 1);
  ASSERT_EQ(seen.alerts_after_end.size(), 1u);
  EXPECT_THAT(seen.alerts_after_end[0].message, testing::HasSubstr("images left: 2 of 4"));
}

TEST_F(RecordedDives, AreShownWhenNothingIsLeftOfThem) {
  open();
  fs::create_directories(folder("dive-0001"));
  record::write_text(folder("dive-0001") / "journal-000.nadir", std::string(5000, 'x'));
  const Seen seen = watch("dive-0001", 1);
  ASSERT_EQ(seen.alerts_after_end.size(), 1u);
  EXPECT_THAT(seen.alerts_after_end[0].message, testing::HasSubstr("no whole record"));
  EXPECT_THAT(seen.alerts_after_end[0].remedy, testing::HasSubstr("nadir recover"));
}

TEST_F(RecordedDives, AreReadAnewOnceTheyWereRecovered) {
  open();
  record("dive-0001", false);
  EXPECT_TRUE(watch("dive-0001").tiles.empty());
  ASSERT_TRUE(record::recover(folder("dive-0001")).whole());
  EXPECT_FALSE(watch("dive-0001").tiles.empty());
}

TEST_F(RecordedDives, AreTwoAtATime) {
  open();
  for (const char* name : {"dive-0001", "dive-0002", "dive-0003"}) record(name);
  serve::RawClient first(server->port()), again(server->port()), second(server->port());
  EXPECT_FALSE(watch(first, "dive-0001").refused);
  {
    serve::RawClient passing(server->port());
    EXPECT_FALSE(watch(passing, "dive-0002").refused);
  }
  // The second has nobody any more, once the server has noticed.
  const auto deadline = std::chrono::steady_clock::now() + 5s;
  while (server->stats().clients > 1 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_FALSE(watch(second, "dive-0003").refused);
  EXPECT_TRUE(watch("dive-0002").refused) << "both are watched";
  EXPECT_FALSE(watch(again, "dive-0001").refused) << "it is still open";
}

TEST_F(RecordedDives, HaveOneFeedForAllTheirViewers) {
  open();
  record("dive-0001");
  serve::RawClient first(server->port()), second(server->port());
  const auto one = first.join(0, 0, target("dive-0001"));
  const auto other = second.join(0, 0, target("dive-0001"));
  EXPECT_NE(one.feed, 0u);
  EXPECT_EQ(one.feed, other.feed);
  serve::RawClient live(server->port());
  EXPECT_NE(live.join().feed, one.feed);
}

TEST_F(RecordedDives, AreNotShownWhileTheyAreRecordedOrWhenThereAreNone) {
  record("dive-0001");
  EXPECT_TRUE(watch("dive-0001").refused) << "before there is a server to make feeds";
  open();
  desk.live().begin(folder("dive-0001"));
  EXPECT_TRUE(watch("dive-0001").refused);
  desk.live().end();
  EXPECT_FALSE(watch("dive-0001").refused);
  for (const char* wrong : {"/feed?dive=", "/feed?dive=..", "/feed?dive=dive-0001", "/feed?x=1",
                            "/feed?dive=%2e%2e%2fdives"}) {
    serve::RawClient viewer(server->port());
    EXPECT_THAT(viewer.upgrade(wrong), testing::HasSubstr(" 404 ")) << wrong;
  }
}

TEST_F(RecordedDives, AreGoneWithTheirRemoval) {
  open();
  record("dive-0001");
  serve::RawClient viewer(server->port());
  watch(viewer, "dive-0001");
  const std::string token = nlohmann::json::parse(desk.answer(call("GET", "token")).text)["token"];
  serve::Call take = call("POST", "control/take");
  serve::Call remove =
      call("DELETE", "dives/" + target("dive-0001").substr(target("").find('=') + 1));
  take.token = remove.token = token;
  ASSERT_EQ(desk.answer(take).status, 200u);
  EXPECT_EQ(desk.answer(remove).status, 200u);
  EXPECT_TRUE(is_sent_away(viewer));
  EXPECT_TRUE(watch("dive-0001").refused);
}

TEST_F(RecordedDives, KeepTheirMosaicAndPathWhenTheyAreTooLarge) {
  small.images = 400;
  retained = 100'000;
  open();
  record("dive-0001");
  serve::RawClient first(server->port());
  const std::size_t tiles = watch(first, "dive-0001").tiles.size();
  const Seen seen = watch("dive-0001");
  EXPECT_EQ(seen.tiles.size(), tiles);
  EXPECT_GT(seen.let_go, 0u);
  EXPECT_EQ(seen.poses.size(), 399u);
  EXPECT_EQ(seen.state->planes, 399u);
  EXPECT_LT(seen.grids.size(), 399u);
}

TEST_F(RecordedDives, AreLetGoWhileTheyAreRead) {
  small.images = 300;
  small.with_tiles = false;
  open();
  record("dive-0001");
  {
    serve::RawClient viewer(server->port());
    EXPECT_NE(viewer.join(0, 0, target("dive-0001")).feed, 0u);
  }
  server.reset();
}

// Nobody watches: it would take its time.
TEST(RecordedFeedsAlone, EndAtOnceAndWhenNobodyWatches) {
  ScratchFolder scratch;
  SmallDive small;
  small.images = 200;
  small.with_tiles = false;
  {
    record::Dive dive(scratch / "dive", small.info(), {});
    for (int i = 0; i < small.images; ++i) {
      ASSERT_TRUE(dive.add(small.entry(static_cast<std::uint64_t>(i))).empty());
    }
  }
  serve::Config config;
  config.port = 0;
  std::optional<serve::WebServer> server(std::in_place, config, std::vector<serve::Asset>());
  const auto make = [&] { return server->make_feed(1 << 20); };
  {
    RecordedFeeds feeds(100ms);
    EXPECT_EQ(feeds.find(scratch / "dive"), nullptr) << "nobody to make them";
    feeds.make_by(make);
    const std::weak_ptr<serve::Feed> feed = feeds.find(scratch / "dive");
    const auto deadline = std::chrono::steady_clock::now() + 5s;
    while (!feed.expired() && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(10ms);
    }
    EXPECT_TRUE(feed.expired());
    EXPECT_NE(feeds.find(scratch / "dive"), nullptr) << "and it can be opened again";
  }
  RecordedFeeds feeds;
  feeds.make_by(make);
  const std::weak_ptr<serve::Feed> feed = feeds.find(scratch / "dive");
  EXPECT_FALSE(feed.expired());
  server.reset();  // a feed may outlive it
}

}  // namespace
}  // namespace nadir::app

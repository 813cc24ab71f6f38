// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Originals beside the map: which are kept, what a survey folder of them holds, and what a disk
// that fails costs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "nadir/record/recover.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

using testing::HasSubstr;

const std::vector<std::uint8_t> kLeft{0xFF, 0xD8, 'l'}, kRight{0xFF, 0xD8, 'r'};

/// An entry with originals; key frames are those of even numbers, the last image has no pose.
Entry with_originals(const SmallDive& small, std::uint64_t image, bool pair) {
  Entry entry = small.entry(image);
  auto orientation = std::make_shared<Orientation>(*entry.orientation);
  auto shot = std::make_shared<Shot>(*orientation->shot);
  shot->originals = std::make_shared<const OriginalImages>(
      OriginalImages{kLeft, pair ? kRight : std::vector<std::uint8_t>()});
  auto frame = std::make_shared<Frame>(*shot->frame);
  if (image != 1) frame->attitude = Attitude{0.1, -0.2, 3};
  frame->depth = 4.5;
  shot->frame = frame;
  orientation->shot = shot;
  orientation->poses[0].key_frame = image % 2 == 0;
  if (image == 3) orientation->poses.clear();
  entry.orientation = orientation;
  return entry;
}

void record(const path& folder, Originals which, bool pair = false,
            std::optional<reference::Geodetic> origin = std::nullopt) {
  const SmallDive small;
  DiveInfo info = small.info();
  info.origin = origin;
  info.survey_files = {{"calib.yml", "a camera\n"}};
  Config config;
  config.originals = which;
  Dive dive(folder, info, config);
  for (std::uint64_t i = 0; i < 4; ++i)
    EXPECT_TRUE(dive.add(with_originals(small, i, pair)).empty()) << i;
  EXPECT_TRUE(dive.finish({}).empty());
}

TEST(Originals, AreNotKeptUnlessWanted) {
  const ScratchFolder scratch;
  record(scratch / "dive", Originals::none);
  EXPECT_FALSE(std::filesystem::exists(scratch / "dive/survey"));
}

TEST(Originals, MakeASurveyFolderWithWhatTheSensorsSaid) {
  const ScratchFolder scratch;
  record(scratch / "dive", Originals::all, true);
  const path survey = scratch / "dive/survey";
  EXPECT_EQ(read_text(survey / "calib.yml"), "a camera\n");
  for (int i = 0; i < 4; ++i) {
    const std::string name = "dsc," + std::to_string(i) + ".jpg";
    EXPECT_EQ(read_text(survey / "images/left" / name), "\xFF\xD8l") << i;
    EXPECT_EQ(read_text(survey / "images/right" / name), "\xFF\xD8r") << i;
  }
  const std::string times = read_text(survey / "timestamps.csv");
  EXPECT_THAT(times, testing::StartsWith("frame,seconds\n"));
  EXPECT_EQ(std::ranges::count(times, '\n'), 5);
  const std::string attitudes = read_text(survey / "ahrs.csv");
  EXPECT_EQ(std::ranges::count(attitudes, '\n'), 4);  // image 1 has none
  EXPECT_THAT(attitudes, HasSubstr(",5.7296,-11.4592,171.8873\n"));
  EXPECT_THAT(read_text(survey / "depth.csv"), HasSubstr(",4.5000\n"));
  EXPECT_FALSE(std::filesystem::exists(survey / "altitude.csv"));
}

// A replay with the same origin turns them to the grid again: by 5.0473 degrees here.
TEST(Originals, OfAMapOnTheGridHaveTrueHeadings) {
  const ScratchFolder scratch;
  record(scratch / "dive", Originals::all, false, reference::Geodetic{60.4, 3.2, 0});
  EXPECT_THAT(read_text(scratch / "dive/survey/ahrs.csv"),
              HasSubstr(",5.7296,-11.4592,166.8400\n"));
}

TEST(Originals, OfKeyFramesAreThoseOfNewGroundAndOfImagesWithoutAPose) {
  const ScratchFolder scratch;
  record(scratch / "dive", Originals::key_frames);
  const path images = scratch / "dive/survey/images";
  for (int i = 0; i < 4; ++i) {
    const bool kept = std::filesystem::exists(images / ("dsc," + std::to_string(i) + ".jpg"));
    EXPECT_EQ(kept, i != 1) << i;
  }
}

TEST(Originals, LoseTheirTornEndWhenTheDiveIsRecovered) {
  const ScratchFolder scratch;
  record(scratch / "dive", Originals::all);
  const path survey = scratch / "dive/survey";
  const std::string whole = read_text(survey / "depth.csv");
  std::ofstream(survey / "depth.csv", std::ios::app) << "12.5000";
  std::ofstream(survey / "images/.x.jpg.tmp") << "half";
  recover(scratch / "dive");
  EXPECT_EQ(read_text(survey / "depth.csv"), whole);
  EXPECT_FALSE(std::filesystem::exists(survey / "images/.x.jpg.tmp"));
}

/// A disk that is full for everything in survey.
class FullForOriginals : public Disk {
 public:
  int open(const path& name, Open mode) override {
    const bool original = name.string().find("/survey/") != std::string::npos;
    return original && full ? -ENOSPC : Disk::open(name, mode);
  }
  bool full = true;
};

TEST(Originals, NeverCostTheMap) {
  const ScratchFolder scratch;
  const SmallDive small;
  FullForOriginals disk;
  Config config;
  config.originals = Originals::all;
  Dive dive(scratch / "dive", small.info(), config, disk);
  const auto first = dive.add(with_originals(small, 0, false));
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].kind, AlertKind::storage);
  EXPECT_THAT(first[0].message, HasSubstr("original images are not saved"));
  EXPECT_TRUE(dive.add(with_originals(small, 1, false)).empty());  // told once
  EXPECT_EQ(dive.saved(), 2u);
  disk.full = false;
  const auto again = dive.add(with_originals(small, 2, false));
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].kind, AlertKind::storage_back);
  EXPECT_THAT(again[0].message, HasSubstr("saved again"));
  EXPECT_TRUE(std::filesystem::exists(scratch / "dive/survey/images/dsc,2.jpg"));
}

}  // namespace
}  // namespace nadir::record

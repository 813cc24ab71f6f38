// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The stair of rooms: every #include and every link line is read, and an upward or sideways edge
// fails.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kSource = NADIR_SOURCE_DIR;

const std::map<std::string, int> kStep = {
    {"core", 0},     {"pipeline", 1},     {"image_io", 1},  {"calibration", 1}, {"capture", 2},
    {"sensors", 2},  {"odometry", 2},     {"reference", 2}, {"plane", 2},       {"coverage", 2},
    {"mosaic2d", 2}, {"projection3d", 2}, {"wire", 2},      {"simulate", 2},    {"revisit", 3},
    {"serve", 3},    {"record", 3},       {"app", 4},
};

// Heavy libraries and the rooms they may be seen in.
const std::vector<std::pair<std::regex, std::set<std::string>>> kLibraries = {
    {std::regex("ceres/.*"), {"odometry", "revisit"}},
    {std::regex("libcamera/.*|linux/videodev2\\.h"), {"capture"}},
    {std::regex("GeographicLib/.*"), {"reference"}},
    {std::regex("boost/.*"), {"sensors", "serve"}},
    {std::regex("openssl/.*"), {"serve"}},
    {std::regex("turbojpeg\\.h|png\\.h|tiffio\\.h|jpeglib\\.h|isa-l.*"), {"image_io"}},
    {std::regex("libdeflate\\.h"), {"image_io", "record"}},  // record: CRC-32
    {std::regex("yaml-cpp/.*|pugixml\\.hpp|opencv2/core/persistence\\.hpp"), {"calibration"}},
    {std::regex("toml\\+\\+.*|CLI/.*|qrencode\\.h"), {"app"}},
    {std::regex("opencv2/(imgcodecs|videoio|highgui).*"), {}},
};

struct Include {
  fs::path file;
  std::string room;
  std::string target;
};

std::vector<Include> includes() {
  std::vector<Include> found;
  const std::regex line_pattern(R"re(^\s*#\s*include\s*[<"]([^>"]+)[>"])re");
  for (const fs::path& base : {kSource / "src", kSource / "include" / "nadir"}) {
    for (const auto& entry : fs::recursive_directory_iterator(base)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".hpp") continue;
      const std::string room = fs::relative(entry.path(), base).begin()->string();
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (std::regex_search(line, match, line_pattern))
          found.push_back({entry.path(), room, match[1]});
      }
    }
  }
  return found;
}

std::string room_of(const std::string& target) {
  return target.starts_with("nadir/") ? target.substr(6, target.find('/', 6) - 6) : std::string();
}

TEST(Stair, EveryRoomStandsOnAStep) {
  for (const auto& entry : fs::directory_iterator(kSource / "src")) {
    EXPECT_TRUE(kStep.contains(entry.path().filename())) << entry.path();
  }
}

TEST(Stair, NoRoomIncludesUpwardsOrSideways) {
  const std::vector<Include> all = includes();
  ASSERT_GT(all.size(), 100u);
  for (const Include& include : all) {
    const std::string seen = room_of(include.target);
    if (seen.empty() || seen == include.room) continue;
    const bool revisit_sees_odometry = include.room == "revisit" && seen == "odometry";
    EXPECT_TRUE(revisit_sees_odometry || kStep.at(seen) < kStep.at(include.room))
        << include.file << " includes " << include.target;
  }
}

TEST(Stair, HeavyLibrariesStayInTheirRooms) {
  for (const Include& include : includes()) {
    for (const auto& [library, rooms] : kLibraries) {
      if (!std::regex_match(include.target, library)) continue;
      EXPECT_TRUE(rooms.contains(include.room)) << include.file << " includes " << include.target;
    }
  }
}

TEST(Stair, TheConfigurationParserIsSeenInOneFile) {
  std::set<fs::path> files;
  for (const Include& include : includes()) {
    if (include.target.starts_with("toml++")) files.insert(include.file);
  }
  EXPECT_EQ(files.size(), 1u);
}

TEST(Stair, MiddleRoomsHaveNoThreads) {
  for (const Include& include : includes()) {
    const int step = kStep.at(include.room);
    // libcamera calls its plugin from a thread of its own.
    const bool is_plugin = include.file.parent_path().filename() == "plugin";
    if (step != 2 || include.room == "sensors" || is_plugin) continue;
    EXPECT_FALSE(include.target == "thread" || include.target == "mutex" ||
                 include.target == "future" || include.target == "sys/socket.h")
        << include.file << " includes " << include.target;
  }
}

TEST(Stair, RoomsLinkOnlyRoomsBelow) {
  const std::regex link_pattern("nadir::([a-z0-9_]+)");
  for (const auto& [room, step] : kStep) {
    std::ifstream file(kSource / "src" / room / "CMakeLists.txt");
    bool tests_only = false;
    for (std::string line; std::getline(file, line);) {
      tests_only = tests_only || line.find("TEST_LINK") != std::string::npos;
      if (tests_only) continue;
      for (std::sregex_iterator match(line.begin(), line.end(), link_pattern), end; match != end;
           ++match) {
        const std::string seen = (*match)[1];
        EXPECT_TRUE(seen == room || kStep.at(seen) < step ||
                    (room == "revisit" && seen == "odometry"))
            << room << " links " << seen;
      }
    }
  }
}

TEST(Stair, EverySourceBearsItsLicence) {
  for (const fs::path& base : {kSource / "src", kSource / "include", kSource / "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(base)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".hpp") continue;
      std::ifstream file(entry.path());
      std::string first, second;
      std::getline(file, first);
      std::getline(file, second);
      EXPECT_EQ(second, "// SPDX-License-Identifier: Apache-2.0") << entry.path();
    }
  }
}

}  // namespace

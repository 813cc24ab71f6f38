// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Recorded logs of real instruments against what gpsd made of them, where it tells what we use.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "nadir/sensors/nmea.hpp"

namespace nadir::sensors {
namespace {

namespace fs = std::filesystem;

const fs::path kLogs = fs::path(NADIR_SHARED_DATA) / "real" / "logs";

constexpr double kDegree = std::numbers::pi / 180;
constexpr Time kDay = 86'400'000'000'000;

// hh:mm:ss.sss of an ISO time; gpsd guesses the date of old receivers anew.
Time time_of_day(const std::string& iso) {
  const std::string clock = iso.substr(iso.find('T') + 1);
  return from_seconds(3600 * std::stod(clock.substr(0, 2)) + 60 * std::stod(clock.substr(3, 2)) +
                      std::stod(clock.substr(6)));
}

// What a file's sentences said up to now, against gpsd's object that follows them.
class Comparison {
 public:
  void hear(const std::string& line) {
    const NmeaSentence sentence = decode_nmea(line);
    last_ = sentence.kind;
    if (sentence.kind == "GLL") position_.reset();  // gpsd's next position is from there
    if (sentence.reading.position) position_ = sentence.reading.position;
    if (sentence.fault == NmeaFault::none) reading_ = sentence.reading;
  }

  void compare(const nlohmann::json& gpsd) {
    const bool fix = last_ == "RMC" || last_ == "GGA" || last_ == "VTG";
    if (fix && position_ && gpsd.contains("lat")) {
      near("lat", gpsd, position_->latitude_deg, 1e-9);
      near("lon", gpsd, position_->longitude_deg, 1e-9);
    }
    if (last_ == "RMC" || last_ == "VTG") {
      near("track", gpsd, reading_.course.value() / kDegree, 1e-9);
      near("speed", gpsd, reading_.speed.value(), 0.0005);
    }
    if (last_ == "RMC") {
      near("magvar", gpsd, reading_.variation.value_or(0) / kDegree, 0.05);
      EXPECT_EQ(time_of_day(gpsd.at("time")), reading_.utc.value() % kDay);
      ++compared_["time"];
    }
    if (last_ == "DBT" && gpsd.contains("depth"))
      near("depth", gpsd, reading_.altitude.value(), 1e-9);
    if (last_ == "HDT") near("heading", gpsd, reading_.heading.value() / kDegree, 1e-9);
  }

  std::map<std::string, int> compared() const { return compared_; }

 private:
  void near(const char* key, const nlohmann::json& gpsd, double ours, double tolerance) {
    if (std::string(key) == "magvar" && !reading_.variation) return;  // gpsd has a model of its own
    EXPECT_NEAR(gpsd.at(key).get<double>(), ours, tolerance) << key << ' ' << gpsd;
    ++compared_[key];
  }

  std::string last_;
  Reading reading_;
  std::optional<Position> position_;
  std::map<std::string, int> compared_;
};

std::map<std::string, int> compare(const std::string& name) {
  std::ifstream file(kLogs / "nmea_gpsd" / (name + ".log.chk"));
  EXPECT_TRUE(file) << name;
  Comparison comparison;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('$')) comparison.hear(line);
    if (line.starts_with('{')) comparison.compare(nlohmann::json::parse(line));
  }
  return comparison.compared();
}

class NmeaLogs : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kLogs)) GTEST_SKIP() << "not run: no data in " << kLogs;
  }
};

TEST_F(NmeaLogs, AChartplotterSaysWhatGpsdReads) {
  const auto compared = compare("bundg_zeus_9");
  EXPECT_GE(compared.at("lat"), 140);
  EXPECT_GE(compared.at("speed"), 140);
  EXPECT_GE(compared.at("depth"), 140);
}

TEST_F(NmeaLogs, AFishFinderSaysWhatGpsdReads) {
  const auto compared = compare("humminbird-M37");
  EXPECT_GE(compared.at("lat"), 20);
  EXPECT_GE(compared.at("time"), 15);
  EXPECT_GE(compared.at("magvar"), 15);
}

TEST_F(NmeaLogs, AnInertialUnitSaysWhatGpsdReads) {
  const auto compared = compare("rst39");
  EXPECT_GE(compared.at("lat"), 40);
  EXPECT_EQ(compared.at("heading"), 4);
}

TEST_F(NmeaLogs, ASounderSaysWhatGpsdReads) { EXPECT_GE(compare("sounder").at("depth"), 120); }

// Those without decodings: every line is read, or refused for a named reason.
TEST_F(NmeaLogs, LongDivesOfAShipAreReadWhole) {
  std::map<NmeaFault, int> faults;
  std::map<std::string, int> kinds;
  for (const auto& entry : fs::directory_iterator(kLogs / "nmea_signalk" / "samples")) {
    std::ifstream file(entry.path(), std::ios::binary);
    NmeaLines lines;
    std::string bytes((std::istreambuf_iterator<char>(file)), {});
    lines.feed(bytes);
    while (const auto line = lines.next()) {
      const NmeaSentence sentence = decode_nmea(*line);
      ++faults[sentence.fault];
      if (sentence.fault == NmeaFault::none) ++kinds[sentence.kind];
    }
  }
  EXPECT_EQ(faults[NmeaFault::malformed], 0);
  EXPECT_GT(kinds["HDT"], 14000);
  EXPECT_GT(kinds["DBT"], 7000);
  EXPECT_GT(kinds["GGA"], 1000);
}

}  // namespace
}  // namespace nadir::sensors

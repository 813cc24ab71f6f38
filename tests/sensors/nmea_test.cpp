// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/nmea.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <vector>

namespace nadir::sensors {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kExact = 1e-12;

NmeaSentence decode_body(std::string_view body) { return decode_nmea(nmea_line(body)); }
Reading read(std::string_view body) {
  NmeaSentence sentence = decode_body(body);
  EXPECT_EQ(sentence.fault, NmeaFault::none) << body;
  sentence.reading.sender = 0;
  return sentence.reading;
}
NmeaFault fault_of(std::string_view line) { return decode_nmea(line).fault; }

TEST(Nmea, HdgAddsItsDeviationAndTellsTheVariation) {
  // 98.3 degrees on the sensor, 0.5 E of deviation, 12.6 W of variation.
  const Reading reading = read("HCHDG,98.3,0.5,E,12.6,W");
  EXPECT_NEAR(reading.magnetic_heading.value(), 98.8 * kDegree, kExact);
  EXPECT_NEAR(reading.variation.value(), -12.6 * kDegree, kExact);
  EXPECT_FALSE(reading.heading);
  EXPECT_NEAR(read("HCHDG,0.2,0.5,W,,").magnetic_heading.value(), 359.7 * kDegree, kExact);
  EXPECT_EQ(read("HCHDG,,,,1.3,E").magnetic_heading, std::nullopt);
}

TEST(Nmea, HdmIsMagneticAndHdtIsTrue) {
  EXPECT_NEAR(read("IIHDM,225.6,M").magnetic_heading.value(), 225.6 * kDegree, kExact);
  EXPECT_NEAR(read("GPHDT,0.41,T").heading.value(), 0.41 * kDegree, kExact);
  EXPECT_EQ(read("GPHDT,360.0,T").heading, 0);  // some send it for north
  EXPECT_EQ(read("GPHDT,360.1,T").heading, std::nullopt);
  EXPECT_EQ(read("GPHDT,12.0,M"), Reading());
}

TEST(Nmea, RotIsInDegreesPerMinuteToStarboard) {
  EXPECT_NEAR(read("TIROT,-30.0,A").turn_rate.value(), -0.5 * kDegree, kExact);
  EXPECT_EQ(read("TIROT,35.6,V").turn_rate, std::nullopt);
}

TEST(Nmea, DptAndDbtAreTheWayToTheGround) {
  EXPECT_DOUBLE_EQ(read("SDDPT,2.4,0.5").altitude.value(), 2.4);
  EXPECT_DOUBLE_EQ(read("SDDPT,2.4,-0.5,100").altitude.value(), 2.4);
  EXPECT_DOUBLE_EQ(read("SDDBT,17.7,f,5.4,M,3.0,F").altitude.value(), 5.4);
  EXPECT_DOUBLE_EQ(read("SDDBT,10,f,,M,,F").altitude.value(), 3.048);
  EXPECT_DOUBLE_EQ(read("SDDBT,,f,,M,2,F").altitude.value(), 3.6576);
  EXPECT_EQ(read("SDDPT,0.0,0.5").altitude, std::nullopt);  // the ground was lost
  EXPECT_EQ(read("SDDBT,,f,,M,,F").altitude, std::nullopt);
}

TEST(Nmea, VtgIsCourseAndSpeedOverGround) {
  const Reading reading = read("GPVTG,230.5,T,229.1,M,5.6,N,10.4,K,A");
  EXPECT_NEAR(reading.course.value(), 230.5 * kDegree, kExact);
  EXPECT_NEAR(reading.speed.value(), 5.6 * 1852 / 3600, kExact);
  EXPECT_NEAR(read("GPVTG,,T,,M,,N,7.2,K").speed.value(), 2, kExact);
  EXPECT_EQ(read("GPVTG,230.5,T,229.1,M,5.6,N,10.4,K,N"), Reading());
}

TEST(Nmea, GgaIsAPositionWithItsSigma) {
  const Reading reading = read("GPGGA,094736,5251.0094,N,00518.8172,W,1,12,0.60,-4,M,46.8,M,,");
  EXPECT_NEAR(reading.position->latitude_deg, 52.850156667, 1e-9);
  EXPECT_NEAR(reading.position->longitude_deg, -5.313620000, 1e-9);
  EXPECT_DOUBLE_EQ(reading.position->sigma.value(), 2.4);
  const auto quality = [](std::string_view q) {
    return read("GPGGA,094736,5251.0,S,00518.8,E," + std::string(q) + ",12,0.60,-4,M,46.8,M,,")
        .position;
  };
  EXPECT_LT(quality("1")->latitude_deg, 0);
  EXPECT_DOUBLE_EQ(quality("4")->sigma.value(), 0.02);
  EXPECT_FALSE(quality("0"));
  EXPECT_FALSE(quality("8"));
  EXPECT_FALSE(read("GPGGA,094736,,,,,1,12,0.60,,M,,M,,").position);
}

TEST(Nmea, RmcIsTimePositionCourseAndVariation) {
  const Reading reading =
      read("GPRMC,204132.25,A,4205.733476,N,08802.041110,W,9.415,21.404,190214,3.9,W,D");
  EXPECT_EQ(reading.utc.value(), 1392842492'250'000'000);  // date -ud '2014-02-19 20:41:32.25'
  EXPECT_NEAR(reading.position->latitude_deg, 42.095557933, 1e-9);
  EXPECT_NEAR(reading.position->longitude_deg, -88.0340185, 1e-9);
  EXPECT_NEAR(reading.speed.value(), 9.415 * 1852 / 3600, kExact);
  EXPECT_NEAR(reading.course.value(), 21.404 * kDegree, kExact);
  EXPECT_NEAR(reading.variation.value(), -3.9 * kDegree, kExact);
  EXPECT_EQ(read("GPRMC,204132,V,4205.7,N,08802.0,W,9.4,21.4,190214,,,N"), Reading());
  EXPECT_EQ(read("GPRMC,000000,A,,,,,,,311299,,").utc.value(), 946598400'000'000'000);
}

TEST(Nmea, XdrGivesRollPitchAndDepthByTheirNames) {
  const Reading reading =
      read("IIXDR,C,,C,AIRTEMP,A,-1.5,D,HEEL,A,2.5,D,TRIM,P,,B,BARO,D,12.25,M,DEPTH");
  EXPECT_NEAR(reading.roll.value(), -1.5 * kDegree, kExact);
  EXPECT_NEAR(reading.pitch.value(), 2.5 * kDegree, kExact);
  EXPECT_DOUBLE_EQ(reading.depth.value(), 12.25);
  const Reading named = read("YXXDR,A,-10,D,PTCH,A,20,D,Roll#1");
  EXPECT_NEAR(named.pitch.value(), -10 * kDegree, kExact);
  EXPECT_NEAR(named.roll.value(), 20 * kDegree, kExact);
  EXPECT_EQ(read("IIXDR,A,-3.9,D,RUDDER,A,95,D,PITCH,P,1.02,B,BARO"), Reading());
}

TEST(Nmea, PashrIsHeadingRollAndPitch) {
  const Reading reading =
      read("PASHR,204132.000,010.51,T,+00.39,-00.79,-00.84,0.151,0.075,0.555,1,0");
  EXPECT_NEAR(reading.heading.value(), 10.51 * kDegree, kExact);
  EXPECT_NEAR(reading.roll.value(), 0.39 * kDegree, kExact);
  EXPECT_NEAR(reading.pitch.value(), -0.79 * kDegree, kExact);
}

TEST(Nmea, PashrOfOtherMeaningsSaysNothing) {
  EXPECT_EQ(decode_body("PASHR,SAT,12,07,130,75,51,U,08,20,40,48,U").reading, Reading());
  EXPECT_EQ(decode_body("PASHR,ATT,372023.00,089.99,-001.04,+000.51,0.0008").reading, Reading());
  EXPECT_EQ(read("PASHR,POS,0,10,204132,3721.08,N,12156.12,W,16.1"), Reading());
}

// gpsd's example of the device's own integers, of which 65536 are a turn.
TEST(Nmea, PtnthtmIsInDegreesOrCounts) {
  const Reading reading = read("PTNTHTM,14223,N,169,N,-43,N,13641,2454");
  EXPECT_NEAR(reading.heading.value(), 14223.0 / 65536 * 360 * kDegree, kExact);
  EXPECT_NEAR(reading.pitch.value(), 169.0 / 65536 * 360 * kDegree, kExact);
  EXPECT_NEAR(reading.roll.value(), -43.0 / 65536 * 360 * kDegree, kExact);
}

TEST(Nmea, PtnthtmLeavesOutWhatIsInAlarm) {
  const Reading reading = read("PTNTHTM,85.9,N,-0.9,O,0.8,H,40.1,0.95");
  EXPECT_NEAR(reading.heading.value(), 85.9 * kDegree, kExact);
  EXPECT_NEAR(reading.pitch.value(), -0.9 * kDegree, kExact);
  EXPECT_FALSE(reading.roll);
}

TEST(Nmea, AnyTalkerIsHeardAndOtherKindsAreUnused) {
  EXPECT_NE(decode_body("HEHDT,1,T").reading.sender, decode_body("GPHDT,1,T").reading.sender);
  EXPECT_TRUE(read("HEHDT,1,T").heading);
  EXPECT_TRUE(read("XXHDT,1,T").heading);
  EXPECT_EQ(decode_body("GPGSV,3,1,12").fault, NmeaFault::unused);
  EXPECT_EQ(decode_body("GPGSV,3,1,12").kind, "GSV");
  EXPECT_EQ(decode_body("PGRME,15.0,M").fault, NmeaFault::unused);
}

TEST(Nmea, RefusesDamagedLinesByTheirFault) {
  EXPECT_EQ(fault_of("$GPHDT,90.0,T*0C"), NmeaFault::none);
  EXPECT_EQ(fault_of("$GPHDT,90.0,T*0c\r\n"), NmeaFault::none);
  EXPECT_EQ(fault_of("\\s:r3,c:1120959341*51\\$GPHDT,90.0,T*0C"), NmeaFault::none);
  EXPECT_EQ(fault_of("$GPHDT,91.0,T*0C"), NmeaFault::wrong_checksum);
  EXPECT_EQ(fault_of("$GPHDT,90.0,T*0"), NmeaFault::wrong_checksum);
  EXPECT_EQ(fault_of("$GPHDT,90.0,T*"), NmeaFault::wrong_checksum);
  EXPECT_EQ(fault_of("$GPHDT,90.0,T"), NmeaFault::no_checksum);
  EXPECT_EQ(fault_of("GPHDT,90.0,T*0C"), NmeaFault::not_nmea);
  EXPECT_EQ(fault_of("$GPHDT,90\x01,T*0C"), NmeaFault::not_nmea);
  EXPECT_EQ(fault_of("!AIVDM,1,1,,B,15MwkT1P37G?fl0EJbR0OwT0@MS,0*4E"), NmeaFault::unused);
  EXPECT_EQ(fault_of(""), NmeaFault::not_nmea);
  EXPECT_EQ(fault_of("$"), NmeaFault::not_nmea);
  EXPECT_EQ(fault_of("\\"), NmeaFault::not_nmea);
}

TEST(Nmea, AFieldThatIsNoNumberSpoilsTheSentence) {
  for (const char* body : {"GPHDT,9O.0,T", "GPHDT,1e2,T", "GPHDT,nan,T", "GPHDT,inf,T",
                           "GPHDT,1.2.3,T", "GPHDT,--1,T", "GPHDT,+-1,T", "GPHDT, 1,T",
                           "GPGGA,094736,5261.0,N,00518.8,E,1,12,0.6,,M,,M,,",  // 61 minutes
                           "GPGGA,094736,9100.0,N,00518.8,E,1,12,0.6,,M,,M,,",  // 91 degrees
                           "GPGGA,094736,5251.0,X,00518.8,E,1,12,0.6,,M,,M,,",
                           "GPRMC,204132,A,,,,,,,310214,,", "GPRMC,254132,A,,,,,,,190214,,",
                           "GPRMC,2041,A,,,,,,,190214,,", "GPRMC,204132,A,,,,,,,1902,,"}) {
    const NmeaSentence sentence = decode_body(body);
    EXPECT_EQ(sentence.fault, NmeaFault::malformed) << body;
    EXPECT_EQ(sentence.reading, Reading()) << body;
  }
}

TEST(NmeaLines, AreTheSameHoweverTheBytesArrive) {
  const std::string stream =
      "half a line\r\n\r\n$A*1\r\n" + std::string(3000, 'x') + "\n$B*2\n$C*3\r$D";
  for (const std::size_t piece :
       {std::size_t{1}, std::size_t{7}, std::size_t{100}, stream.size()}) {
    NmeaLines lines;
    std::vector<std::string> heard;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      lines.feed(stream.substr(at, piece));
      while (const auto line = lines.next()) heard.emplace_back(*line);
    }
    EXPECT_THAT(heard, testing::ElementsAre("half a line", "$A*1", "$B*2", "$C*3")) << piece;
  }
}

// faults.md wants a million lines without a crash. Every checksum is put right again, so that the
// damage reaches the fields; what is then read must still be possible.
TEST(Nmea, AMillionMutatedLinesGiveOnlyPossibleValues) {
  const std::vector<std::string> bodies{
      "HCHDG,98.3,0.5,E,12.6,W",
      "IIHDM,225.6,M",
      "GPHDT,0.41,T",
      "TIROT,-30.0,A",
      "SDDPT,2.4,0.5",
      "SDDBT,17.7,f,5.4,M,3.0,F",
      "GPVTG,230.5,T,229.1,M,5.6,N,10.4,K,A",
      "GPGGA,094736,5251.0094,N,00518.8172,E,1,12,0.60,-4,M,46.8,M,,",
      "GPRMC,204132.00,A,4205.733476,N,08802.041110,W,9.415,21.404,190214,3.9,W,D",
      "IIXDR,C,,C,AIRTEMP,A,-1.0,D,HEEL,A,2.9,D,TRIM,D,12.25,M,DEPTH",
      "PASHR,204132.000,010.51,T,+00.39,-00.79,-00.84,0.151,0.075,0.555,1,0",
      "PTNTHTM,85.9,N,-0.9,N,0.8,N,40.1,0.95",
  };
  constexpr std::string_view kLikely = "0123456789,.-+*$ENSWTMA\r\n";
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) { return random() % n; };
  std::size_t read = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    std::string body = bodies[below(bodies.size())];
    for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
      const std::size_t at = below(body.size() + 1);
      const char c = below(4) == 0 ? static_cast<char>(below(256)) : kLikely[below(kLikely.size())];
      switch (below(4)) {
        case 0:
          body.insert(at, 1, c);
          break;
        case 1:
          body.erase(at, 1 + below(5));
          break;
        case 2:
          body.resize(at);
          break;
        default:
          if (at < body.size()) body[at] = c;
      }
    }
    const NmeaSentence sentence = decode_body(body);
    const Reading& r = sentence.reading;
    if (sentence.fault != NmeaFault::none) {
      ASSERT_EQ(r, Reading()) << body;
      continue;
    }
    ++read;
    const auto possible = [](const std::optional<double>& value, double lowest, double highest) {
      return !value || (*value >= lowest && *value <= highest);
    };
    constexpr double kPi = std::numbers::pi;
    ASSERT_TRUE(possible(r.roll, -kPi, kPi) && possible(r.pitch, -kPi / 2, kPi / 2)) << body;
    for (const auto& heading : {r.heading, r.magnetic_heading, r.course})
      ASSERT_TRUE(possible(heading, 0, 2 * kPi) && heading != 2 * kPi) << body;
    ASSERT_TRUE(possible(r.variation, -kPi, kPi) && possible(r.speed, 0, 600)) << body;
    ASSERT_TRUE(possible(r.depth, -12000, 12000) && possible(r.altitude, 0, 12000)) << body;
    ASSERT_TRUE(possible(r.turn_rate, -2.1, 2.1)) << body;
    if (r.position) {
      ASSERT_TRUE(possible(r.position->latitude_deg, -90, 90)) << body;
      ASSERT_TRUE(possible(r.position->longitude_deg, -180, 180)) << body;
    }
  }
  EXPECT_GT(read, 300'000u);  // else the mutations never reach a field
}

}  // namespace
}  // namespace nadir::sensors

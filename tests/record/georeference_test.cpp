// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The files for GIS of a dive whose origin is known, read back by GDAL.
#include <gtest/gtest.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "nadir/record/recover.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;
using std::filesystem::path;

constexpr reference::Geodetic kSouth{-33.861, 151.2123, 20}, kNorth{60.4, 3.2, 0};
constexpr double kMillimetre = 1e-3;

struct Recorded {
  Recorded(const SmallDive& small_dive, std::optional<reference::Geodetic> at, bool finish = true)
      : small(small_dive) {
    DiveInfo info = small.info();
    info.origin = at;
    Dive dive(scratch / "dive", info, {});
    for (int i = 0; i < small.images; ++i)
      EXPECT_TRUE(dive.add(small.entry(static_cast<std::uint64_t>(i))).empty());
    EXPECT_TRUE(!finish || dive.finish({{"images_hz", 2.0}}).empty());
  }
  path operator/(const path& name) const { return scratch / "dive" / name; }
  json dive_json() const { return json::parse(read_text(*this / "dive.json")); }

  SmallDive small;
  ScratchFolder scratch;
};

// Of a point of a survey whose y axis is the grid's north, by another way than the grid.
struct Exact {
  double latitude = 0, longitude = 0, height = 0, easting = 0, northing = 0;
  int zone = 0;

  Exact(const reference::Geodetic& o, double x, double y, double z = 0) {
    bool north = true;
    double convergence = 0, scale = 0;
    using GeographicLib::UTMUPS;
    UTMUPS::Forward(o.latitude_deg, o.longitude_deg, zone, north, easting, northing, convergence,
                    scale);
    const double c = std::cos(convergence * M_PI / 180), s = std::sin(convergence * M_PI / 180);
    GeographicLib::LocalCartesian(o.latitude_deg, o.longitude_deg, o.height)
        .Reverse(c * x + s * y, c * y - s * x, z, latitude, longitude, height);
    UTMUPS::Forward(latitude, longitude, zone, north, easting, northing);
  }
};

std::string output_of(const std::string& command) {
  std::string output;
  std::FILE* pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
  if (!pipe) return output;
  char buffer[4096];
  while (const std::size_t size = std::fread(buffer, 1, sizeof buffer, pipe))
    output.append(buffer, size);
  ::pclose(pipe);
  return output;
}

// x, y: of the outer corner of its upper left pixel, in the survey.
void expect_placed(const path& raster, const reference::Geodetic& origin, int epsg, double x,
                   double y, double width, double height) {
  const json info = json::parse(output_of("gdalinfo -json " + raster.string()));
  const auto wkt = info["coordinateSystem"]["wkt"].get<std::string>();
  EXPECT_NE(wkt.find("ID[\"EPSG\"," + std::to_string(epsg) + "]"), std::string::npos) << wkt;
  EXPECT_EQ(info["metadata"][""]["SCALE"], "metres, scale from the pair of cameras, sigma 0.100 %");
  const json corners = info["cornerCoordinates"];
  const json place = info["geoTransform"];
  const std::vector<std::tuple<const char*, double, double>> kCorners{
      {"upperLeft", 0, 0}, {"lowerLeft", 0, 1}, {"lowerRight", 1, 1}, {"upperRight", 1, 0}};
  std::ostringstream pixels;
  for (const auto& [name, right, down] : kCorners) {
    pixels << right * info["size"][0].get<double>() << ' ' << down * info["size"][1].get<double>()
           << "\\n";
  }
  // The coordinate system as GDAL understands it.
  std::istringstream geographic(output_of("printf '" + pixels.str() +
                                          "' | gdaltransform -t_srs EPSG:4326 " + raster.string()));
  for (const auto& [name, right, down] : kCorners) {
    const Exact exact(origin, x + right * width, y - down * height);
    EXPECT_NEAR(corners[name][0].get<double>(), exact.easting, kMillimetre) << name;
    EXPECT_NEAR(corners[name][1].get<double>(), exact.northing, kMillimetre) << name;
    double longitude = 0, latitude = 0, elevation = 0;
    ASSERT_TRUE(geographic >> longitude >> latitude >> elevation) << geographic.str();
    constexpr double kDegree_m = 111'320;
    EXPECT_NEAR(latitude, exact.latitude, kMillimetre / kDegree_m) << name;
    EXPECT_NEAR(longitude, exact.longitude, kMillimetre / kDegree_m) << name;
  }
  EXPECT_EQ(place[2], 0);  // north up
  EXPECT_EQ(place[4], 0);
}

TEST(GeoreferencedDive, LiesOnTheUtmGridAsGdalReadsIt) {
  ASSERT_FALSE(output_of("gdalinfo --version").empty()) << "install gdal-bin";
  for (const auto& [origin, epsg] : {std::pair{kSouth, 32756}, {kNorth, 32632}}) {
    const Recorded dive({}, origin);
    // Tiles (0, 0) and (1, -1) to (1, 2): the raster starts one tile left of pixel (0, 0).
    expect_placed(dive / "mosaic2d/mosaic-000.png", origin, epsg, -2.56 - 0.005, 2.005, 4 * 2.56,
                  2 * 2.56);
    expect_placed(dive / "projected/000003.png", origin, epsg, 0.12 - 0.005, 2.005, 0.12, 0.08);
    const std::string mosaics = (dive / "mosaics.vrt").string();
    EXPECT_NE(
        output_of("gdalbuildvrt " + mosaics + ' ' + (dive / "mosaic2d/mosaic-000.png").string() +
                  ' ' + (dive / "projected/000003.png").string())
            .find("done"),
        std::string::npos);
  }
}

TEST(GeoreferencedDive, HasATrackOnTheGridAndOnTheEarth) {
  const Recorded dive({}, kSouth);
  std::ifstream track(dive / "track.csv");
  std::string line;
  ASSERT_TRUE(std::getline(track, line));
  EXPECT_EQ(line, "image,seconds,easting,northing,height,latitude,longitude,submap");
  for (std::uint64_t image = 0; image < 4; ++image) {
    ASSERT_TRUE(std::getline(track, line));
    std::ranges::replace(line, ',', ' ');
    std::istringstream words(line);
    double number = 0, seconds = 0, easting = 0, northing = 0, height = 0, latitude = 0,
           longitude = 0, submap = 1;
    words >> number >> seconds >> easting >> northing >> height >> latitude >> longitude >> submap;
    ASSERT_TRUE(words) << line;
    const Eigen::Vector3d x = dive.small.pose(image).translation;
    const Exact exact(kSouth, x.x(), x.y());
    EXPECT_EQ(number, static_cast<double>(image));
    EXPECT_NEAR(seconds, nadir::seconds(dive.small.time(image)), 1e-6);
    EXPECT_NEAR(easting, exact.easting, kMillimetre);
    EXPECT_NEAR(northing, exact.northing, kMillimetre);
    EXPECT_NEAR(height, 20 + x.z(), kMillimetre);
    EXPECT_NEAR(latitude, exact.latitude, 1e-8);
    EXPECT_NEAR(longitude, exact.longitude, 1e-8);
    EXPECT_EQ(submap, 0);
  }
  EXPECT_FALSE(std::getline(track, line));
}

TEST(GeoreferencedDive, SaysWhereItIs) {
  const json origin = Recorded({}, kNorth).dive_json()["origin"];
  EXPECT_EQ(origin["latitude_deg"], 60.4);
  EXPECT_EQ(origin["longitude_deg"], 3.2);
  EXPECT_EQ(origin["height_m"], 0);
  EXPECT_EQ(origin["placed"], true);
  EXPECT_EQ(origin["epsg"], 32632);
  EXPECT_EQ(origin["utm_zone"], "32N");
  const Exact exact(kNorth, 0, 0);
  EXPECT_NEAR(origin["easting_m"].get<double>(), exact.easting, 1e-6);
  EXPECT_NEAR(origin["northing_m"].get<double>(), exact.northing, 1e-6);
  // (3.2 - 9) degrees of longitude times the sine of the latitude, to the first order.
  EXPECT_NEAR(origin["convergence_deg"].get<double>(), -5.8 * std::sin(60.4 * M_PI / 180), 0.02);
  EXPECT_NEAR(origin["scale_factor"].get<double>(),
              0.9996 * (1 + 0.5 * std::pow(0.32e6 / 6.39e6, 2)), 5e-5);
}

TEST(GeoreferencedDive, IsRecoveredAsItWouldHaveBeenMade) {
  SmallDive small;
  small.with_tiles = false;  // which are made of the projected images on recovery
  const Recorded finished(small, kNorth), cut_off(small, kNorth, false);
  EXPECT_TRUE(recover(cut_off / "").whole());
  auto made = read_all(finished / ""), recovered = read_all(cut_off / "");
  EXPECT_EQ(json::parse(recovered["dive.json"])["origin"],
            json::parse(made["dive.json"])["origin"]);
  for (auto* files : {&made, &recovered}) {
    files->erase("dive.json");
    std::erase_if(*files, [](const auto& file) {
      return file.first.starts_with("mosaic2d") || file.first.starts_with("journal");
    });
  }
  EXPECT_TRUE(made.contains("track.csv"));
  EXPECT_EQ(recovered, made);
  // And once more of nothing but its journal and its images.
  const auto whole = read_all(cut_off / "");
  for (const auto& [name, text] : whole) {
    if (!name.starts_with("journal") && !(name.starts_with("projected") && name.ends_with(".png")))
      std::filesystem::remove(cut_off / name);
  }
  (void)recover(cut_off / "");
  auto again = read_all(cut_off / "");
  EXPECT_EQ(again["track.csv"], recovered["track.csv"]);
  EXPECT_EQ(again["projected/000003.pgw"], recovered["projected/000003.pgw"]);
}

// All but dive.json, where it is said.
void expect_as_without_origin(const path& folder, const SmallDive& small, std::string_view reason) {
  auto with = read_all(folder), without = read_all(Recorded(small, std::nullopt) / "");
  const json dive = json::parse(with["dive.json"]);
  EXPECT_EQ(dive["origin"]["placed"], false);
  EXPECT_NE(dive["origin"]["reason"].get<std::string>().find(reason), std::string::npos)
      << dive["origin"];
  EXPECT_FALSE(json::parse(without["dive.json"]).contains("origin"));
  for (auto* files : {&with, &without}) {
    files->erase("dive.json");
    files->erase("journal-000.nadir");
  }
  EXPECT_EQ(with, without);
}

TEST(UnscaledDive, KeepsItsOwnCoordinates) {
  SmallDive small;
  small.metric = false;
  const Recorded dive(small, kNorth);
  expect_as_without_origin(dive / "", small, "scale");
}

TEST(DiveOfDoubtfulNorth, KeepsItsOwnCoordinates) {
  for (const bool with_origin : {true, false}) {
    const SmallDive small;
    const ScratchFolder scratch;
    {
      DiveInfo info = small.info();
      if (with_origin) info.origin = kNorth;
      Dive dive(scratch / "dive", info, {});
      Entry entry = small.entry(0);
      auto orientation = std::make_shared<Orientation>(*entry.orientation);
      orientation->axes = SurveyAxes::doubtful;
      entry.orientation = orientation;
      ASSERT_TRUE(dive.add(entry).empty());
      ASSERT_TRUE(dive.finish({}).empty());
    }
    const json dive = json::parse(read_text(scratch / "dive/dive.json"));
    EXPECT_EQ(dive.contains("origin"), with_origin);
    if (with_origin) {
      EXPECT_NE(dive["origin"]["reason"].get<std::string>().find("AHRS"), std::string::npos);
    }
    EXPECT_FALSE(std::filesystem::exists(scratch / "dive/track.csv"));
    EXPECT_NE(read_text(scratch / "dive/mosaic2d/mosaic-000.png.aux.xml").find("LOCAL_CS"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace nadir::record

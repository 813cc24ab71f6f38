// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/geodetic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <numbers>

#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kEarth = 6'371'000;  // metres

TEST(ParseOrigin, TakesTwoNumbersOrThree) {
  EXPECT_FALSE(parse_origin("").has_value());
  EXPECT_FALSE(parse_origin("  ").has_value());
  const auto place = parse_origin(" 43.2965  5.3698 ");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->latitude_deg, 43.2965);
  EXPECT_EQ(place->longitude_deg, 5.3698);
  EXPECT_EQ(place->height, 0);
  const auto lake = parse_origin("-15.8 -69.4 3812.5");
  ASSERT_TRUE(lake);
  EXPECT_EQ(lake->longitude_deg, -69.4);
  EXPECT_EQ(lake->height, 3812.5);
}

TEST(ParseOrigin, RefusesWhatIsNoPlaceAndSaysWhatItMustBe) {
  for (const auto& [text, said] : std::vector<std::pair<std::string, std::string>>{
           {"43.2965", "LATITUDE LONGITUDE"},
           {"43,2965 5,3698", "LATITUDE LONGITUDE"},
           {"43.2965, 5.3698", "LATITUDE LONGITUDE"},
           {"43.2965N 5.3698E", "LATITUDE LONGITUDE"},
           {"43.2965 5.3698 10 1", "LATITUDE LONGITUDE"},
           {"43.2965 5.3698 -", "LATITUDE LONGITUDE"},
           {"85 0", "latitude"},
           {"-80.5 0", "latitude"},
           {"nan 0", "latitude"},
           {"5.3698 181", "longitude"},
           {"43 5 10000", "height"},
           {"43 5 inf", "height"}}) {
    try {
      parse_origin(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("reference.origin")) << text;
      EXPECT_THAT(error.what(), testing::HasSubstr(said)) << text;
    }
  }
}

TEST(UtmGrid, KnowsItsZone) {
  struct Place {
    Geodetic at;
    int zone;
    bool north;
    int epsg;
  };
  for (const Place& place :
       {Place{{43.2965, 5.3698}, 31, true, 32631},
        Place{{60.4, 5.3}, 32, true, 32632},   // south-west Norway
        Place{{78.2, 15.6}, 33, true, 32633},  // Svalbard
        Place{{-33.86, 151.2}, 56, false, 32756}, Place{{0, -180}, 1, true, 32601}}) {
    const UtmGrid grid(place.at);
    EXPECT_EQ(grid.zone(), place.zone);
    EXPECT_EQ(grid.is_north(), place.north);
    EXPECT_EQ(grid.epsg(), place.epsg);
  }
  EXPECT_THROW(UtmGrid({89, 0}), InputError);
}

// Survey axes turned by the convergence against the plane that touches the earth at the origin.
Vector2d exact(const UtmGrid& grid, const Vector2d& x_in_survey) {
  const double c = std::cos(grid.convergence()), s = std::sin(grid.convergence());
  const double east = c * x_in_survey.x() + s * x_in_survey.y();
  const double north = c * x_in_survey.y() - s * x_in_survey.x();
  const Geodetic& o = grid.origin();
  double latitude = 0, longitude = 0, height = 0;
  GeographicLib::LocalCartesian(o.latitude_deg, o.longitude_deg, o.height)
      .Reverse(east, north, 0, latitude, longitude, height);
  int zone = 0;
  bool is_north = true;
  Vector2d place;
  GeographicLib::UTMUPS::Forward(latitude, longitude, zone, is_north, place.x(), place.y(),
                                 grid.zone());
  if (is_north != grid.is_north()) place.y() += grid.is_north() ? -1e7 : 1e7;
  return place;
}

// At the middle and the edges of zones, on both hemispheres, at sea and on a mountain lake.
TEST(UtmGrid, DiffersFromTheExactConversionByNoMoreThanItsSecondOrder) {
  double largest = 0;
  for (const Geodetic& origin :
       {Geodetic{43.2965, 5.3698, 0}, Geodetic{0.001, 2.999, 0}, Geodetic{-0.001, 0.001, 0},
        Geodetic{60.4, 3.01, 0}, Geodetic{-54.8, -68.3, 0}, Geodetic{78.2, 15.6, 30},
        Geodetic{-15.8, -69.4, 3812}, Geodetic{31.5, 35.5, -430}, Geodetic{20, 9, 0}}) {
    const UtmGrid grid(origin);
    const double off_centre = std::abs(grid(Vector2d(0, 0)).x() - 500'000);
    for (const double distance : {10.0, 100.0, 1000.0}) {
      // Conformal: the second order is this, in whichever direction. The third is of the sphere,
      // and at a height the two radii of curvature differ.
      const double second = off_centre / (2 * kEarth * kEarth) * distance * distance;
      const double third = distance * distance * distance / (2 * kEarth * kEarth);
      const double radii = 0.004 * std::abs(origin.height) / kEarth * distance;
      for (int direction = 0; direction < 8; ++direction) {
        const double angle = direction * std::numbers::pi / 4;
        const Vector2d x = distance * Vector2d(std::cos(angle), std::sin(angle));
        const double error = (grid(x) - exact(grid, x)).norm();
        EXPECT_LE(error, 1.05 * second + third + radii + 1e-7)
            << origin.latitude_deg << ' ' << origin.longitude_deg << ' ' << distance;
        largest = std::max(largest, error);
      }
    }
  }
  EXPECT_LT(largest, 0.007);
  EXPECT_GT(largest, 0.002);  // that the edges were looked at
}

TEST(UtmGrid, MovesAWorldFileWithItsPixels) {
  const UtmGrid grid({60.4, 5.3, 0});
  const WorldFile survey{0.01, 0.001, 0.002, -0.01, 2, 3};
  const WorldFile moved = grid(survey);
  for (const Vector2d& pixel : {Vector2d(0, 0), {1000, 0}, {0, 1000}, {333, 777}}) {
    const Vector2d expected = grid(survey(pixel.x(), pixel.y()));
    EXPECT_LT((moved(pixel.x(), pixel.y()) - expected).norm(), 1e-8);
  }
}

TEST(UtmGrid, TellsLatitudeLongitudeAndHeight) {
  const UtmGrid grid({-33.86, 151.2, 12});
  const auto origin = grid.geodetic({0, 0, 0});
  ASSERT_TRUE(origin);
  EXPECT_NEAR(origin->latitude_deg, -33.86, 1e-11);
  EXPECT_NEAR(origin->longitude_deg, 151.2, 1e-11);
  EXPECT_EQ(origin->height, 12);
  const auto place = grid.geodetic({30, -40, 2.5});
  ASSERT_TRUE(place);
  EXPECT_EQ(place->height, 14.5);
  int zone = 0;
  bool north = true;
  Vector2d there;
  GeographicLib::UTMUPS::Forward(place->latitude_deg, place->longitude_deg, zone, north, there.x(),
                                 there.y());
  EXPECT_LT((there - grid(Vector2d(30, -40))).norm(), 1e-6);
  EXPECT_FALSE(grid.geodetic({1e9, 0, 0}).has_value());
}

TEST(UtmGrid, FindsPlacesInTheSurvey) {
  // The last one is across the equator.
  for (const auto& [latitude, shift] : {std::pair(-33.86, Vector2d(30, -40)),
                                        {43.3, Vector2d(-5000, 700)},
                                        {0.0001, Vector2d(12, -60)}}) {
    const UtmGrid grid({latitude, 151.2, 12});
    const auto place = grid.geodetic({shift.x(), shift.y(), 0});
    ASSERT_TRUE(place);
    const auto there = grid.in_survey(*place);
    ASSERT_TRUE(there);
    EXPECT_LT((*there - shift).norm(), 1e-5);
  }
  EXPECT_FALSE(UtmGrid({43.3, 5.4, 0}).in_survey({43.3, -170, 0}).has_value());
}

}  // namespace
}  // namespace nadir::reference

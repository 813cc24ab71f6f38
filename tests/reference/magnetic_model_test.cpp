// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/magnetic_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nadir::reference {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Time time_of(double days_since_1970) { return from_seconds(86400 * days_since_1970); }

// The model's published test values.
TEST(MagneticField, IsThatOfTheModelEverywhere) {
  struct Row {
    double year, height_km, latitude, longitude, north, east, down;
  };
  for (const Row& row : {Row{2025.0, 28, 89, -121, -255.388723, -1482.460628, 56194.288771},
                         Row{2025.0, 66, 14, 143, 35003.441364, -116.624818, 7966.315182},
                         Row{2025.5, 22, -37, 140, 21404.761773, 3498.897430, -55397.587760},
                         Row{2026.0, 47, -72, -22, 18280.800055, -2024.105320, -33397.486160},
                         Row{2026.5, 44, -46, -42, 13863.176808, -2785.834358, -19744.304022},
                         Row{2027.0, 37, -66, -5, 16390.771268, -5079.626554, -28608.243575},
                         Row{2027.0, 61, 59, -77, 10437.775689, -3087.391846, 54397.713552},
                         Row{2027.5, 96, -46, -85, 18947.658009, 6129.590452, -21631.434316},
                         Row{2028.0, 30, -36, -64, 17341.333537, -1411.102609, -14639.967305},
                         Row{2028.5, 39, -65, -88, 17946.905687, 10131.662696, -35982.872979},
                         Row{2029.0, 95, -60, -59, 17893.018948, 2700.105868, -26011.845842},
                         Row{2029.0, 41, 42, -19, 24439.977735, -1762.893879, 36929.897501},
                         Row{2029.5, 18, 9, -172, 30520.999126, 4966.941695, 8779.472279}}) {
    const Eigen::Vector3d field =
        magnetic_field({row.latitude, row.longitude, 1000 * row.height_km}, row.year);
    constexpr double kRounding = 0.001;  // nanotesla
    EXPECT_NEAR(field.y(), row.north, kRounding) << row.latitude << ' ' << row.longitude;
    EXPECT_NEAR(field.x(), row.east, kRounding) << row.latitude << ' ' << row.longitude;
    EXPECT_NEAR(-field.z(), row.down, kRounding) << row.latitude << ' ' << row.longitude;
  }
}

// By an independent implementation of the model.
TEST(MagneticVariation, IsThatOfThePlaceAndTheDay) {
  constexpr double k2025 = 20089, k2026June1 = 20605, k2027July2Noon = 21001.5, k2028 = 21184,
                   k2029June1 = 21701, k2029December1 = 21884;
  struct Row {
    double day, latitude, longitude, variation;
  };
  for (const Row& row :
       {Row{k2025, 80, 0, 1.2815}, Row{k2025, 0, 120, -0.1583}, Row{k2025, -80, -120, 68.7754},
        Row{k2027July2Noon, 80, 0, 2.5941}, Row{k2027July2Noon, 0, 120, -0.2415},
        Row{k2027July2Noon, -80, -120, 68.4861}, Row{k2026June1, 43.296, 5.37, 2.7821},
        Row{k2026June1, -33.86, 151.2, 12.8119}, Row{k2026June1, 37.8, -122.4, 12.8663},
        Row{k2026June1, -54.8, -68.3, 11.6633}, Row{k2028, 90, 0, 20.2762},
        Row{k2028, -90, 0, -31.9812}, Row{k2028, 89.9, -75, -54.4234},
        Row{k2028, -77.85, 166.67, 139.8629}, Row{k2029December1, 78.2, 15.6, 14.2485},
        Row{k2029June1, 0, 0, -3.4703}}) {
    const MagneticVariation found =
        magnetic_variation({row.latitude, row.longitude, 0}, time_of(row.day));
    EXPECT_TRUE(found.is_within_model());
    EXPECT_NEAR(found.angle / kDegree, row.variation, 0.02) << row.latitude << ' ' << row.longitude;
  }
}

TEST(MagneticVariation, OutsideTheModelsYearsIsThatOfTheNearestAndSaysSo) {
  const Geodetic place{78.2, 15.6, 0};
  constexpr double k2025 = 20089, k2030 = 21915, k2040 = 25567;
  const MagneticVariation unset = magnetic_variation(place, 0),
                          first = magnetic_variation(place, time_of(k2025)),
                          last = magnetic_variation(place, time_of(k2030)),
                          late = magnetic_variation(place, time_of(k2040));
  EXPECT_FALSE(unset.is_within_model());
  EXPECT_EQ(unset.year, 1970);
  EXPECT_EQ(unset.angle, first.angle);
  EXPECT_TRUE(last.is_within_model());
  EXPECT_FALSE(late.is_within_model());
  EXPECT_EQ(late.angle, last.angle);
  EXPECT_GT(last.angle - first.angle, 2 * kDegree);
}

}  // namespace
}  // namespace nadir::reference

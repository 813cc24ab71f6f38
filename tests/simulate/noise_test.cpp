// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random.hpp"

namespace nadir::simulate {
namespace {

TEST(Noise, StaysInRangeAndHasNoStepsAcrossTheLattice) {
  constexpr double kStep = 1e-4;
  constexpr float kSteepest = 2 * 1.875f * static_cast<float>(kStep) * 1.01f;  // of the fade curve
  for (double x = -3; x < 3; x += kStep) {
    const float here = noise(x, 0.7 * x - 1, 5), next = noise(x + kStep, 0.7 * x - 1, 5);
    ASSERT_LE(std::abs(here), 1.0f);
    ASSERT_LE(std::abs(next - here), kSteepest) << x;
  }
}

TEST(Noise, DependsOnPlaceAndSeedAlone) {
  EXPECT_EQ(noise(12.3, -4.5, 1), noise(12.3, -4.5, 1));
  EXPECT_NE(noise(12.3, -4.5, 1), noise(12.3, -4.5, 2));
  EXPECT_NE(noise(12.3, -4.5, 1), noise(-4.5, 12.3, 1));
  const Eigen::Vector3d x(0.3, 0.4, -7.2);
  EXPECT_EQ(noise(x, 1), noise(x, 1));
  EXPECT_NE(noise(x, 1), noise(x, 2));
}

TEST(Noise, LeavesOutWhatAPixelCannotResolve) {
  EXPECT_EQ(visible(0.01, 0.01), 0.0f);
  EXPECT_EQ(visible(0.02, 0.01), 1.0f);
  const Fractal grain{0.016, 3, 1, 9};
  EXPECT_EQ(grain(0.5, 0.5, 0.02), 0.0f);
  EXPECT_NE(grain(0.5, 0.5, 0.001), 0.0f);
}

TEST(Noise, CellsAreNearestToTheirOwnSeedPoint) {
  for (double x = -2; x < 2; x += 0.0371) {
    const Cell here = cell(x, 2.3 * x, 4);
    EXPECT_NEAR(here.from.norm(), here.distance, 1e-6f);
    EXPECT_GE(here.border, 0.0f);
    // A step towards the seed point stays in the cell.
    const double inward = 0.5;
    const Cell inside = cell(x - inward * static_cast<double>(here.from.x()),
                             2.3 * x - inward * static_cast<double>(here.from.y()), 4);
    EXPECT_EQ(inside.id, here.id);
  }
}

TEST(Random, HasTheMomentsOfItsDistributions) {
  constexpr int kNumber = 40000;
  Random random(3);
  double mean = 0, square = 0, uniform = 0;
  for (int i = 0; i < kNumber; ++i) {
    const double x = random.normal();
    mean += x / kNumber;
    square += x * x / kNumber;
    uniform += random.uniform() / kNumber;
  }
  EXPECT_NEAR(mean, 0, 4 / std::sqrt(kNumber));
  EXPECT_NEAR(square, 1, 4 * std::sqrt(2.0 / kNumber));
  EXPECT_NEAR(uniform, 0.5, 4 * std::sqrt(1.0 / 12 / kNumber));
}

}  // namespace
}  // namespace nadir::simulate

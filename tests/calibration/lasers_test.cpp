// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/calibration/lasers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nadir/core/check.hpp"
#include "temporary_file.hpp"

namespace nadir::calibration {
namespace {

Lasers load(const std::string& content) { return load_lasers(TemporaryFile(content).path()); }

TEST(Lasers, ReadsAllThatIsKnown) {
  const Lasers lasers = load(R"(%YAML:1.0
---
separation_m: 1.0000000000000001e-01
colour: red
wavelength_nm: 635
parallel_to_optical_axis: 1
origins_camera_m: !!opencv-matrix
   rows: 2
   cols: 3
   dt: d
   data: [ -0.05, 0.062, 0.09, 0.05,
       0.062, 0.09 ]
direction_camera: !!opencv-matrix
   rows: 1
   cols: 3
   dt: d
   data: [ 0., 0., 2. ]
)");
  EXPECT_DOUBLE_EQ(lasers.separation, 0.1);
  EXPECT_EQ(lasers.colour, LaserColour::red);
  EXPECT_TRUE(lasers.parallel_to_optical_axis);
  ASSERT_EQ(lasers.origins_in_camera.size(), 2u);
  EXPECT_EQ(lasers.origins_in_camera[1], Eigen::Vector3d(0.05, 0.062, 0.09));
  EXPECT_EQ(lasers.direction_in_camera, Eigen::Vector3d::UnitZ());
}

TEST(Lasers, NeedsOnlyTheSeparation) {
  const Lasers lasers = load("separation_m: 0.2\n");
  EXPECT_DOUBLE_EQ(lasers.separation, 0.2);
  EXPECT_EQ(lasers.colour, LaserColour::green);
  EXPECT_TRUE(lasers.origins_in_camera.empty());
  EXPECT_FALSE(lasers.direction_in_camera);
}

TEST(Lasers, RefusesWhatCannotBe) {
  EXPECT_THROW(load("colour: green\n"), InputError);
  EXPECT_THROW(load("separation_m: 0\n"), InputError);
  EXPECT_THROW(load("separation_m: 100\n"), InputError);
  EXPECT_THROW(load("separation_m: 0.1\ncolour: mauve\n"), InputError);
  EXPECT_THROW(load("separation_m: 0.1\ndirection_camera: 3\n"), InputError);
}

}  // namespace
}  // namespace nadir::calibration

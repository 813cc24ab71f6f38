// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nadir/core/check.hpp"
#include "nadir/reference/laser_scale.hpp"
#include "nadir/simulate/survey.hpp"

namespace nadir::reference {
namespace {

using calibration::LaserColour, calibration::Lasers;
using Eigen::Vector2d, Eigen::Vector3d;

const CameraModel kCamera{
    640, 480, 400, 400, 321.3, 238.6, LensModel::brown_conrady, {0.1, 0.03, 4e-4, -5e-4, 0.004}};

Lasers two_lasers(LaserColour colour = LaserColour::green) {
  Lasers lasers;
  lasers.separation = 0.1;
  lasers.colour = colour;
  lasers.parallel_to_optical_axis = true;
  lasers.origins_in_camera = {{-0.05, 0.06, 0.09}, {0.05, 0.06, 0.09}};
  return lasers;
}

// A grey seabed with noise, on which spots are lit in linear light.
class Seabed {
 public:
  Seabed() : light_(kCamera.height, kCamera.width, cv::Vec3f(0.2f, 0.2f, 0.2f)) {
    cv::Mat3f texture(light_.size());
    cv::RNG random(11);
    random.fill(texture, cv::RNG::NORMAL, 0, 0.01);
    light_ += texture;
  }

  void light(const Vector2d& centre, const cv::Vec3f& colour, double sigma = 1.5) {
    for (int y = 0; y < light_.rows; ++y) {
      for (int x = 0; x < light_.cols; ++x) {
        const double squared = (Vector2d(x, y) - centre).squaredNorm();
        light_(y, x) += static_cast<float>(std::exp(-squared / (2 * sigma * sigma))) * colour;
      }
    }
  }

  /// Where the beams meet the ground that is `distance` from the lasers.
  void light_dots(const Lasers& lasers, double first, double second,
                  const cv::Vec3f& colour = {0.1f, 0.6f, 0.1f}) {
    light(pixel(lasers, 0, first), colour);
    light(pixel(lasers, 1, second), colour);
  }

  static Vector2d pixel(const Lasers& lasers, std::size_t laser, double distance) {
    const Vector3d along = lasers.direction_in_camera.value_or(Vector3d::UnitZ());
    return kCamera.project(lasers.origins_in_camera[laser] + distance * along).value();
  }

  Frame frame() const {
    Frame frame;
    frame.image = 5;
    auto rig = std::make_shared<CameraRig>();
    rig->left = kCamera;
    frame.rig = rig;
    cv::Mat shown;
    cv::pow(cv::max(light_, 0), 1 / 2.2, shown);
    shown.convertTo(frame.colour, CV_8U, 255);
    return frame;
  }

 private:
  cv::Mat3f light_;
};

void expect_dots(const std::optional<LaserDots>& dots, const Lasers& lasers, double first,
                 double second, double tolerance_px) {
  ASSERT_TRUE(dots);
  EXPECT_EQ(dots->image, 5u);
  const std::array distances{first, second};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector2d wanted = Seabed::pixel(lasers, i, distances[i]);
    EXPECT_LT((dots->dots[i].pixel - wanted).norm(), tolerance_px) << "dot " << i;
    const Vector3d along = lasers.direction_in_camera.value_or(Vector3d::UnitZ());
    const Vector3d vanishing = lasers.origins_in_camera[i] + 1e6 * along;
    const Vector3d place = lasers.origins_in_camera[i] + distances[i] * along;
    const double lever_px = kCamera.fx * (place / place.z() - vanishing / vanishing.z()).norm();
    EXPECT_NEAR(dots->dots[i].distance / distances[i], 1, tolerance_px / lever_px) << "dot " << i;
    EXPECT_LT((kCamera.unproject(dots->dots[i].pixel).value() - dots->dots[i].ray).norm(), 1e-9);
  }
}

TEST(LaserDots, AreFoundFromNearToFar) {
  for (const double distance : {0.4, 0.8, 1.5, 3.0}) {
    Seabed seabed;
    seabed.light_dots(two_lasers(), distance, distance);
    SCOPED_TRACE(distance);
    expect_dots(find_laser_dots(seabed.frame(), two_lasers()), two_lasers(), distance, distance,
                0.1);
  }
}

TEST(LaserDots, OfSlantingBeamsAreFound) {
  Lasers lasers = two_lasers();
  lasers.direction_in_camera = Vector3d(0.1, -0.2, 1).normalized();
  lasers.separation = 0.1 * std::sqrt(1 - 0.01 / 1.05);  // across the beams
  Seabed seabed;
  seabed.light_dots(lasers, 1.2, 1.25);
  expect_dots(find_laser_dots(seabed.frame(), lasers), lasers, 1.2, 1.25, 0.1);
  EXPECT_FALSE(find_laser_dots(seabed.frame(), two_lasers()));
}

TEST(LaserDots, OfEveryColourAreFoundByThatColourOnly) {
  const std::map<LaserColour, cv::Vec3f> colours{{LaserColour::red, {0.1f, 0.1f, 0.6f}},
                                                 {LaserColour::green, {0.1f, 0.6f, 0.1f}},
                                                 {LaserColour::blue, {0.6f, 0.1f, 0.1f}}};
  for (const auto& [lit, light] : colours) {
    Seabed seabed;
    seabed.light_dots(two_lasers(), 1.5, 1.5, light);
    for (const auto& [sought, unused] : colours) {
      EXPECT_EQ(find_laser_dots(seabed.frame(), two_lasers(sought)).has_value(), lit == sought);
    }
  }
}

TEST(LaserDots, ReliefBetweenThemIsAllowedAndAStepIsNot) {
  Seabed relief, step;
  relief.light_dots(two_lasers(), 1.5, 1.6);
  step.light_dots(two_lasers(), 1.5, 2.0);
  expect_dots(find_laser_dots(relief.frame(), two_lasers()), two_lasers(), 1.5, 1.6, 0.1);
  EXPECT_FALSE(find_laser_dots(step.frame(), two_lasers()));
}

TEST(LaserDots, ClippedDotsAreMeasuredAllTheSame) {
  Seabed seabed;
  seabed.light_dots(two_lasers(), 1.5, 1.5, {0.4f, 3, 0.4f});
  const Frame frame = seabed.frame();
  const Vector2d dot = Seabed::pixel(two_lasers(), 0, 1.5);
  ASSERT_EQ(frame.colour.at<cv::Vec3b>(static_cast<int>(std::lround(dot.y())),
                                       static_cast<int>(std::lround(dot.x())))[1],
            255);
  expect_dots(find_laser_dots(frame, two_lasers()), two_lasers(), 1.5, 1.5, 0.1);
}

TEST(LaserDots, NoneNorOneGivesNothing) {
  Seabed none, one;
  one.light(Seabed::pixel(two_lasers(), 0, 1.5), {0.1f, 0.6f, 0.1f});
  EXPECT_FALSE(find_laser_dots(none.frame(), two_lasers()));
  EXPECT_FALSE(find_laser_dots(one.frame(), two_lasers()));
}

TEST(LaserDots, GreyImagesAndWhiteSpecksHaveNone) {
  Seabed seabed;
  seabed.light_dots(two_lasers(), 1.5, 1.5, {0.6f, 0.6f, 0.6f});
  EXPECT_FALSE(find_laser_dots(seabed.frame(), two_lasers()));
}

TEST(LaserDots, GreenSpecksBesideTheBeamsAreNotTaken) {
  const Vector2d aside(25, 25);
  Seabed specks;
  for (std::size_t i = 0; i < 2; ++i) {
    specks.light(Seabed::pixel(two_lasers(), i, 1.5) + aside, {0.1f, 0.7f, 0.1f});
  }
  EXPECT_FALSE(find_laser_dots(specks.frame(), two_lasers()));
  specks.light_dots(two_lasers(), 1.5, 1.5);
  expect_dots(find_laser_dots(specks.frame(), two_lasers()), two_lasers(), 1.5, 1.5, 0.1);
}

TEST(LaserDots, ABrighterSpeckOnOneBeamIsNotItsDot) {
  Seabed seabed;
  seabed.light_dots(two_lasers(), 1.5, 1.5);
  seabed.light(Seabed::pixel(two_lasers(), 0, 0.7), {0.1f, 0.8f, 0.1f});
  expect_dots(find_laser_dots(seabed.frame(), two_lasers()), two_lasers(), 1.5, 1.5, 0.1);
}

TEST(LaserDots, AGreenObjectIsNoDot) {
  Seabed seabed;
  for (std::size_t i = 0; i < 2; ++i) {
    seabed.light(Seabed::pixel(two_lasers(), i, 1.5), {0.05f, 0.3f, 0.05f}, 25);
  }
  EXPECT_FALSE(find_laser_dots(seabed.frame(), two_lasers()));
}

TEST(LaserDots, DoNotShowBeyondTheirRadius) {
  Seabed seabed;
  const Frame before = seabed.frame();
  seabed.light_dots(two_lasers(), 1.5, 1.5);
  const Frame after = seabed.frame();
  const auto dots = find_laser_dots(after, two_lasers());
  ASSERT_TRUE(dots);
  cv::Mat3b changed;
  cv::absdiff(before.colour, after.colour, changed);
  for (const LaserDot& dot : dots->dots) EXPECT_LT(dot.radius_px, 11);  // no more seabed than that
  for (int v = 0; v < changed.rows; ++v) {
    for (int u = 0; u < changed.cols; ++u) {
      const auto hides = [&](const LaserDot& dot) {
        return (Vector2d(u, v) - dot.pixel).norm() <= dot.radius_px;
      };
      if (std::ranges::any_of(dots->dots, hides)) continue;
      const cv::Vec3b& by = changed(v, u);
      ASSERT_LE(std::max({by[0], by[1], by[2]}), 2) << u << ' ' << v;
    }
  }
}

TEST(LaserDots, LasersThatCannotGiveScaleSayWhy) {
  EXPECT_EQ(fault_of(two_lasers()), "");
  Lasers lasers = two_lasers();
  lasers.origins_in_camera.clear();
  EXPECT_NE(fault_of(lasers).find("origins_camera_m"), std::string::npos);
  EXPECT_THROW(find_laser_dots(Seabed().frame(), lasers), ContractError);
  EXPECT_THROW(LaserScale{lasers}, ContractError);
  lasers = two_lasers();
  lasers.parallel_to_optical_axis = false;
  EXPECT_NE(fault_of(lasers).find("direction_camera"), std::string::npos);
  lasers.direction_in_camera = Vector3d(0.1, 0, 1).normalized();
  lasers.separation = 0.1 / std::sqrt(1.01);  // across slanting beams
  EXPECT_EQ(fault_of(lasers), "");
  EXPECT_EQ(conflict_of(lasers), "");
  lasers.separation = 0.11;
  EXPECT_EQ(fault_of(lasers), "");
  EXPECT_NE(conflict_of(lasers).find("separation_m"), std::string::npos);
  lasers.separation = 0.2;
  EXPECT_NE(fault_of(lasers).find("separation_m"), std::string::npos);
  lasers = two_lasers();
  lasers.direction_in_camera = -Vector3d::UnitZ();
  EXPECT_NE(fault_of(lasers).find("direction_camera"), std::string::npos);
}

TEST(LaserDots, AreFoundOnSimulatedGravel) {
  simulate::Options options;
  options.scene = simulate::SceneKind::transect;
  options.images = 8;
  const simulate::Survey survey(options);
  Lasers lasers = two_lasers();
  lasers.separation = survey.lasers().value().separation;
  lasers.origins_in_camera = survey.lasers().value().origins;
  int found = 0;
  double squares = 0;
  for (int i = 0; i < survey.images(); ++i) {
    const auto dots = find_laser_dots(survey.frame(i), lasers);
    const auto truth = survey.laser_dots(i);
    if (!dots || truth.size() != 2) continue;
    ++found;
    for (std::size_t k = 0; k < 2; ++k) {
      squares += (dots->dots[k].pixel - truth[k].pixel).squaredNorm() / 4;
    }
  }
  EXPECT_GE(found, 7);
  EXPECT_LT(std::sqrt(squares / found), 0.6);  // gravel of every shade: 0.4 px measured
}

}  // namespace
}  // namespace nadir::reference

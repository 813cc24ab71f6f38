// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/laser_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>
#include <utility>

#include "nadir/calibration/rig_file.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/simulate/survey.hpp"

namespace nadir::reference {
namespace {

using calibration::Lasers;
using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector2d, Eigen::Vector3d;

constexpr double kRatio = 2.7;  // metres per map unit of the synthetic maps

Lasers two_lasers() {
  Lasers lasers;
  lasers.separation = 0.1;
  lasers.parallel_to_optical_axis = true;
  lasers.origins_in_camera = {{-0.05, 0.06, 0.09}, {0.05, 0.06, 0.09}};
  return lasers;
}

// A sloping seabed in metres, z = -2 about the origin, seen by swaying cameras along x; the map is
// the same divided by kRatio.
class Survey {
 public:
  explicit Survey(std::uint64_t seed = 1, Lasers lasers = two_lasers())
      : lasers_(std::move(lasers)), random_(seed) {
    std::uniform_real_distribution<double> along(-1, 4), beside(-1, 1);
    for (std::uint64_t i = 0; i < 600; ++i) {
      TiePoint point;
      point.id = i;
      const Vector2d place(along(random_), beside(random_));
      point.x_in_survey = Vector3d(place.x(), place.y(), height(place)) / kRatio;
      window_.tie_points.push_back(point);
    }
  }

  /// Adds an image to the window; its dots are `noise_px` off at 600 px focal length.
  LaserDots add(std::uint64_t image, double noise_px = 0) {
    std::uniform_real_distribution<double> sway(-0.08, 0.08);
    const Quaterniond down(AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
    const Rigid3 metric{Quaterniond(AngleAxisd(sway(random_), Vector3d::UnitX())) *
                            Quaterniond(AngleAxisd(sway(random_), Vector3d::UnitY())) * down,
                        {0.1 * static_cast<double>(image % 30), sway(random_), sway(random_)}};
    ImagePose pose;
    pose.image = image;
    pose.submap = window_.submap;
    pose.survey_from_camera = {metric.rotation, metric.translation / kRatio};
    window_.images.push_back(pose);

    std::normal_distribution<double> noise(0, noise_px / 600);
    LaserDots dots;
    dots.image = image;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector3d from = metric * lasers_.origins_in_camera[i];
      const Vector3d along =
          metric.rotation * lasers_.direction_in_camera.value_or(Vector3d::UnitZ());
      const double t = (kOffset - kNormal.dot(from)) / kNormal.dot(along);
      const Vector3d x_in_camera = metric.inverse() * (from + t * along);
      dots.dots[i].distance = t;
      dots.dots[i].ray = x_in_camera.head<2>() / x_in_camera.z();
      dots.dots[i].pixel = 600 * dots.dots[i].ray;
      if (noise_px > 0) dots.dots[i].ray += Vector2d(noise(random_), noise(random_));
    }
    return dots;
  }

  Window& window() { return window_; }

 private:
  static constexpr double kOffset = -2;
  static inline const Vector3d kNormal{0.1, -0.05, 1};
  static double height(const Vector2d& place) {
    return kOffset - kNormal.x() * place.x() - kNormal.y() * place.y();
  }

  Lasers lasers_;
  std::mt19937_64 random_;
  Window window_;
};

std::optional<LaserEstimate> after(int images, double noise_px, std::uint64_t seed = 1) {
  Survey survey(seed);
  LaserScale scale(two_lasers());
  for (int i = 0; i < images; ++i) {
    scale.observe(survey.add(static_cast<std::uint64_t>(i), noise_px));
  }
  scale.observe(survey.window());
  return scale.estimate(0);
}

TEST(LaserScale, IsExactOnAPlane) {
  const auto estimate = after(5, 0);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->ratio, kRatio, 1e-9);
  EXPECT_EQ(estimate->images, 5u);
}

TEST(LaserScale, IsExactWithSlantingBeams) {
  Lasers lasers = two_lasers();
  lasers.direction_in_camera = Vector3d(0.1, -0.2, 1).normalized();
  lasers.separation = 0.1 * std::sqrt(1 - 0.01 / 1.05);  // across the beams
  Survey survey(1, lasers);
  LaserScale scale(lasers);
  for (std::uint64_t i = 0; i < 5; ++i) scale.observe(survey.add(i));
  scale.observe(survey.window());
  ASSERT_TRUE(scale.estimate(0));
  EXPECT_NEAR(scale.estimate(0)->ratio, kRatio, 1e-9);
}

TEST(LaserScale, NeedsThreeImages) {
  EXPECT_FALSE(after(0, 0));
  EXPECT_FALSE(after(2, 0));
  EXPECT_TRUE(after(3, 0));
}

// 0.2 px per axis on 30 px between the dots is 0.94 % an image.
TEST(LaserScale, SigmaIsHonest) {
  for (const int images : {3, 10, 100}) {
    double squares = 0;
    constexpr int kRuns = 60;
    for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
      const auto estimate = after(images, 0.2, seed);
      ASSERT_TRUE(estimate);
      EXPECT_GE(estimate->sigma, 0.002);
      squares += std::pow((estimate->ratio / kRatio - 1) / estimate->sigma, 2) / kRuns;
    }
    EXPECT_LT(squares, 1.5) << images;
    EXPECT_GT(squares, 0.02) << images;  // the floor is most of it in the end
  }
}

// Small images see the dots near to each other, and what moves both of a kind weighs more.
TEST(LaserScale, SigmaOfSmallImagesIsLarger) {
  Survey survey;
  LaserScale scale(two_lasers()), small(two_lasers());
  for (std::uint64_t i = 0; i < 5; ++i) {
    LaserDots dots = survey.add(i);
    scale.observe(dots);
    for (LaserDot& dot : dots.dots) dot.pixel /= 4;
    small.observe(dots);
  }
  scale.observe(survey.window());
  small.observe(survey.window());
  EXPECT_LT(scale.estimate(0)->sigma, 0.005);
  EXPECT_GT(small.estimate(0)->sigma, 0.005);
}

TEST(LaserScale, OutliersHardlyMoveIt) {
  Survey survey;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 20; ++i) {
    LaserDots dots = survey.add(i, 0.2);
    if (i % 7 == 3) dots.dots[1].ray.x() += 0.02;  // on a fish
    scale.observe(dots);
  }
  scale.observe(survey.window());
  const auto estimate = scale.estimate(0);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->ratio / kRatio, 1, 0.008);
  EXPECT_LT(std::abs(estimate->ratio / kRatio - 1), 2 * estimate->sigma);
}

TEST(LaserScale, WrongTiePointsNearADotHardlyMoveIt) {
  Survey survey;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 5; ++i) scale.observe(survey.add(i));
  for (std::size_t i = 0; i < survey.window().tie_points.size(); i += 5) {
    survey.window().tie_points[i].x_in_survey.z() += 0.3;
  }
  scale.observe(survey.window());
  const auto estimate = scale.estimate(0);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->ratio / kRatio, 1, 0.002);
}

TEST(LaserScale, FollowsAMapThatIsResized) {
  Survey survey;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 5; ++i) scale.observe(survey.add(i));
  scale.observe(survey.window());
  scale.resized(0, kRatio);
  EXPECT_NEAR(scale.estimate(0)->ratio, 1, 1e-9);
  scale.resized(1, 5);  // another map
  EXPECT_NEAR(scale.estimate(0)->ratio, 1, 1e-9);

  // Until the resized map's next window there is no ground a pose could be compared with.
  Orientation orientation;
  scale.observe(survey.add(5));
  orientation.poses = {survey.window().images.back()};
  orientation.poses[0].survey_from_camera.translation *= kRatio;
  scale.observe(orientation);
  EXPECT_EQ(scale.estimate(0)->images, 5u);
  Window metric = survey.window();
  for (ImagePose& pose : metric.images) pose.survey_from_camera.translation *= kRatio;
  for (TiePoint& point : metric.tie_points) point.x_in_survey *= kRatio;
  orientation.window = std::make_shared<const Window>(metric);
  scale.observe(orientation);
  EXPECT_EQ(scale.estimate(0)->images, 6u);
  EXPECT_NEAR(scale.estimate(0)->ratio, 1, 1e-9);
}

TEST(LaserScale, ImagesBetweenKeyFramesCountAndEachCountsOnce) {
  Survey survey;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 6; ++i) scale.observe(survey.add(i));
  Orientation orientation;
  orientation.poses = survey.window().images;
  survey.window().images.resize(3);
  orientation.window = std::make_shared<const Window>(survey.window());
  scale.observe(orientation);
  scale.observe(orientation);
  ASSERT_TRUE(scale.estimate(0));
  EXPECT_EQ(scale.estimate(0)->images, 6u);
}

TEST(LaserScale, SubmapsAreApart) {
  Survey survey;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 4; ++i) scale.observe(survey.add(i));
  survey.window().submap = 3;
  for (ImagePose& pose : survey.window().images) pose.submap = 3;
  scale.observe(survey.window());
  EXPECT_FALSE(scale.estimate(0));
  EXPECT_TRUE(scale.estimate(3));
}

TEST(LaserScale, WithoutGroundAroundTheDotsThereIsNone) {
  Survey few, aside, behind;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 4; ++i) {
    scale.observe(few.add(i));
    aside.add(i);
    behind.add(i);
  }
  few.window().tie_points.resize(7);
  std::erase_if(aside.window().tie_points,
                [](const TiePoint& point) { return point.x_in_survey.y() < 0.2 / kRatio; });
  for (TiePoint& point : behind.window().tie_points) point.x_in_survey.z() *= -1;
  for (Survey* survey : {&few, &aside, &behind}) scale.observe(survey->window());
  EXPECT_FALSE(scale.estimate(0));
}

TEST(LaserScale, TiePointsOfOnePlaceGiveNothingThatIsNotFinite) {
  Survey survey;
  LaserScale scale(two_lasers());
  for (std::uint64_t i = 0; i < 4; ++i) scale.observe(survey.add(i));
  for (TiePoint& point : survey.window().tie_points) point.x_in_survey = {0, 0, -2 / kRatio};
  scale.observe(survey.window());
  EXPECT_FALSE(scale.estimate(0));
}

// A window of one image on ground given in metres.
Window map_of(std::uint64_t image, const Rigid3& pose, const std::vector<Vector3d>& ground) {
  Window window;
  window.images.resize(1);
  window.images[0].image = image;
  window.images[0].survey_from_camera = {pose.rotation, pose.translation / kRatio};
  for (const Vector3d& x : ground) {
    window.tie_points.emplace_back();
    window.tie_points.back().x_in_survey = x / kRatio;
  }
  return window;
}

TEST(LaserScale, OfASimulatedSurveyIsRight) {
  simulate::Options options;
  options.scene = simulate::SceneKind::transect;
  options.images = 8;
  const simulate::Survey survey(options);
  const CameraModel& camera = survey.rig()->left;
  Lasers lasers = two_lasers();
  lasers.separation = survey.lasers().value().separation;
  lasers.origins_in_camera = survey.lasers().value().origins;
  LaserScale scale(lasers);
  for (int i = 0; i < survey.images(); ++i) {
    const auto dots = find_laser_dots(survey.frame(i), lasers);
    if (!dots) continue;
    const cv::Mat1f depth = survey.depth(i);
    std::vector<Vector3d> ground;
    for (int y = 10; y < depth.rows; y += 20) {
      for (int x = 10; x < depth.cols; x += 20) {
        const auto ray = camera.unproject(Vector2d(x, y));
        if (!ray || !(depth(y, x) > 0)) continue;
        const Vector3d x_in_camera = Vector3d(ray->homogeneous()) * double{depth(y, x)};
        ground.push_back(survey.survey_from_camera(i) * x_in_camera);
      }
    }
    scale.observe(*dots);
    scale.observe(map_of(dots->image, survey.survey_from_camera(i), ground));
  }
  const auto estimate = scale.estimate(0);
  ASSERT_TRUE(estimate);
  EXPECT_LT(estimate->sigma, 0.01);
  EXPECT_LT(std::abs(estimate->ratio / kRatio - 1), 2.5 * estimate->sigma);
}

std::vector<Rigid3> poses_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<Rigid3> poses;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream row(line);
    double t = 0, qx = 0, qy = 0, qz = 0, qw = 1;
    Vector3d x;
    row >> t >> x.x() >> x.y() >> x.z() >> qx >> qy >> qz >> qw;
    poses.push_back({Quaterniond(qw, qx, qy, qz).normalized(), x});
  }
  return poses;
}

// The vertices of a binary PLY whose vertices are three floats.
std::vector<Vector3d> vertices_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::size_t count = 0;
  for (std::string line; std::getline(in, line) && line != "end_header";) {
    std::istringstream row(line);
    std::string element, vertex;
    if (row >> element >> vertex && element == "element" && vertex == "vertex") row >> count;
  }
  std::vector<float> values(3 * count);
  in.read(reinterpret_cast<char*>(values.data()),
          static_cast<std::streamsize>(values.size() * sizeof(float)));
  std::vector<Vector3d> vertices;
  for (std::size_t i = 0; i < count; ++i) {
    vertices.emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  }
  return vertices;
}

Frame frame_of(const std::filesystem::path& file, std::uint64_t image,
               const std::shared_ptr<const CameraRig>& rig) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  Frame frame;
  frame.image = image;
  frame.rig = rig;
  frame.colour =
      image_io::decode({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                       rig->left.width, rig->left.height, 1, image_io::Colour::bgr)
          .image;
  return frame;
}

// True poses and surface, so that nothing but the dots is judged.
TEST(LaserScale, OfTheSharedTransectIsWithinItsSigma) {
  const auto folder = std::filesystem::path(NADIR_SHARED_DATA) / "rendered/transect";
  if (!std::filesystem::exists(folder)) {
    std::cout << "not run: no data\n";
    return;
  }
  const auto rig = std::make_shared<const CameraRig>(calibration::load_rig(folder / "calib.yml"));
  const Lasers lasers = calibration::load_lasers(folder / "lasers.yml");
  const std::vector<Rigid3> poses = poses_of(folder / "gt_poses_tum.txt");
  const std::vector<Vector3d> surface = vertices_of(folder / "gt_mesh.ply");
  ASSERT_EQ(poses.size(), 160u);
  ASSERT_GT(surface.size(), 1000u);
  LaserScale scale(lasers);
  std::uint32_t found = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::ostringstream name;
    name << std::string(6 - std::to_string(i).size(), '0') << i << ".jpg";
    const auto dots = find_laser_dots(frame_of(folder / "images" / name.str(), i, rig), lasers);
    if (!dots) continue;
    ++found;
    scale.observe(*dots);
    scale.observe(map_of(i, poses[i], surface));
  }
  const auto estimate = scale.estimate(0);
  ASSERT_TRUE(estimate);
  EXPECT_GE(found, 155u);
  EXPECT_EQ(estimate->images, found);
  const double error = estimate->ratio / kRatio - 1;
  std::cout << "scale error " << 100 * error << " %, sigma " << 100 * estimate->sigma << " %\n";
  EXPECT_LT(std::abs(error), 0.004);
  EXPECT_LT(std::abs(error), 2 * estimate->sigma);
}

}  // namespace
}  // namespace nadir::reference

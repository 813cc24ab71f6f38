// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "samples.hpp"

namespace nadir::calibration::sample {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using ::testing::AllOf, ::testing::HasSubstr;

const Vector3d kPoint(0.31, -0.17, 1.0);

Vector2d pixel(const CameraModel& camera) { return camera.project(kPoint).value(); }

void expect_same(const Vector2d& a, const Vector2d& b) {
  EXPECT_NEAR((a - b).norm(), 0, 1e-9) << a.transpose() << " and " << b.transpose();
}

// OpenCV's projection, written out once more.
Vector2d opencv(double fx, double fy, double cx, double cy, const std::array<double, 8>& d) {
  const double x = kPoint.x(), y = kPoint.y(), r2 = x * x + y * y;
  const double radial = (1 + d[0] * r2 + d[1] * r2 * r2 + d[4] * r2 * r2 * r2) /
                        (1 + d[5] * r2 + d[6] * r2 * r2 + d[7] * r2 * r2 * r2);
  return {fx * (x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x)) + cx,
          fy * (y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y) + cy};
}

Vector2d fisheye(double fx, double fy, double cx, double cy, const std::array<double, 4>& k) {
  const double r = std::hypot(kPoint.x(), kPoint.y()), t = std::atan(r), t2 = t * t;
  const double bent =
      t * (1 + k[0] * t2 + k[1] * t2 * t2 + k[2] * t2 * t2 * t2 + k[3] * t2 * t2 * t2 * t2);
  return {fx * kPoint.x() / r * bent + cx, fy * kPoint.y() / r * bent + cy};
}

TEST(Kalibr, ReadsOneCamera) {
  const CameraRig rig = load(kKalibrMono);
  EXPECT_EQ(rig.left.width, 848);
  EXPECT_EQ(rig.left.height, 480);
  expect_same(pixel(rig.left),
              opencv(416.5, 414.5, 421.25, 237.75, {-0.05, 0.03, -0.0004, 0.0005}));
  EXPECT_FALSE(rig.right);
}

TEST(Kalibr, ReadsAPairOfFisheyes) {
  const CameraRig rig = load(kKalibrPair);
  expect_same(pixel(rig.left),
              fisheye(278.5, 278.25, 319.75, 242, {-0.0137, 0.0207, -0.0128, 0.0025}));
  ASSERT_TRUE(rig.right);
  EXPECT_EQ(rig.right->camera.fx, 277.5);
  EXPECT_EQ(rig.right->right_from_left.translation, Vector3d(-0.08, 0.001, 0));
}

TEST(Kalibr, TakesThePairThroughTheImu) {
  std::string text = kKalibrPair;
  const std::size_t begin = text.find("  T_cn_cnm1"), end = text.find("  camera_model", begin);
  text.erase(begin, end - begin);
  EXPECT_TRUE(load(text).right->right_from_left.translation.isApprox(Vector3d(-0.08, 0, 0)));
  // OpenVINS: where the cameras are in the IMU's frame.
  text = replaced(replaced(text, "T_cam_imu", "T_imu_cam"), "T_cam_imu", "T_imu_cam");
  text = replaced(text, "0.0, -0.07]", "0.0, 0.09]");
  EXPECT_TRUE(load(text).right->right_from_left.translation.isApprox(Vector3d(-0.08, 0, 0)));
}

TEST(Kalibr, RefusesWhatItWouldHaveToGuess) {
  EXPECT_THAT(refusal(kKalibrPair + "cam2:\n  camera_model: pinhole\n"),
              AllOf(HasSubstr(":28: cam2: "), HasSubstr("third camera")));
  std::string apart = kKalibrPair;
  for (int i = 0; i < 2; ++i) apart = replaced(apart, "T_cam_imu", "other");
  EXPECT_THAT(refusal(replaced(apart, "T_cn_cnm1", "unknown")),
              HasSubstr("cam1.T_cn_cnm1 is missing"));
  EXPECT_THAT(refusal(replaced(kKalibrPair, "[1.0, 0.0, 0.0, -0.08]", "[1.0, 0.0, 0.0, 0.08]")),
              HasSubstr("cam1.T_cn_cnm1: the right camera lies left of the left one"));
  EXPECT_THAT(refusal(replaced(kKalibrPair, "[1.0, 0.0, 0.0, -0.08]", "[1.0, 0.3, 0.0, -0.08]")),
              HasSubstr("cam1.T_cn_cnm1: is not a rotation matrix"));
  // A colour and a depth camera: the first is meant.
  EXPECT_FALSE(
      load(kKalibrMono + "cam1:" + kKalibrPair.substr(5, kKalibrPair.find("cam1:") - 5)).right);
}

TEST(Kalibr, RefusesModelsThatNadirDoesNotHave) {
  for (const char* model : {"omni", "eucm", "ds"}) {
    EXPECT_THAT(refusal(replaced(kKalibrMono, "pinhole", model)),
                AllOf(HasSubstr(":3: cam0.camera_model: \"" + std::string(model)),
                      HasSubstr("is not pinhole"), HasSubstr("; calibrate with")));
  }
  EXPECT_THAT(refusal(replaced(kKalibrMono, "radtan", "fov")),
              HasSubstr("cam0.distortion_model: \"fov\" is neither brown_conrady"));
  EXPECT_THAT(refusal(replaced(kKalibrMono, "[848, 480]", "[848]")),
              HasSubstr(":7: cam0.resolution: has 1 values, expected 2"));
}

TEST(Okvis, ReadsAPair) {
  const CameraRig rig = load(kOkvisPair);
  expect_same(pixel(rig.left), opencv(458.5, 457.25, 367.25, 248.5, {-0.28, 0.07, 2e-4, 2e-5}));
  ASSERT_TRUE(rig.right);
  EXPECT_TRUE(rig.right->right_from_left.translation.isApprox(Vector3d(-0.11, 0, 0)));
  EXPECT_EQ(rig.right->camera.cx, 380);
}

TEST(Okvis, RefusesOtherLensesAndThreeCameras) {
  EXPECT_THAT(refusal(replaced(kOkvisPair, "radialtangential", "eucm")),
              HasSubstr(":10: cameras[0].distortion_type: \"eucm\""));
  const std::size_t second = kOkvisPair.rfind("     - {T_SC"),
                    end = kOkvisPair.find("camera_params");
  std::string three = kOkvisPair;
  three.insert(end, kOkvisPair.substr(second, end - second));
  EXPECT_THAT(refusal(three), HasSubstr("has 3 cameras"));
}

TEST(Okvis, ReadsThePoseGraphsCamera) {
  const CameraRig rig = load(kPoseGraph);
  EXPECT_EQ(rig.left.width, 800);
  expect_same(pixel(rig.left), opencv(1138.75, 1139.5, 308.25, 317, {-0.16, 0.08, 0.012, 7e-4}));
  EXPECT_THAT(refusal(replaced(kPoseGraph, "PINHOLE", "MEI")), HasSubstr("model_type: \"MEI\""));
}

TEST(OrbSlam, ReadsOneCamera) {
  expect_same(pixel(load(kOrbSlam).left),
              opencv(519.5, 519.75, 481.5, 316.25, {-0.2, 0.05, 0.001, 0.002, 0.003}));
  std::string renewed = kOrbSlam;  // as ORB-SLAM3 1.0 names it
  for (const char* name : {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}) {
    renewed = replaced(renewed, std::string("Camera.") + name, std::string("Camera1.") + name);
  }
  EXPECT_EQ(load(renewed).left.distortion, load(kOrbSlam).left.distortion);
}

TEST(OrbSlam, ReadsAFisheye) {
  std::string text = replaced(kOrbSlam, "PinHole", "KannalaBrandt8");
  text = replaced(replaced(text, "Camera.p1", "Camera.k4"), "Camera.p2", "other");
  expect_same(pixel(load(text).left),
              fisheye(519.5, 519.75, 481.5, 316.25, {-0.2, 0.05, 0.003, 0.001}));
}

TEST(OrbSlam, RefusesStereoAndOtherModels) {
  EXPECT_THAT(refusal(kOrbSlam + "Camera2.fx: 500.0\n"), HasSubstr("Camera2.fx: is of a stereo"));
  EXPECT_THAT(refusal(replaced(kOrbSlam, "PinHole", "MEI")), HasSubstr(":2: Camera.type: \"MEI\""));
  EXPECT_THAT(refusal(replaced(kOrbSlam, "Camera.width", "Camera.w")),
              HasSubstr("Camera.width is missing"));
}

TEST(Matisse, OrdersItsCoefficientsAsOpenMvg) {
  expect_same(pixel(load(kMatisse).left),
              opencv(1880, 1880, 960, 540, {-0.1, 0.02, 0.0004, 0.0005, 0.003}));
  const std::string radial = replaced(
      replaced(kMatisse, "distortion_model: 2", "distortion_model: 1"), "0.0004, 0.0005", "0, 0");
  expect_same(pixel(load(radial).left), opencv(1880, 1880, 960, 540, {-0.1, 0.02, 0, 0, 0.003}));
  const std::string round =
      replaced(replaced(kMatisse, "distortion_model: 2", "distortion_model: 3"), "0.0005 ]", "0 ]");
  expect_same(pixel(load(round).left), fisheye(1880, 1880, 960, 540, {-0.1, 0.02, 0.003, 0.0004}));
}

TEST(Matisse, RefusesCoefficientsOfAnotherModel) {
  EXPECT_THAT(refusal(replaced(kMatisse, "distortion_model: 2", "distortion_model: 1")),
              HasSubstr("distortion_coeff: are not the 3 coefficients of distortion_model 1"));
  EXPECT_THAT(refusal(replaced(kMatisse, "distortion_model: 2", "distortion_model: 7")),
              HasSubstr("distortion_model: is none of"));
}

TEST(RosCameraInfo, ReadsTheMessagesOfRos1And2) {
  const Vector2d expected = opencv(656.5, 719, 373.75, 157, {-0.36, 0.115, 0.008, 0.005});
  expect_same(pixel(load(kRos1).left), expected);
  std::string ros_2 = kRos1;
  for (const char* key : {"D", "K", "R", "P"}) {
    const std::string small(1, static_cast<char>(std::tolower(*key)));
    ros_2 = replaced(ros_2, std::string("\n") + key + ":", std::string("\n") + small + ":");
  }
  expect_same(pixel(load(ros_2).left), expected);
}

TEST(RosCameraInfo, ReadsAFisheyeAndRefusesPartsOfTheSensor) {
  const std::string round =
      replaced(replaced(kRos1, "plumb_bob", "equidistant"), "0.008, 0.005, 0.0", "0.008, 0.005");
  expect_same(pixel(load(round).left),
              fisheye(656.5, 719, 373.75, 157, {-0.36, 0.115, 0.008, 0.005}));
  EXPECT_THAT(refusal(replaced(kRos1, "binning_x: 0", "binning_x: 2")),
              HasSubstr(":12: binning_x: bins pixels"));
  EXPECT_THAT(refusal(replaced(kRos1, "x_offset: 0", "x_offset: 100")),
              HasSubstr("roi.x_offset: is a part"));
  EXPECT_THAT(refusal(replaced(kRos1, "\"plumb_bob\"", "\"\"")), HasSubstr("distortion_model: "));
}

TEST(OpenCv, TakesItsSampleProgramsFisheyeModel) {
  const std::string text = R"(%YAML:1.0
image_width: 968
image_height: 728
fisheye_model: 1
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 757., 0., 481., 0., 756., 366., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ 0.01, 0.02, 0.03, 0.04 ]
)";
  expect_same(pixel(load(text).left), fisheye(757, 756, 481, 366, {0.01, 0.02, 0.03, 0.04}));
  EXPECT_THAT(refusal(text + "xi: 1.2\n"), HasSubstr(":15: xi: belongs to the unified"));
}

TEST(OpenCv, RefusesAnAbsurdMatrixWithoutASizeForWhatItIs) {
  const std::string text = R"(%YAML:1.0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 12572., 0., 652., 0., 9842., 107., 0., 0., 1. ]
)";
  EXPECT_THAT(refusal(text), HasSubstr(":2: camera_matrix: a field of view of 5.9"));
  EXPECT_THAT(refusal(replaced(replaced(text, "12572.", "757."), "9842.", "756.")),
              HasSubstr("image_width is missing"));
}

TEST(Colmap, PutsTheFirstPixelsCentreAtZero) {
  const CameraModel camera = load(kColmap).left;
  EXPECT_EQ(camera.width, 968);
  EXPECT_EQ(camera.height, 728);
  // COLMAP's pixel of the point, whose (0.5, 0.5) is our (0, 0).
  const Vector2d colmap = opencv(757.5, 756.5, 480.5, 366.5, {0.12, 0.035, 0.0005, -0.0007});
  expect_same(pixel(camera), colmap - Vector2d(0.5, 0.5));
}

TEST(Colmap, ReadsEveryModelThatNadirHas) {
  const auto read = [](const std::string& camera) { return pixel(load(camera).left); };
  const double cx = 480, cy = 366;
  expect_same(read("1 SIMPLE_PINHOLE 968 728 757 480.5 366.5\n"), opencv(757, 757, cx, cy, {}));
  expect_same(read("1 PINHOLE 968 728 757 756 480.5 366.5"), opencv(757, 756, cx, cy, {}));
  expect_same(read("1 SIMPLE_RADIAL 968 728 757 480.5 366.5 0.1"), opencv(757, 757, cx, cy, {0.1}));
  expect_same(read("1 RADIAL 968 728 757 480.5 366.5 0.1 0.02"),
              opencv(757, 757, cx, cy, {0.1, 0.02}));
  expect_same(read("1 FULL_OPENCV 968 728 757 756 480.5 366.5 .1 .02 .003 .004 .05 .06 .07 .08"),
              opencv(757, 756, cx, cy, {.1, .02, .003, .004, .05, .06, .07, .08}));
  expect_same(read("1 OPENCV_FISHEYE 968 728 757 756 480.5 366.5 .1 .02 .03 .04"),
              fisheye(757, 756, cx, cy, {.1, .02, .03, .04}));
  expect_same(read("1 RADIAL_FISHEYE 968 728 757 480.5 366.5 .1 .02"),
              fisheye(757, 757, cx, cy, {.1, .02, 0, 0}));
}

TEST(Colmap, RefusesOtherModelsAndSeveralCameras) {
  EXPECT_THAT(refusal("# a comment\n\n7 THIN_PRISM_FISHEYE 968 728 1 2 3 4 5 6 7 8 9 10 11 12\n"),
              AllOf(HasSubstr(":3: MODEL: \"THIN_PRISM_FISHEYE\" is no lens model"),
                    HasSubstr("; run COLMAP with OPENCV")));
  EXPECT_THAT(refusal("1 FOV 968 728 757 756 480 366 0.9\n"), HasSubstr(":1: MODEL: \"FOV\""));
  EXPECT_THAT(refusal("1 PINHOLE 968 728 757 480 366\n"), HasSubstr("PINHOLE takes 4 parameters"));
  EXPECT_THAT(refusal("1 PINHOLE 968 728 757 nan 480 366\n"),
              HasSubstr(":1: fy: \"nan\" is not a finite number"));
  EXPECT_THAT(refusal(kColmap + "2 PINHOLE 968 728 757 756 480 366\n"),
              HasSubstr(":5: CAMERA_ID: a second camera"));
  EXPECT_THAT(refusal("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"), HasSubstr("no camera"));
  // A camera per image, all alike, is one camera.
  EXPECT_EQ(load("1 PINHOLE 968 728 757 756 480 366\n2 PINHOLE 968 728 757 756 480 366\n").left.fx,
            757);
}

// Appendix "Camera models" of Metashape's manual, in its own pixels.
Vector2d metashape(double f, double b1, double cx, double cy, double p1, double p2) {
  const double k1 = -0.12, k2 = 0.29, k3 = 0.01;
  const double x = kPoint.x(), y = kPoint.y(), r2 = x * x + y * y;
  const double radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
  const double xd = x * radial + (p1 * (r2 + 2 * x * x) + 2 * p2 * x * y);
  const double yd = y * radial + (p2 * (r2 + 2 * y * y) + 2 * p1 * x * y);
  return {1920 * 0.5 + cx + xd * f + xd * b1, 1080 * 0.5 + cy + yd * f};
}

TEST(Metashape, SwapsP1AndP2AndMovesThePrincipalPoint) {
  const CameraModel camera = load(kMetashape).left;
  EXPECT_EQ(camera.cx, 959.5 - 24);
  EXPECT_EQ(camera.cy, 539.5 + 17.5);
  // The centre of Metashape's first pixel is (0.5, 0.5).
  expect_same(pixel(camera), metashape(1430, 2, -24, 17.5, 0.0003, 0.0018) - Vector2d(0.5, 0.5));
}

TEST(Metashape, ReadsTheAdjustedCalibrationOfAProjectsOneSensor) {
  const CameraModel camera = load(kMetashapeCameras).left;
  EXPECT_EQ(camera.width, 2256);
  EXPECT_EQ(camera.fx, 1940.5);
  EXPECT_EQ(camera.cx, 1127.5 + 13.25);
  EXPECT_EQ(camera.distortion, (std::array<double, 8>{-0.1, 0.18, 0, 0, -0.06}));
  EXPECT_THAT(refusal(replaced(kMetashapeCameras, "</sensors>", "<sensor/></sensors>")),
              HasSubstr("is not a mapping"));
  EXPECT_THAT(
      refusal(replaced(kMetashapeCameras, "</sensors>", "<sensor><bands/></sensor></sensors>")),
      HasSubstr("chunk.sensors.sensor: there are 2"));
  EXPECT_THAT(refusal(replaced(kMetashapeCameras, "adjusted", "initial")),
              HasSubstr("was not adjusted"));
}

TEST(Metashape, ReadsAFisheye) {
  std::string text = replaced(kMetashape, "frame", "fisheye");
  text = replaced(replaced(text, "0.0018", "0"), "0.0003", "0");
  expect_same(pixel(load(replaced(text, "<b1>2", "<b1>0")).left),
              fisheye(1430, 1430, 935.5, 557, {-0.12, 0.29, 0.01, 0}));
  EXPECT_THAT(refusal(replaced(kMetashape, "frame", "fisheye")), HasSubstr("p1: is a tangential"));
}

TEST(Metashape, RefusesWhatTheLensModelDoesNotKnow) {
  EXPECT_THAT(refusal(replaced(kMetashape, "<b1>2</b1>", "<b2>-4.25</b2>")),
              AllOf(HasSubstr(":9: b2: is a skew"), HasSubstr("; optimise the cameras")));
  EXPECT_EQ(load(replaced(kMetashape, "<b1>2</b1>", "<b2>0.05</b2>")).left.fx, 1430);
  EXPECT_THAT(refusal(replaced(kMetashape, "<b1>2</b1>", "<k4>0.5</k4>")), HasSubstr("k4: is"));
  EXPECT_THAT(refusal(replaced(kMetashape, "<b1>2</b1>", "<p3>0.5</p3>")), HasSubstr("p3: is"));
  EXPECT_THAT(refusal(replaced(kMetashape, "frame", "spherical")),
              HasSubstr(":3: projection: \"spherical\""));
  EXPECT_THAT(refusal(replaced(kMetashape, "<f>1430</f>", "<fx>1430</fx>")),
              HasSubstr("f is missing"));
}

TEST(Formats, AreToldByContentNotByName) {  // the temporary file is always .yml
  EXPECT_EQ(load(kMetashape).left.width, 1920);
  EXPECT_EQ(load(kColmap).left.width, 968);
}

TEST(Formats, RefuseASizeTheWrongWayRound) {
  EXPECT_THAT(refusal("1 PINHOLE 540 960 582 581 480 272\n"),
              AllOf(HasSubstr("is that of an image of 960 x 540 px"), HasSubstr("swap width")));
}

TEST(Formats, RefuseWhatIsNoneOfThem) {
  EXPECT_THAT(refusal("{\n \"fx\": 365.4,\n \"alpha\": -0.6, \"beta\": 0.9\n}"),
              HasSubstr(":3: alpha: belongs to the extended unified (EUCM)"));
  EXPECT_THAT(refusal("[{\"cameras\": {}}]"), HasSubstr("JSON is not read"));
  EXPECT_THAT(refusal("<sensors><a/></sensors>"), HasSubstr("not written by OpenCV or Metashape"));
  EXPECT_THAT(refusal("camera_model kannala-brandt\nim_width 688\n"),
              HasSubstr("expected \"key: value\"; expected the calibration of a camera: YAML by"));
}

// A fisheye of 230 degrees leaves dark corners, which belong to no ray in front of the camera.
TEST(Formats, TakeAFisheyeWhoseCornersSeeBehindIt) {
  const std::string k = " 0.0035 0.0007 -0.002 0.0002\n";
  EXPECT_EQ(load("1 OPENCV_FISHEYE 512 512 191 191 255 257" + k).left.fx, 191);
  EXPECT_THAT(refusal("1 OPENCV_FISHEYE 512 512 140 140 255 257" + k), HasSubstr("no inverse"));
  EXPECT_THAT(refusal("1 OPENCV_FISHEYE 512 512 191 191 255 257 -0.3 0 0 0\n"),
              HasSubstr("has no inverse"));
}

}  // namespace
}  // namespace nadir::calibration::sample

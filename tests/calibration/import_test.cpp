// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Every real calibration file at hand, with the values a person read off it, or why it is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "nadir/calibration/rig_file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

using ::testing::HasSubstr;

constexpr LensModel kBrown = LensModel::brown_conrady, kFisheye = LensModel::kannala_brandt;

struct Read {
  int width, height;
  double fx, fy, cx, cy;
  LensModel lens;
  double first, second, third;  ///< distortion
  double baseline = 0;          ///< metres; 0: one camera
  double right_fx = 0;
};

struct Refused {
  std::string because;  ///< part of the message
};

using Expected = std::variant<Read, Refused>;

// Baselines: distances of the two camera centres in the file's own frame, by a calculator.
const std::map<std::string, Expected>& table() {
  static const Refused kLicence{"expected the calibration of a camera"};
  static const Read kGoPro{960,       540,    582.75854,   580.84463,  479.95703,
                           271.82989, kBrown, -0.11509741, 0.10292772, 0.00141984};
  static const Read kEuroc{752,    480,         458.65488,  457.29670,  367.21580, 248.37534,
                           kBrown, -0.28340811, 0.07395907, 0.00019360, 0.1100778, 457.58743};
  static const Read kD455{848,       480,    416.85223,   414.92069,  421.02459,
                          237.76181, kBrown, -0.04576190, 0.03423951, -0.00040139};
  static const Read kFlir{1600,      1100,   1159.29056, 1157.02159, 804.42931,
                          561.88454, kBrown, 0.14621392, 0.37753042, 0.00783556};
  static const std::map<std::string, Expected> kTable = {
      {"apl_photoscan_xml/LICENSE", kLicence},
      {"apl_photoscan_xml/test_data_Photoscan_d2_camera.xml",
       Refused{".xml:9: b2: is a skew, which the lens model does not know"}},
      {"aurlab_text/calibrationParameters.md", Refused{"expected \"key: value\""}},
      {"cusub_ros/cusub_common_drivers_occam_launch_camera.yaml",
       Read{752, 480, 656.911402, 719.001469, 373.735385, 156.944858, kBrown, -0.360085, 0.115116,
            0.007768}},
      {"deepreefmap_eucm_json/example_inputs_intrinsics_eucm.json",
       Refused{".json:6: alpha: belongs to the extended unified (EUCM)"}},
      {"ifremer_matisse_opencv_yaml/Deploy_cameras_Ariane_Princ_HD.yaml",
       Read{1920, 1080, 1170, 1170, 960, 540, kBrown, 0, 0, 0}},
      {"ifremer_matisse_opencv_yaml/Deploy_cameras_Ariane_Still.yaml",
       Read{6000, 4000, 6700, 6700, 3000, 2000, kBrown, 0, 0, 0}},
      {"ifremer_matisse_opencv_yaml/Deploy_cameras_Nautile_Still.yaml",
       Read{6000, 4000, 5875, 5875, 3000, 2000, kBrown, 0, 0, 0}},
      {"ifremer_matisse_opencv_yaml/Deploy_cameras_Scampi_HD.yaml",
       Read{1920, 1080, 1880, 1880, 960, 540, kBrown, 0, 0, 0}},
      {"ifremer_matisse_opencv_yaml/Deploy_cameras_Victor_4K.yaml",
       Read{3840, 2160, 2370, 2370, 1920, 1080, kBrown, 0, 0, 0}},
      {"ifremer_matisse_opencv_yaml/LICENSE", kLicence},
      {"opensfm_json/data_berlin_reconstruction_example.json", Refused{"JSON is not read"}},
      {"openvins_kalibr_camchain/LICENSE", kLicence},
      {"openvins_kalibr_camchain/config_kaist_kalibr_imucam_chain.yaml",
       Read{1280, 560, 816.90379, 811.56804, 608.50726, 263.47600, kBrown, -0.05614303, 0.13952563,
            -0.00121559, 0.4751509, 813.78206}},
      {"openvins_kalibr_camchain/config_rpng_aruco_kalibr_imucam_chain.yaml",
       Read{752, 480, 470.05027, 468.75748, 405.80799, 245.28798, kBrown, -0.29203152, 0.08753156,
            0.00095685, 0.1092346, 472.98385}},
      {"openvins_kalibr_camchain/config_rpng_plane_kalibr_imucam_chain.yaml", kD455},
      {"openvins_kalibr_camchain/config_rs_d455_kalibr_imucam_chain.yaml", kD455},
      {"openvins_kalibr_camchain/config_tum_vi_kalibr_imucam_chain.yaml",
       Read{512, 512, 190.97848, 190.97331, 254.93171, 256.89744, kFisheye, 0.00348239, 0.00071503,
            -0.00205324, 0.1010873, 190.44237}},
      {"openvins_kalibr_camchain/config_uzhfpv_indoor_kalibr_imucam_chain.yaml",
       Read{640, 480, 278.66723, 278.48991, 319.75221, 241.96859, kFisheye, -0.01372181, 0.02072743,
            -0.01278648, 0.0796207, 277.61641}},
      {"openvins_kalibr_camchain/config_uzhfpv_outdoor_kalibr_imucam_chain.yaml",
       Read{640, 480, 277.47869, 277.42549, 320.10521, 242.10083, kFisheye, -0.00571991, 0.00474245,
            0.00120607, 0.0791992, 276.78680}},
      {"orbslam3_yaml/Configs_archaeological_pinhole.yaml",
       Read{640, 480, 430, 430, 320, 240, kBrown, 0, 0, 0}},
      {"orbslam3_yaml/ORB_SLAM3_Examples_Monocular_AQUALOC_Archaeological.yaml",
       Read{968, 608, 519.538, 519.846, 481.444, 316.168, kBrown, -0.207478, 0.0540258, 0}},
      {"pinax_txt/input_data_calibration_params.txt", Refused{"expected \"key: value\""}},
      {"robosub_ros_camera_info/LICENSE", kLicence},
      // Says neither the lens model nor, it seems, rows and columns the right way round.
      {"robosub_ros_camera_info/param_right_camera.yaml", Refused{"image_width is missing"}},
      {"subvo/camera_calibration.yaml", Refused{".yaml:3: camera_matrix: a field of view of"}},
      {"svin_okvis_opencv_yaml/LICENSE", kLicence},
      {"svin_okvis_opencv_yaml/config_config_fpga_p2_euroc.yaml", kEuroc},
      {"svin_okvis_opencv_yaml/config_config_gopro_uw_radtan.yaml", kGoPro},
      {"svin_okvis_opencv_yaml/config_config_stereorig_v2.yaml",
       Read{1600, 1200, 1156.51885, 1156.57727, 763.20833, 617.27799, kBrown, -0.17473019,
            0.10643290, 0.00521078, 0.1389369, 1158.62586}},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_bbdos2019_speedo1.yaml",
       Read{800, 600, 1138.83277, 1139.59470, 308.17294, 317.12897, kBrown, -0.16289394, 0.08351833,
            0.01227648, 0.0919374, 1138.63342}},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_flir_mono.yaml", kFlir},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_fpga_p2_euroc.yaml", kEuroc},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_gopro_uw_radtan.yaml", kGoPro},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_speedo1_water_downsize.yaml",
       Read{800, 600, 583.01153, 583.01153, 335.99273, 310.68724, kBrown, 0, 0, 0, 0.0919374,
            583.01153}},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_stereorig_v1.yaml",
       Read{1600, 1200, 1167.87421, 1166.95538, 771.76311, 589.96265, kBrown, -0.16610166,
            0.11565046, -0.00005941, 0.2317828, 1165.94935}},
      {"svin_okvis_opencv_yaml/okvis_ros_okvis_config_config_stereorig_v3.yaml",
       Read{1600, 1200, 1149.52001, 1150.57924, 798.75531, 577.20249, kBrown, -0.16012168,
            0.10200150, 0.00369027, 0.1422067, 1151.26745}},
      // The same camera as config_config_gopro_uw_radtan.yaml: its width and height are swapped.
      {"svin_okvis_opencv_yaml/pose_graph_config_gopro_gopro_uw.yaml",
       Refused{"principal_point: principal point (480, 271.8) is that of an image of 960 x 540"}},
      {"svin_okvis_opencv_yaml/pose_graph_config_speedo1_speedo1_bbdos2019_config.yaml",
       Read{800, 600, 1138.83277, 1139.59470, 308.17294, 317.12897, kBrown, -0.16289394, 0.08351833,
            0.01227648}},
      {"svin_okvis_opencv_yaml/pose_graph_config_speedo1_speedo1_downsize_coral_square.yaml",
       Read{800, 600, 569.41638, 569.79735, 354.08647, 308.56449, kBrown, 0, 0, 0}},
      {"svin_okvis_opencv_yaml/pose_graph_config_stereo_rig_flir_config.yaml", kFlir},
      {"svin_okvis_opencv_yaml/pose_graph_config_stereo_rig_stereo_rig_v2_config.yaml",
       Read{800, 600, 578.25943, 578.28863, 381.60417, 308.63899, kBrown, 0, 0, 0}},
      {"tsinghua_opencv_xml/README.md", kLicence},
      // One camera in four files, none of which has the size.
      {"tsinghua_opencv_xml/calib_result_matlab_T.xml",
       Refused{"image_width is missing; add it (found: matlab_T)"}},
      {"tsinghua_opencv_xml/calib_result_matlab_cameraMatrixR.xml",
       Refused{"image_width is missing; add it (found: matlab_cameraMatrixR)"}},
      {"tsinghua_opencv_xml/calib_result_matlab_distCoeffR.xml",
       Refused{"image_width is missing; add it (found: matlab_distCoeffR)"}},
      {"turtlmap/param_br2config.yaml",
       Read{960, 540, 933.42249, 931.66150, 487.34991, 271.66022, kBrown, 0.07827179, -0.07918548,
            -0.00427339, 0.0630987, 930.99268}},
  };
  return kTable;
}

void expect_read(const CameraRig& rig, const Read& expected) {
  constexpr double kPrinted = 6e-6;  // px, half the last digit of the table
  EXPECT_EQ(rig.left.width, expected.width);
  EXPECT_EQ(rig.left.height, expected.height);
  EXPECT_NEAR(rig.left.fx, expected.fx, kPrinted);
  EXPECT_NEAR(rig.left.fy, expected.fy, kPrinted);
  EXPECT_NEAR(rig.left.cx, expected.cx, kPrinted);
  EXPECT_NEAR(rig.left.cy, expected.cy, kPrinted);
  EXPECT_EQ(rig.left.lens, expected.lens);
  EXPECT_NEAR(rig.left.distortion[0], expected.first, 6e-9);
  EXPECT_NEAR(rig.left.distortion[1], expected.second, 6e-9);
  EXPECT_NEAR(rig.left.distortion[2], expected.third, 6e-9);
  ASSERT_EQ(rig.right.has_value(), expected.baseline > 0);
  if (!rig.right) return;
  EXPECT_NEAR(rig.right->right_from_left.translation.norm(), expected.baseline, 1e-6);
  EXPECT_LT(rig.right->right_from_left.translation.x(), 0);  // the right camera is on the right
  EXPECT_NEAR(rig.right->camera.fx, expected.right_fx, kPrinted);
}

TEST(Import, ReadsOrRefusesEveryRealFileAsAPersonWould) {
  const std::filesystem::path folder = std::filesystem::path(NADIR_SHARED_DATA) / "real/calib";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "not run: no data";
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = std::filesystem::relative(entry.path(), folder).string();
    SCOPED_TRACE(name);
    const auto row = table().find(name);
    if (row == table().end()) {
      ADD_FAILURE() << "not in the table";
      continue;
    }
    ++found;
    const Refused* const refused = std::get_if<Refused>(&row->second);
    try {
      const CameraRig rig = load_rig(entry.path());
      ASSERT_EQ(refused, nullptr) << "was read";
      expect_read(rig, std::get<Read>(row->second));
    } catch (const InputError& error) {
      ASSERT_NE(refused, nullptr) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(refused->because));
      EXPECT_THAT(error.what(), HasSubstr(entry.path().filename().string()));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_EQ(found, table().size());
}

}  // namespace
}  // namespace nadir::calibration

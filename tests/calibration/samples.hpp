// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A small calibration file of every format.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "nadir/calibration/rig_file.hpp"
#include "nadir/core/check.hpp"
#include "temporary_file.hpp"

namespace nadir::calibration::sample {

inline const std::string kKalibrMono = R"(cam0:
  cam_overlaps: []
  camera_model: pinhole
  distortion_coeffs: [-0.05, 0.03, -0.0004, 0.0005]
  distortion_model: radtan
  intrinsics: [416.5, 414.5, 421.25, 237.75]
  resolution: [848, 480]
  rostopic: /color/image_raw
)";

inline const std::string kKalibrPair = R"(cam0:
  T_cam_imu:
  - [1.0, 0.0, 0.0, 0.01]
  - [0.0, 1.0, 0.0, 0.02]
  - [0.0, 0.0, 1.0, 0.03]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.0137, 0.0207, -0.0128, 0.0025]
  distortion_model: equidistant
  intrinsics: [278.5, 278.25, 319.75, 242.0]
  resolution: [640, 480]
cam1:
  T_cam_imu:
  - [1.0, 0.0, 0.0, -0.07]
  - [0.0, 1.0, 0.0, 0.02]
  - [0.0, 0.0, 1.0, 0.03]
  - [0.0, 0.0, 0.0, 1.0]
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.08]
  - [0.0, 1.0, 0.0, 0.001]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.0085, 0.0114, -0.007, 0.0015]
  distortion_model: equidistant
  intrinsics: [277.5, 277.75, 315.0, 236.0]
  resolution: [640, 480]
)";

// T_SC turns the camera's x to the sensor's y: the right camera lies at larger y.
inline const std::string kOkvisPair = R"(%YAML:1.0
cameras:
     - {T_SC:
        [ 0.0, -1.0, 0.0, -0.02,
          1.0,  0.0, 0.0, -0.06,
          0.0,  0.0, 1.0,  0.01,
          0.0,  0.0, 0.0,  1.0],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002], # a comment
        distortion_type: radialtangential,
        focal_length: [458.5, 457.25],
        principal_point: [367.25, 248.5]}
     - {T_SC:
        [ 0.0, -1.0, 0.0, -0.02,
          1.0,  0.0, 0.0,  0.05,
          0.0,  0.0, 1.0,  0.01,
          0.0,  0.0, 0.0,  1.0],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.28, 0.07, -0.0001, -0.00003],
        distortion_type: radialtangential,
        focal_length: [457.5, 456.0],
        principal_point: [380.0, 255.25]}
camera_params:
    camera_rate: 20 # frames
)";

inline const std::string kPoseGraph = R"(%YAML:1.0
model_type: PINHOLE
image_height: 600
image_width: 800
focal_length: [1138.75, 1139.5]
principal_point: [308.25, 317.0]
distortion_coefficients: [-0.16, 0.08, 0.012, 0.0007]
)";

inline const std::string kOrbSlam = R"(%YAML:1.0
Camera.type: "PinHole"
Camera.fx: 519.5
Camera.fy: 519.75
Camera.cx: 481.5
Camera.cy: 316.25
Camera.k1: -0.2
Camera.k2: 0.05
Camera.p1: 0.001
Camera.p2: 0.002
Camera.k3: 0.003
Camera.width: 968
Camera.height: 608
ORBextractor.nFeatures: 2000
)";

inline const std::string kMatisse = R"(%YAML:1.0
---
camera_name: Scampi HD
full_sensor_width: 1920
full_sensor_height: 1080
K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1880., 0., 960., 0., 1880., 540., 0., 0., 1. ]
distortion_model: 2
distortion_coeff: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.1, 0.02, 0.003, 0.0004, 0.0005 ]
)";

inline const std::string kRos1 = R"(header:
  seq: 1
  stamp:
    secs: 3
height: 480
width: 752
distortion_model: "plumb_bob"
D: [-0.36, 0.115, 0.008, 0.005, 0.0]
K: [656.5, 0.0, 373.75, 0.0, 719.0, 157.0, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [567.9, 0.0, 378.3, 0.0, 0.0, 681.4, 152.2, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: False
---
height: 1
)";

inline const std::string kColmap = R"(# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 1
1 OPENCV 968 728 757.5 756.5 480.5 366.5 0.12 0.035 0.0005 -0.0007
)";

inline const std::string kMetashape = R"(<?xml version="1.0" encoding="UTF-8"?>
<calibration>
  <projection>frame</projection>
  <width>1920</width>
  <height>1080</height>
  <f>1430</f>
  <cx>-24</cx>
  <cy>17.5</cy>
  <b1>2</b1>
  <k1>-0.12</k1>
  <k2>0.29</k2>
  <k3>0.01</k3>
  <p1>0.0003</p1>
  <p2>0.0018</p2>
  <date>2017-11-14T23:30:12Z</date>
</calibration>
)";

inline const std::string kMetashapeCameras = R"(<?xml version="1.0" encoding="UTF-8"?>
<document version="1.5.0">
  <chunk label="Chunk 1" enabled="true">
    <sensors next_id="1">
      <sensor id="0" label="unknown" type="frame">
        <resolution width="2256" height="1504"/>
        <calibration type="frame" class="initial">
          <resolution width="2256" height="1504"/>
          <f>1900</f>
        </calibration>
        <calibration type="frame" class="adjusted">
          <resolution width="2256" height="1504"/>
          <f>1940.5</f>
          <cx>13.25</cx>
          <cy>9.75</cy>
          <k1>-0.1</k1>
          <k2>0.18</k2>
          <k3>-0.06</k3>
        </calibration>
      </sensor>
    </sensors>
    <cameras next_id="2"><camera id="0"/><camera id="1"/></cameras>
  </chunk>
</document>
)";

inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, text.npos) << what;
  return at == text.npos ? text : text.replace(at, what.size(), with);
}

inline CameraRig load(const std::string& content) {
  return load_rig(TemporaryFile(content).path());
}

inline std::string refusal(const std::string& content) {
  try {
    (void)load(content);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace nadir::calibration::sample

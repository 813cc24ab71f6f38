// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Agisoft Metashape Professional manual, appendix "Camera models". Its pixels have their centre at
// 0.5, its cx and cy are offsets from the image centre, its p1 and p2 are OpenCV's p2 and p1.
#include <cmath>

#include "camera_parts.hpp"
#include "formats.hpp"

namespace nadir::calibration {
namespace {

// Coefficients that move nothing by a tenth of a pixel need no refusal.
constexpr double kNegligible_px = 0.1;

// unit_px: what the coefficient is multiplied by, at most, in px.
void refuse_unless_zero(const Fields& file, const std::string& key, double unit_px,
                        const std::string& what) {
  if (std::abs(file.number_or_zero(key)) * unit_px <= kNegligible_px) return;
  file.fail(key, "is " + what + ", which the lens model does not know",
            "optimise the cameras in Metashape with " + key + " fixed at 0, and export again");
}

void read_lens(const Fields& file, double f, CameraModel& camera) {
  camera.distortion[0] = file.number_or_zero("k1");
  camera.distortion[1] = file.number_or_zero("k2");
  const std::string fault = "a tangential distortion of this kind of lens";
  if (camera.lens == LensModel::kannala_brandt) {
    camera.distortion[2] = file.number_or_zero("k3");
    camera.distortion[3] = file.number_or_zero("k4");
    for (const char* key : {"p1", "p2"}) refuse_unless_zero(file, key, f, fault);
  } else {
    camera.distortion[2] = file.number_or_zero("p2");
    camera.distortion[3] = file.number_or_zero("p1");
    camera.distortion[4] = file.number_or_zero("k3");
    refuse_unless_zero(file, "k4", f, "a radial distortion of the 8th degree");
  }
  for (const char* key : {"p3", "p4"}) {
    refuse_unless_zero(file, key, f, "a tangential distortion of higher degree");
  }
}

LensModel lens_of(const Fields& file, const std::string& key) {
  const std::string projection = file.word(key);
  if (projection == "frame") return LensModel::brown_conrady;
  if (projection == "fisheye" || projection == "equidistant_fisheye") {
    return LensModel::kannala_brandt;
  }
  file.fail(key, '"' + projection.substr(0, 40) + "\" is neither frame nor (equidistant) fisheye",
            "use the images of another camera");
}

// file: the element <calibration>.
CameraModel read_camera(const Fields& file) {
  CameraModel camera;
  if (file.has("resolution")) {
    const Fields resolution = file.inside("resolution");
    read_size(resolution, "@width", "@height", camera);
  } else {
    read_size(file, "width", "height", camera);
  }
  camera.lens = lens_of(file, file.has("projection") ? "projection" : "@type");
  const double f = file.number("f");
  camera.fx = f + file.number_or_zero("b1");
  camera.fy = f;
  camera.cx = (camera.width - 1) / 2. + file.number_or_zero("cx");
  camera.cy = (camera.height - 1) / 2. + file.number_or_zero("cy");
  refuse_unless_zero(file, "b2", 1, "a skew");
  read_lens(file, f, camera);
  check_camera(file, "f", "k1", camera);
  return camera;
}

// A sensor has its calibration before the adjustment, after it, or both.
Fields adjusted(const Fields& sensor) {
  const std::vector<Fields> calibrations = sensor.list("calibration");
  for (const Fields& calibration : calibrations) {
    if (calibration.has("@class") && calibration.word("@class") == "adjusted") return calibration;
  }
  sensor.fail("calibration", "was not adjusted", "align the photos in Metashape and export again");
}

}  // namespace

bool is_metashape(const Fields& file) {
  return file.name() == "calibration" || file.is_mapping("chunk");
}

CameraRig read_metashape(const Fields& file) {
  CameraRig rig;
  if (file.name() == "calibration") {
    rig.left = read_camera(file);
    return rig;
  }
  const Fields sensors = file.inside("chunk").inside("sensors");
  const std::vector<Fields> list = sensors.list("sensor");
  if (list.size() != 1) {
    sensors.fail(
        "sensor",
        "there are " + std::to_string(list.size()) + "; which of them took the images is not known",
        "export the calibration of that one");
  }
  rig.left = read_camera(adjusted(list.front()));
  return rig;
}

}  // namespace nadir::calibration

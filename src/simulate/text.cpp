// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "text.hpp"

#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "profile.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Vector3d;

constexpr double kDegrees = 180 / std::numbers::pi;

// The process runs in the C locale, where printf writes '.'.
[[gnu::format(printf, 2, 3)]] void print(std::string& text, const char* format, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text.append(line, static_cast<std::size_t>(std::min<int>(length, sizeof line - 1)));
}

// A matrix as OpenCV's FileStorage writes it.
void matrix(std::string& text, const char* name, const Eigen::MatrixXd& m) {
  print(text, "%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [", name,
        static_cast<int>(m.rows()), static_cast<int>(m.cols()));
  for (int row = 0; row < m.rows(); ++row) {
    for (int column = 0; column < m.cols(); ++column) {
      print(text, "%s%.17g", row + column == 0 ? " " : ", ", m(row, column));
    }
  }
  text += " ]\n";
}

void camera(std::string& text, const CameraModel& camera, const std::string& side) {
  matrix(text, ("camera_matrix" + side).c_str(), camera.matrix());
  Eigen::MatrixXd distortion(1, 5);
  for (int i = 0; i < 5; ++i) distortion(0, i) = camera.distortion[static_cast<std::size_t>(i)];
  matrix(text, ("distortion_coefficients" + side).c_str(), distortion);
}

}  // namespace

std::string calibration(const CameraRig& rig) {
  std::string text = "%YAML:1.0\n---\n";
  print(text, "image_width: %d\nimage_height: %d\n", rig.left.width, rig.left.height);
  camera(text, rig.left, "");
  if (rig.right) {
    camera(text, rig.right->camera, "_right");
    matrix(text, "R", rig.right->right_from_left.rotation.toRotationMatrix());
    matrix(text, "T", rig.right->right_from_left.translation);
  }
  return text;
}

std::string lasers(const Lasers& lasers) {
  std::string text = "%YAML:1.0\n---\n";
  print(text, "separation_m: %.17g\ncolour: green\nwavelength_nm: 532\n", lasers.separation);
  text += "parallel_to_optical_axis: 1\n";
  Eigen::MatrixXd origins(lasers.origins.size(), 3);
  for (std::size_t i = 0; i < lasers.origins.size(); ++i) {
    origins.row(static_cast<int>(i)) = lasers.origins[i].transpose();
  }
  matrix(text, "origins_camera_m", origins);
  matrix(text, "direction_camera", Vector3d::UnitZ().transpose());
  return text;
}

std::string timestamps(const Survey& survey) {
  std::string text = "frame,seconds\n";
  for (int i = 0; i < survey.images(); ++i) {
    print(text, "%s,%.4f\n", survey.name(i).c_str(), seconds(survey.time(i)));
  }
  return text;
}

std::string attitudes(const Survey& survey) {
  std::string text = "seconds,roll,pitch,yaw\n";
  for (const auto& [t, attitude] : survey.attitude_readings()) {
    print(text, "%.3f,%.3f,%.3f,%.3f\n", t, kDegrees * attitude.roll, kDegrees * attitude.pitch,
          kDegrees * attitude.yaw);
  }
  return text;
}

std::string depths(const Survey& survey) {
  std::string text = "seconds,depth\n";
  for (const auto& [t, depth] : survey.depth_readings()) print(text, "%.3f,%.3f\n", t, depth);
  return text;
}

std::string poses(const Survey& survey, const Options& options) {
  std::string text;
  print(text, "# %s: %s camera\n", std::string(to_string(options.scene)).c_str(),
        options.stereo ? "left" : "mono");
  text += "# t tx ty tz qx qy qz qw (camera-to-world, OpenCV camera axes, world Z up)\n";
  for (int i = 0; i < survey.images(); ++i) {
    const Rigid3 pose = survey.survey_from_camera(i);
    const Vector3d& x = pose.translation;
    const Eigen::Quaterniond& q = pose.rotation;
    print(text, "%.4f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", seconds(survey.time(i)), x.x(), x.y(),
          x.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

std::string points(const Survey& survey) {
  std::string text = "id,x,y,z,nx,ny,nz,disc_diameter_m,plate_size_m\n";
  for (const Target& target : survey.targets()) {
    const Vector3d &x = target.x_in_survey, &n = target.normal;
    print(text, "%s,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.5f,%.4f\n", target.id.c_str(), x.x(), x.y(),
          x.z(), n.x(), n.y(), n.z(), target.disc, target.plate);
  }
  return text;
}

std::string observations(const Survey& survey) {
  const char* left = survey.rig()->right ? "left" : "mono";
  std::string text = "frame,camera,id,u,v,disc_diameter_px\n";
  for (int i = 0; i < survey.images(); ++i) {
    for (const Sighting& seen : survey.sightings(i)) {
      print(text, "%s,%s,%s,%.3f,%.3f,%.1f\n", survey.name(i).c_str(), seen.right ? "right" : left,
            seen.id.c_str(), seen.pixel.x(), seen.pixel.y(), seen.disc_px);
    }
  }
  return text;
}

std::string dots(const Survey& survey) {
  std::string text = "frame,laser,u,v,depth_m\n";
  for (int i = 0; i < survey.images(); ++i) {
    for (const LaserDot& dot : survey.laser_dots(i)) {
      print(text, "%s,%d,%.3f,%.3f,%.5f\n", survey.name(i).c_str(), dot.laser, dot.pixel.x(),
            dot.pixel.y(), dot.depth);
    }
  }
  return text;
}

std::string readme(const Survey& survey, const Options& options) {
  const Profile& figures = profile(options.scene);
  const CameraModel& camera = survey.rig()->left;
  double length = 0;
  for (int i = 1; i < survey.images(); ++i) {
    length +=
        (survey.survey_from_camera(i).translation - survey.survey_from_camera(i - 1).translation)
            .norm();
  }
  std::string text;
  print(text, "Simulated survey \"%s\", seed %llu: %d %s %d x %d, JPEG quality %d, %.1f s apart.\n",
        std::string(to_string(options.scene)).c_str(),
        static_cast<unsigned long long>(options.seed), survey.images(),
        options.stereo ? "pairs" : "images", camera.width, camera.height, figures.jpeg,
        figures.interval);
  print(text, "Path %.2f m, %.1f m above the seabed. Everything follows from the seed.\n\n", length,
        figures.altitude);
  text += options.stereo ? "images/            left/ and right/, named by number\n"
                         : "images/            one camera, named by number\n";
  text +=
      R"(calib.yml          OpenCV FileStorage: k1 k2 p1 p2 k3; of a pair also R, T: X_right = R X_left + T (metres).
                   Pixel centres are integers, the top-left one (0, 0).
timestamps.csv     frame,seconds (mid exposure)
ahrs.csv           seconds,roll,pitch,yaw (degrees, 10 Hz, same clock); body forward right down, Z-Y-X angles to
                   north east down; roll + right side down, pitch + nose up, yaw clockwise from north, -180..180.
                   Noise 0.3 deg (roll, pitch) and 1 deg (yaw), half of its variance correlated over 2 s;
                   yaw also has a bias of 0.7 deg and a drift of +-2 deg over 240 s.
                   The camera looks down, the image's top is forward: R_body_camera = [[0,-1,0],[1,0,0],[0,0,1]].
depth.csv          seconds,depth (metres below the surface, 5 Hz, noise 0.01 m)
)";
  if (survey.lasers()) {
    text +=
        "lasers.yml         two green dots: separation_m, beams along the optical axis, "
        "origins_camera_m\n";
  }
  text += R"(
Truth, for judging only:
gt_poses_tum.txt   t tx ty tz qx qy qz qw, world from (left) camera, axes x right, y down, z optical axis;
                   world X east, Y north, Z up, metres, Z = 0 at the water's surface
gt_points.csv      centre of the white disc on each coded plate, the plate's normal, sizes (metres)
gt_observations.csv exact projection of the centre, distorted pixels; only whole plates, nothing before them
gt_depth/          16-bit PNG of some images: depth along the optical axis, mm, at the pixel centres; 0 = none
gt_heightmap.npz   z_mm int16 (rows = local y, columns = local x; -32000 = none), x0, y0, res, R_world_local,
                   t_world_local: X_world = R X_local + t; the surface seen from above
)";
  if (survey.lasers()) text += "gt_laser_dots.csv  frame,laser,u,v,depth_m: exact dot centres\n";
  text +=
      "\nExposure varies +-13 %, white balance +-4 %, veil +-15 %; the lamps move with the "
      "camera. Drifting particles have\ntrue positions, the same in both images of a pair.\n";
  return text;
}

}  // namespace nadir::simulate

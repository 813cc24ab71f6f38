// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/calibration/lasers.hpp"

#include "fields.hpp"
#include "text_file.hpp"

namespace nadir::calibration {
namespace {

LaserColour read_colour(const Fields& file) {
  if (!file.has("colour")) return LaserColour::green;
  const std::string name = file.word("colour");
  if (name == "red") return LaserColour::red;
  if (name == "green") return LaserColour::green;
  if (name == "blue") return LaserColour::blue;
  file.fail("colour", "is not red, green or blue", "use one of the three");
}

std::vector<Eigen::Vector3d> read_origins(const Fields& file) {
  const Eigen::MatrixXd rows = file.matrix("origins_camera_m");
  constexpr double kFarthest = 10;  // metres from the camera
  if (rows.cols() != 3 || rows.cwiseAbs().maxCoeff() > kFarthest) {
    file.fail("origins_camera_m", "must be n x 3 metres, within 10 m of the camera", "correct it");
  }
  std::vector<Eigen::Vector3d> origins;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) origins.emplace_back(rows.row(i).transpose());
  return origins;
}

Eigen::Vector3d read_direction(const Fields& file) {
  const Eigen::MatrixXd given = file.matrix("direction_camera");
  if (given.size() != 3 || !(given.norm() > 1e-6)) {
    file.fail("direction_camera", "must be a vector of three", "correct it");
  }
  return Eigen::Vector3d(given(0), given(1), given(2)).normalized();
}

}  // namespace

Lasers load_lasers(const std::filesystem::path& path) {
  const Field root = parse_fields(read_text(path), path.string(), "OpenCV YAML or XML");
  const Fields file(root, path.string());
  file.require_opencv();
  constexpr double kClosest = 0.005, kFarthest = 10;  // metres
  Lasers lasers;
  lasers.separation = file.number("separation_m");
  if (!(lasers.separation >= kClosest && lasers.separation <= kFarthest)) {
    file.fail("separation_m", "must be 0.005 to 10 m", "give it in metres");
  }
  lasers.colour = read_colour(file);
  if (file.has("parallel_to_optical_axis")) {
    lasers.parallel_to_optical_axis = file.integer("parallel_to_optical_axis") != 0;
  }
  if (file.has("origins_camera_m")) lasers.origins_in_camera = read_origins(file);
  if (file.has("direction_camera")) lasers.direction_in_camera = read_direction(file);
  return lasers;
}

}  // namespace nadir::calibration

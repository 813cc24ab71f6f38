// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The text files: trajectories, alerts, health.
#include <algorithm>
#include <cmath>

#include "products.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

constexpr int kPoseDecimals = 9;

// The rotation's one of two quaternions whose last component that is not zero is positive.
Eigen::Quaterniond canonical(const Eigen::Quaterniond& rotation) {
  const Eigen::Vector4d q = rotation.normalized().coeffs();  // x y z w
  for (int i = 3; i >= 0; --i) {
    if (q[i] != 0) return Eigen::Quaterniond(q[i] < 0 ? Eigen::Vector4d(-q) : q);
  }
  return Eigen::Quaterniond::Identity();
}

std::string tum_line(const ImagePose& pose) {
  std::string line = seconds_text(pose.time);
  const auto add = [&](double value) { line += ' ' + fixed(value, kPoseDecimals); };
  for (const double value : pose.survey_from_camera.translation) add(value);
  const Eigen::Quaterniond rotation = canonical(pose.survey_from_camera.rotation);
  for (const double value : rotation.coeffs()) add(value);
  return line + '\n';
}

// RFC 4180.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

std::string weaknesses(const Health& health) {
  std::string names;
  for (const Weakness weakness : kWeaknesses) {
    if (!health.has(weakness)) continue;
    if (!names.empty()) names += ' ';
    names += to_string(weakness);
  }
  return names;
}

// 1 sigma of an image's pose, relative to the one before it. Images between key frames are measured
// from the key frame before them.
struct RelativeSigma {
  double position = 0, rotation = 0;  ///< 0: unknown
};
RelativeSigma relative_sigma(const ImagePose* before, const ImagePose& pose) {
  if (before == nullptr || before->submap != pose.submap || !(pose.sigma_position > 0)) return {};
  if (before->key_frame) return {pose.sigma_position, pose.sigma_rotation};
  if (!(before->sigma_position > 0)) return {};
  return {std::hypot(pose.sigma_position, before->sigma_position),
          std::hypot(pose.sigma_rotation, before->sigma_rotation)};
}

std::string health_line(std::uint64_t number, const ImageFacts& image, const ImagePose* before) {
  std::string line =
      padded(number, 1) + ',' + csv_field(image.name) + ',' + seconds_text(image.time) + ',';
  line += image.rejected ? "rejected" : to_string(image.state);
  line += image.final ? ",1" : ",0";
  const std::uint32_t submap = image.final ? image.final->submap : image.submap;
  const Health& health = image.health;
  line += ',' + padded(submap, 1) + ',' + padded(health.tie_points, 1);
  for (const std::uint32_t count : health.by_quadrant) line += ',' + padded(count, 1);
  const auto add = [&](double value, int decimals) {
    line += ',' + (std::isfinite(value) ? fixed(value, decimals) : std::string());
  };
  add(health.tracked_length, 1);
  for (const double value : {health.rms_px, health.sharpness, health.exposure}) add(value, 3);
  const RelativeSigma sigma = image.final ? relative_sigma(before, *image.final) : RelativeSigma{};
  const bool known = sigma.position > 0;
  line += ',' + (known ? fixed(sigma.position, 6) : std::string());
  line += ',' + (known ? fixed(sigma.rotation * 180 / M_PI, 5) : std::string());
  return line + ',' + weaknesses(health) + '\n';
}

nlohmann::ordered_json to_json(const Alert& alert) {
  nlohmann::ordered_json json;
  json["time_s"] = seconds(alert.time);
  json["image"] = alert.image ? nlohmann::ordered_json(*alert.image) : nlohmann::ordered_json();
  json["kind"] = to_string(alert.kind);
  json["message"] = alert.message;
  json["remedy"] = alert.remedy;
  return json;
}

nlohmann::ordered_json to_json(const Mark& mark) {
  nlohmann::ordered_json json;
  json["id"] = mark.id;
  json["time_s"] = seconds(mark.time);
  json["image"] = mark.image ? nlohmann::ordered_json(*mark.image) : nlohmann::ordered_json();
  json["note"] = mark.note;
  return json;
}

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

bool write_trajectory(LooseFile& file, const Ledger& ledger,
                      std::optional<ImagePose> ImageFacts::*which) {
  std::vector<const ImagePose*> poses;
  for (const auto& [number, image] : ledger.images) {
    if (image.*which) poses.push_back(&*(image.*which));
  }
  std::ranges::stable_sort(poses, {}, &ImagePose::time);
  const Scale scale = which == &ImageFacts::live ? ledger.live_scale() : ledger.scale();
  file.write("# seconds tx ty tz qx qy qz qw: survey_from_camera, " + scale_text(scale) + '\n');
  for (const ImagePose* pose : poses) file.write(tum_line(*pose));
  return true;
}

bool write_track(LooseFile& file, const Ledger& ledger) {
  constexpr int kMetreDecimals = 4, kDegreeDecimals = 9;  // a tenth of a millimetre
  const reference::UtmGrid& grid = *ledger.grid;
  file.write("image,seconds,easting,northing,height,latitude,longitude,submap\n");
  for (const auto& [number, image] : ledger.images) {
    if (!image.final) continue;
    const Eigen::Vector3d& x_in_survey = image.final->survey_from_camera.translation;
    const Eigen::Vector2d place = grid(Eigen::Vector2d(x_in_survey.head<2>()));
    const auto geodetic = grid.geodetic(x_in_survey);
    std::string line = padded(number, 1) + ',' + seconds_text(image.final->time);
    for (const double value : {place.x(), place.y(), grid.origin().height + x_in_survey.z()})
      line += ',' + fixed(value, kMetreDecimals);
    line += ',' + (geodetic ? fixed(geodetic->latitude_deg, kDegreeDecimals) : std::string());
    line += ',' + (geodetic ? fixed(geodetic->longitude_deg, kDegreeDecimals) : std::string());
    file.write(line + ',' + padded(image.final->submap, 1) + '\n');
  }
  return true;
}

bool write_alerts(LooseFile& file, const Ledger& ledger) {
  for (const Alert& alert : ledger.alerts) {
    file.write(text_of(to_json(alert)) + '\n');
  }
  return true;
}

bool write_marks(LooseFile& file, const Ledger& ledger) {
  for (const auto& [id, facts] : ledger.marks) {
    const Eigen::Vector3d& x_in_survey = facts.mark.position;
    nlohmann::ordered_json json = to_json(facts.mark);
    json["position_survey_units"] = {x_in_survey.x(), x_in_survey.y(), x_in_survey.z()};
    if (ledger.grid) {
      const Eigen::Vector2d place = (*ledger.grid)(Eigen::Vector2d(x_in_survey.head<2>()));
      json["easting_m"] = place.x();
      json["northing_m"] = place.y();
    }
    file.write(text_of(json) + '\n');
  }
  return true;
}

bool write_marks_on_earth(LooseFile& file, const Ledger& ledger) {
  nlohmann::ordered_json features = nlohmann::ordered_json::array();
  for (const auto& [id, facts] : ledger.marks) {
    const auto place = ledger.grid->geodetic(facts.mark.position);
    if (!place) continue;
    features.push_back(
        {{"type", "Feature"},
         {"geometry",
          {{"type", "Point"},
           {"coordinates", {place->longitude_deg, place->latitude_deg, place->height}}}},
         {"properties", to_json(facts.mark)}});
  }
  file.write(text_of({{"type", "FeatureCollection"}, {"features", features}}) + '\n');
  return true;
}

bool write_health(LooseFile& file, const Ledger& ledger) {
  file.write(
      "image,name,seconds,state,oriented,submap,tie_points,top_left,top_right,bottom_left,"
      "bottom_right,tracked_length,rms_px,sharpness,exposure,relative_sigma,relative_sigma_deg,"
      "weak\n");
  const ImagePose* before = nullptr;
  for (const auto& [number, image] : ledger.images) {
    if (image.recorded) file.write(health_line(number, image, before));
    if (image.final) before = &*image.final;
  }
  return true;
}

}  // namespace nadir::record

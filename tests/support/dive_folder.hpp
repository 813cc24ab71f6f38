// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Runs the nadir program on folders and reads what it wrote, for tests end to end.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace nadir::support {

namespace fs = std::filesystem;

/// A folder of its own below the test's working directory, empty at construction.
inline fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::current_path() / "scratch" / (name + '-' + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder.parent_path());
  return folder;
}

inline std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// Exit status of a shell command; what it printed goes to the log.
inline int run(const std::string& command, const fs::path& log) {
  const int status = std::system((command + " >'" + log.string() + "' 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

inline nlohmann::json dive_json(const fs::path& dive) {
  return nlohmann::json::parse(contents(dive / "dive.json"));
}

/// Fields of a table's lines; the first, with the columns' names, is left out.
inline std::vector<std::vector<std::string>> rows_of(const fs::path& csv) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream stream(csv);
  std::string line, field;
  std::getline(stream, line);  // the columns' names
  while (std::getline(stream, line)) {
    rows.emplace_back();
    for (std::istringstream fields(line); std::getline(fields, field, ',');) {
      rows.back().push_back(field);
    }
  }
  return rows;
}

/// Poses of a TUM trajectory by time in milliseconds.
inline std::map<long, Eigen::Isometry3d> poses(const fs::path& tum) {
  std::map<long, Eigen::Isometry3d> found;
  std::ifstream stream(tum);
  for (std::string line; std::getline(stream, line);) {
    double t = 0;
    Eigen::Vector3d x;
    Eigen::Quaterniond q;
    std::istringstream text(line);
    if (line.starts_with('#') ||
        !(text >> t >> x[0] >> x[1] >> x[2] >> q.x() >> q.y() >> q.z() >> q.w()))
      continue;
    found[std::lround(1000 * t)] = Eigen::Translation3d(x) * q.normalized();
  }
  return found;
}

inline std::map<long, Eigen::Vector3d> positions(const fs::path& tum) {
  std::map<long, Eigen::Vector3d> found;
  for (const auto& [time, pose] : poses(tum)) found[time] = pose.translation();
  return found;
}

struct Fit {
  std::size_t images = 0;
  double rmse = 0;
  double scale = 1;  ///< of the estimate against the truth; 1 when rigid
};

/// RMSE of the positions after the best rotation and translation, and scale if free (Umeyama 1991).
/// Of the images first to last alone, as the truth counts them, with `ranges`.
inline Fit fit(const fs::path& estimate, const fs::path& truth, bool free_scale,
               const std::vector<std::pair<int, int>>& ranges = {}) {
  auto estimated = positions(estimate);
  const auto exact = positions(truth);
  int image = 0;
  for (const auto& [time, x] : exact) {
    const bool wanted = ranges.empty() || std::ranges::any_of(ranges, [&](const auto& range) {
                          return range.first <= image && image <= range.second;
                        });
    if (!wanted) estimated.erase(time);
    ++image;
  }
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> pairs;
  for (const auto& [t, x] : estimated) {
    if (const auto found = exact.find(t); found != exact.end())
      pairs.emplace_back(x, found->second);
  }
  Fit result{pairs.size(), 0, 1};
  if (pairs.size() < 3) return result;
  Eigen::Matrix3Xd from(3, pairs.size()), to(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = pairs[i].first;
    to.col(static_cast<Eigen::Index>(i)) = pairs[i].second;
  }
  const Eigen::Matrix4d transform = Eigen::umeyama(from, to, free_scale);
  const Eigen::Matrix3Xd rest =
      (transform.topLeftCorner<3, 3>() * from).colwise() + transform.topRightCorner<3, 1>() - to;
  result.rmse = std::sqrt(rest.colwise().squaredNorm().mean());
  result.scale = 1 / std::cbrt(transform.topLeftCorner<3, 3>().determinant());
  return result;
}

/// Every regular file below a folder, by its relative name.
inline std::map<std::string, std::string> all_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = contents(entry.path());
  }
  return files;
}

}  // namespace nadir::support

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "beside.hpp"

#include "file.hpp"
#include "nadir/calibration/rig_file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::capture {

namespace fs = std::filesystem;

fs::path calibration_file(const fs::path& folder, const std::optional<fs::path>& calibration) {
  return calibration.value_or(folder / "calib.yml");
}

CameraRig load_calibration(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    throw InputError(
        printable(file.string()) +
        ": there is no calibration; add it, or name another (--calib FILE, capture.calibration)");
  }
  return calibration::load_rig(file);
}

std::optional<calibration::Lasers> lasers_beside(const fs::path& folder) {
  const fs::path file = folder / "lasers.yml";
  std::error_code ignored;
  return fs::exists(file, ignored) ? std::optional(calibration::load_lasers(file)) : std::nullopt;
}

}  // namespace nadir::capture

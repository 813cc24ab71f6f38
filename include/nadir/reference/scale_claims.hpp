// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What each source says of the sub-maps' scales: the most certain is used, any two are compared.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "nadir/core/revision.hpp"
#include "nadir/core/window.hpp"
#include "nadir/reference/known_length.hpp"
#include "nadir/reference/laser_scale.hpp"
#include "nadir/reference/sensor_scale.hpp"

namespace nadir::reference {

/// A pair of cameras or given poses scale a map when it is placed; else the most certain of a known
/// length, lasers, altimeter and changes of depth does, also later on.
class ScaleClaims {
 public:
  /// lasers must be without fault. altimeter_below_camera: see SensorScale.
  ScaleClaims(double altimeter_below_camera, const std::optional<KnownLength>& length,
              const std::optional<calibration::Lasers>& lasers);

  /// To be told before the image is oriented.
  void observe(const LaserDots& dots);

  /// Metres per unit of the window that starts a sub-map, by the lasers. Its frame is free.
  std::optional<ScaleMeasure> by_lasers(const Window& initial);

  /// A sub-map was placed: enlarged by factor, its scale told.
  void placed(std::uint32_t submap, double factor, const Scale& told);

  /// Measures. Alerts when two sources disagree, once for each two and sub-map; when a sensor fails
  /// (see SensorScale) or 20 oriented images over 5 s show no dots of the lasers, once. A sensor
  /// that fails gives way to the next claim.
  [[nodiscard]] std::vector<Alert> observe(const Orientation& orientation);

  /// See SensorScale.
  void forget_vertical();

  /// After observe(): the scale of the orientation's sub-map when it has become clearly better
  /// since it was last told; at the end, without a shot, those of all that were measured.
  std::vector<ScaleEstimate> improved(const Orientation& orientation);

 private:
  struct Claim {
    ScaleSource source = ScaleSource::none;
    ScaleMeasure measure;
  };

  std::vector<Claim> claims_of(std::uint32_t submap) const;
  static std::optional<Claim> best_of(const std::vector<Claim>& claims);
  static bool agree(const Claim& one, const Claim& other);
  std::vector<Alert> conflicts(const Orientation& orientation);
  std::vector<Alert> failing_sensors(const Orientation& orientation);
  std::vector<Alert> unseen_lasers(const Orientation& orientation);
  void withdraw(ScaleSource source);
  Alert alert(const Shot* shot, AlertKind kind, std::string message, std::string remedy) const;

  SensorScale sensors_;
  std::optional<TypedScale> typed_;
  std::optional<LaserScale> lasers_;
  std::size_t with_dots_ = 0;         ///< images
  std::set<std::uint64_t> oriented_;  ///< until the lasers are known to be seen or not
  bool lasers_told_ = false;          ///< that they are not
  std::vector<Claim> newest_;         ///< of the sub-map of the window last observed
  std::optional<Time> first_pose_;
  Time newest_pose_ = 0;
  std::map<std::uint32_t, Scale> told_;  ///< by sub-map: as placed or last improved; an infinite
                                         ///< sigma: of a source that failed since
  std::set<std::tuple<std::uint32_t, ScaleSource, ScaleSource>> in_conflict_;  ///< told
};

}  // namespace nadir::reference

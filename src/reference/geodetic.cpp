// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/geodetic.hpp"

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <charconv>
#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using GeographicLib::UTMUPS;

constexpr double kDegree = std::numbers::pi / 180;

void require_zone(const Geodetic& origin) {
  constexpr double kSouthmost = -80, kNorthmost = 84;
  if (!(origin.latitude_deg >= kSouthmost && origin.latitude_deg <= kNorthmost)) {
    throw InputError("reference.origin: its latitude must be -80 to 84 degrees, where UTM reaches");
  }
  if (!(std::abs(origin.longitude_deg) <= 180)) {
    throw InputError("reference.origin: its longitude must be -180 to 180 degrees");
  }
  if (!(origin.height >= -1000 && origin.height <= 9000)) {
    throw InputError("reference.origin: its height must be -1000 to 9000 metres");
  }
}

// Mean of those along and across the meridian: at the height of a mountain lake both give the same
// scale to 3 millionths.
double radius_of_curvature(double latitude_deg) {
  const double a = GeographicLib::Constants::WGS84_a(), f = GeographicLib::Constants::WGS84_f();
  const double sine = std::sin(latitude_deg * kDegree);
  return a * (1 - f) / (1 - f * (2 - f) * sine * sine);
}

}  // namespace

std::optional<Geodetic> parse_origin(const std::string& text) {
  std::istringstream words(text);
  std::vector<double> numbers;
  bool well_formed = true;
  for (std::string word; words >> word;) {
    const char* const end_of_word = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), end_of_word, numbers.emplace_back());
    well_formed = well_formed && error == std::errc() && end == end_of_word;
  }
  if (numbers.empty()) return std::nullopt;
  if (!well_formed || (numbers.size() != 2 && numbers.size() != 3)) {
    throw InputError(
        "reference.origin must be \"LATITUDE LONGITUDE\" or \"LATITUDE LONGITUDE HEIGHT\" in "
        "decimal degrees and metres, such as \"43.2965 5.3698\", not \"" +
        text + '"');
  }
  const Geodetic origin{numbers[0], numbers[1], numbers.size() == 3 ? numbers[2] : 0};
  require_zone(origin);
  return origin;
}

UtmGrid::UtmGrid(const Geodetic& origin) : origin_(origin) {
  require_zone(origin);
  double convergence_deg = 0;
  UTMUPS::Forward(origin.latitude_deg, origin.longitude_deg, zone_, north_, shift_.x(), shift_.y(),
                  convergence_deg, scale_);
  convergence_ = convergence_deg * kDegree;
  const double radius = radius_of_curvature(origin.latitude_deg);
  scale_ *= radius / (radius + origin.height);
}

WorldFile UtmGrid::operator()(const WorldFile& survey) const {
  WorldFile world = survey;
  for (double* value : {&world.a, &world.d, &world.b, &world.e}) *value *= scale_;
  const Eigen::Vector2d corner = (*this)(Eigen::Vector2d(survey.c, survey.f));
  world.c = corner.x();
  world.f = corner.y();
  return world;
}

std::optional<Geodetic> UtmGrid::geodetic(const Eigen::Vector3d& x_in_survey) const {
  const Eigen::Vector2d place = (*this)(Eigen::Vector2d(x_in_survey.head<2>()));
  Geodetic found{0, 0, origin_.height + x_in_survey.z()};
  try {
    UTMUPS::Reverse(zone_, north_, place.x(), place.y(), found.latitude_deg, found.longitude_deg);
  } catch (const GeographicLib::GeographicErr&) {
    return std::nullopt;
  }
  return found;
}

std::optional<Eigen::Vector2d> UtmGrid::in_survey(const Geodetic& place) const {
  try {
    int zone = 0;
    bool north = true;
    Eigen::Vector2d grid;
    UTMUPS::Forward(place.latitude_deg, place.longitude_deg, zone, north, grid.x(), grid.y(),
                    zone_);
    constexpr double kFalseNorthing = 10'000'000;  // of the southern hemisphere
    if (north != north_) grid.y() += north_ ? -kFalseNorthing : kFalseNorthing;
    return (grid - shift_) / scale_;
  } catch (const GeographicLib::GeographicErr&) {
    return std::nullopt;
  }
}

}  // namespace nadir::reference

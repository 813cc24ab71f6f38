// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/magnetic_model.hpp"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/SphericalHarmonic1.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <locale>
#include <sstream>
#include <vector>

#include "nadir/core/check.hpp"
#include "wmm2025.hpp"

namespace nadir::reference {
namespace {

constexpr int kMost = 12;              // degree and order
constexpr double kRadius = 6'371'200;  // metres, that of the model's expansion

/// In GeographicLib's order: by order m, then by degree n; sines from m = 1.
struct Coefficients {
  std::vector<double> cosine = std::vector<double>((kMost + 1) * (kMost + 2) / 2),
                      sine = std::vector<double>(kMost * (kMost + 1) / 2);
};

std::size_t place_of(int n, int m) {
  return static_cast<std::size_t>(m * kMost - m * (m - 1) / 2 + n);
}

// GeographicLib's own MagneticModel reads files only, which a single program has to find or to
// write first; the same harmonics take their coefficients from memory.
struct Model {
  Model();

  Coefficients at_begin, a_year;  // nanotesla
  GeographicLib::SphericalHarmonic1 potential;
};

// The table as published: after a line of names, n m g h and their changes a year; nines end it.
Model::Model() {
  std::istringstream table(kWmm2025);
  table.imbue(std::locale::classic());
  std::string name, date;
  double begin = 0;
  table >> begin >> name >> date;
  NADIR_CHECK(table && begin == kMagneticModelBegin, begin);
  for (int n = 1; n <= kMost; ++n) {
    for (int m = 0; m <= n; ++m) {
      int degree = 0, order = 0;
      double g = 0, h = 0, dg = 0, dh = 0;
      table >> degree >> order >> g >> h >> dg >> dh;
      NADIR_CHECK(table && degree == n && order == m, n, m);
      const std::size_t at = place_of(n, m);
      at_begin.cosine[at] = g;
      a_year.cosine[at] = dg;
      if (m == 0) continue;
      at_begin.sine[at - (kMost + 1)] = h;
      a_year.sine[at - (kMost + 1)] = dh;
    }
  }
  potential = {at_begin.cosine, at_begin.sine, kMost,   a_year.cosine,
               a_year.sine,     kMost,         kRadius, GeographicLib::SphericalHarmonic1::SCHMIDT};
}

double year_of(Time utc) {
  using namespace std::chrono;
  const sys_time<nanoseconds> time{nanoseconds(utc)};
  const year of = year_month_day(floor<days>(time)).year();
  const sys_days begin = of / January / 1, end = (of + years(1)) / January / 1;
  return static_cast<int>(of) + duration<double>(time - begin) / duration<double>(end - begin);
}

}  // namespace

Eigen::Vector3d magnetic_field(const Geodetic& place, double year) {
  static const Model model;
  Eigen::Vector3d x, gradient;
  std::vector<double> earth_from_local(9);  // rows; local: east, north, up
  GeographicLib::Geocentric::WGS84().Forward(place.latitude_deg, place.longitude_deg, place.height,
                                             x.x(), x.y(), x.z(), earth_from_local);
  model.potential(year - kMagneticModelBegin, x.x(), x.y(), x.z(), gradient.x(), gradient.y(),
                  gradient.z());
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return -kRadius * (Eigen::Map<const Rows>(earth_from_local.data()).transpose() * gradient);
}

MagneticVariation magnetic_variation(const Geodetic& place, Time utc) {
  const double year = year_of(utc);
  const Eigen::Vector3d field =
      magnetic_field(place, std::clamp(year, kMagneticModelBegin, kMagneticModelEnd));
  return {std::atan2(field.x(), field.y()), year};
}

}  // namespace nadir::reference

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "config.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

// Levenshtein distance, for the nearest neighbour of a misspelt key.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

constexpr double kMost = 1e9;  // of any setting; beyond lies only a slip

}  // namespace

void Config::check() const {
  for (const Setting& setting : settings()) {
    const Value value = setting.get(*this);
    const double* number = std::get_if<double>(&value);
    if (number && !(std::abs(*number) <= kMost)) {
      throw InputError(setting.key + " must be a number up to 1e9; correct the setting");
    }
  }
  capture.check();
  sensors.check();
  odometry.check();
  reference.check();
  revisit.check();
  plane.check();
  mosaic2d.check();
  projection3d.check();
  plan.check();
  guide.check();
  const auto origin = reference::parse_origin(reference.origin);
  (void)planned(plan, origin ? std::optional<reference::UtmGrid>(*origin) : std::nullopt);
  record.check();
  serve.check();
}

void assign(Config& config, const std::string& key, const Value& value, const std::string& where) {
  const std::vector<Setting>& table = settings();
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Setting& s) { return s.key == key; });
  if (found == table.end()) {
    const auto nearest =
        std::min_element(table.begin(), table.end(), [&](const Setting& a, const Setting& b) {
          return edit_distance(a.key, key) < edit_distance(b.key, key);
        });
    throw InputError(where + ": there is no setting '" + key + "'; did you mean '" + nearest->key +
                     "'?");
  }
  try {
    found->set(config, value);
  } catch (const InputError& error) {
    throw InputError(where + ": " + key + ' ' + error.what());
  }
}

}  // namespace nadir::app

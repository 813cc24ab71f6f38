// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_log.hpp"

#include <algorithm>
#include <cmath>

#include "csv.hpp"

namespace nadir::capture {
namespace {

constexpr Time kLongestGap = 500'000'000;  // machine.md: 0.5 s

double wrapped(double degrees) { return degrees - 360 * std::floor((degrees + 180) / 360); }

}  // namespace

SensorLog::SensorLog(const std::filesystem::path& file, std::vector<SensorColumn> columns)
    : columns_(std::move(columns)) {
  std::vector<std::string> names{"seconds"};
  for (const SensorColumn& column : columns_) names.push_back(column.name);
  CsvReader csv(file, names);
  std::size_t read = 0;
  while (csv.next()) {
    ++read;
    const double s = csv.number(0);
    Row row;
    bool good = is_time(s);
    if (good) row.time = from_seconds(s);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      row.values[i] = csv.number(i + 1);
      good = good && row.values[i] >= columns_[i].lowest && row.values[i] <= columns_[i].highest;
    }
    if (good) rows_.push_back(row);
  }
  std::stable_sort(rows_.begin(), rows_.end(),
                   [](const Row& a, const Row& b) { return a.time < b.time; });
  rows_.erase(std::unique(rows_.begin(), rows_.end(),
                          [](const Row& a, const Row& b) { return a.time == b.time; }),
              rows_.end());
  dropped_ = read - rows_.size();
}

std::optional<SensorLog::Values> SensorLog::at(Time time) const {
  const auto after = std::lower_bound(rows_.begin(), rows_.end(), time,
                                      [](const Row& row, Time t) { return row.time < t; });
  if (after == rows_.end()) return std::nullopt;
  const bool exact = after->time == time;
  if (!exact && after == rows_.begin()) return std::nullopt;
  const Row& from = exact ? *after : *(after - 1);
  const Time gap = after->time - from.time;
  if (gap > kLongestGap) return std::nullopt;
  const double share = exact ? 0 : static_cast<double>(time - from.time) / static_cast<double>(gap);
  Values values{};
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const double step = after->values[i] - from.values[i];
    values[i] = columns_[i].angle ? wrapped(from.values[i] + share * wrapped(step))
                                  : from.values[i] + share * step;
  }
  return values;
}

}  // namespace nadir::capture

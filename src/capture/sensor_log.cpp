// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_log.hpp"

#include <algorithm>

#include "csv.hpp"

namespace nadir::capture {
namespace {

SensorLog::Values periods_of(const std::vector<SensorColumn>& columns) {
  SensorLog::Values periods{};
  for (std::size_t i = 0; i < columns.size(); ++i) periods[i] = columns[i].angle ? 360 : 0;
  return periods;
}

}  // namespace

SensorLog::SensorLog(const std::filesystem::path& file, const std::vector<SensorColumn>& columns)
    : track_(periods_of(columns)) {
  std::vector<std::string> names{"seconds"};
  for (const SensorColumn& column : columns) names.push_back(column.name);
  CsvReader csv(file, names);
  std::vector<SensorTrack::Row> rows;
  std::size_t read = 0;
  while (csv.next()) {
    ++read;
    const double s = csv.number(0);
    SensorTrack::Row row;
    bool good = is_time(s);
    if (good) row.time = from_seconds(s);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      row.values[i] = csv.number(i + 1);
      good = good && row.values[i] >= columns[i].lowest && row.values[i] <= columns[i].highest;
    }
    if (good) rows.push_back(row);
  }
  std::ranges::stable_sort(rows, {}, &SensorTrack::Row::time);
  for (const auto& row : rows) track_.add(row.time, row.values);
  dropped_ = read - size();
}

}  // namespace nadir::capture

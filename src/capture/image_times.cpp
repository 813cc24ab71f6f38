// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_times.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <unordered_map>

#include "csv.hpp"
#include "file.hpp"
#include "nadir/core/check.hpp"
#include "nadir/image_io/exif.hpp"

namespace nadir::capture {
namespace {

using OptionalTimes = std::vector<std::optional<Time>>;

OptionalTimes times_from_csv(const std::filesystem::path& file, const ImageList& list) {
  CsvReader csv(file, {"frame", "seconds"});
  std::unordered_map<std::string, std::optional<Time>> time_of;
  while (csv.next()) {
    const double s = csv.number(1);
    const auto time = is_time(s) ? std::optional(from_seconds(s)) : std::nullopt;
    const std::string frame(csv.text(0));
    if (!time_of.emplace(frame, time).second) csv.fail("gives " + printable(frame) + " twice");
  }
  OptionalTimes times(list.images.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    auto found = time_of.find(list.stem(i));
    if (found == time_of.end()) found = time_of.find(list.images[i].left);
    if (found != time_of.end()) times[i] = found->second;
  }
  const bool any = std::any_of(times.begin(), times.end(), [](const auto& t) { return t; });
  if (!any) {
    throw InputError(file.string() + ": has a time for none of the images, such as " +
                     printable(list.stem(0)) +
                     "; its column frame holds their names without extension");
  }
  return times;
}

// All or nothing: a sequence of which some have a time and others not has no order to trust.
std::optional<std::vector<ImageTime>> times_from_exif(const ImageList& list) {
  constexpr std::size_t kHead = 128 << 10;  // EXIF is at most 64 kB, at the start of a JPEG
  std::vector<ImageTime> times;
  for (const ImageFiles& files : list.images) {
    const auto time =
        image_io::read_exif_time(read_head(list.left_folder / files.left, kHead).bytes);
    if (!time || (!times.empty() && *time <= times.back().time)) return std::nullopt;
    times.push_back({*time, {}});
  }
  return times;
}

// Which to keep so that times increase strictly and fewest are lost: the longest increasing
// subsequence, so that one wild time cannot cost all that follow.
std::vector<bool> longest_increasing(const OptionalTimes& times) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> best_end;  // of the subsequences of each length, the one ending earliest
  std::vector<std::size_t> before(times.size(), kNone);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!times[i]) continue;
    const auto place =
        std::lower_bound(best_end.begin(), best_end.end(), *times[i],
                         [&](std::size_t end, Time time) { return *times[end] < time; });
    if (place != best_end.begin()) before[i] = *(place - 1);
    if (place == best_end.end()) {
      best_end.push_back(i);
    } else {
      *place = i;
    }
  }
  std::vector<bool> keep(times.size());
  for (std::size_t i = best_end.empty() ? kNone : best_end.back(); i != kNone; i = before[i]) {
    keep[i] = true;
  }
  return keep;
}

std::vector<ImageTime> increasing(const OptionalTimes& times) {
  const std::vector<bool> keep = longest_increasing(times);
  std::vector<ImageTime> result(times.size());
  const auto first =
      static_cast<std::size_t>(std::find(keep.begin(), keep.end(), true) - keep.begin());
  Time last = times[first].value_or(0);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (keep[i]) {
      last = *times[i];
    } else {
      result[i].fault = times[i] ? "its time does not fit the order of the images"
                                 : "has no time in timestamps.csv";
    }
    result[i].time = last;
  }
  return result;
}

}  // namespace

std::vector<ImageTime> image_times(const std::filesystem::path& survey_folder,
                                   const ImageList& list) {
  const auto csv = survey_folder / "timestamps.csv";
  std::error_code ignored;
  if (std::filesystem::exists(csv, ignored)) return increasing(times_from_csv(csv, list));
  if (auto times = times_from_exif(list)) return *std::move(times);
  std::vector<ImageTime> times(list.images.size());
  for (std::size_t i = 0; i < times.size(); ++i)
    times[i].time = static_cast<Time>(i) * 1'000'000'000;
  return times;
}

}  // namespace nadir::capture

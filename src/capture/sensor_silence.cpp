// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_silence.hpp"

#include <cstdio>

namespace nadir::capture {
namespace {

constexpr Time kShortest = 5'000'000'000;  // ten images of a film are too soon

std::string in_seconds(Time time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", seconds(time));
  return text;
}

std::string span(Time from, Time to) { return in_seconds(from) + " to " + in_seconds(to) + " s"; }

}  // namespace

std::optional<Alert> SensorSilence::observe(const Frame& frame, bool has_value,
                                            const std::string& file, const SensorLog& log) {
  newest_image_ = frame.image;
  newest_time_ = frame.time;
  if (has_value) {
    last_value_ = frame.time;
    images_ = 0;
    told_ = false;
    return std::nullopt;
  }
  if (images_++ == 0) {
    first_image_ = frame.image;
    first_time_ = frame.time;
  }
  const bool is_long =
      images_ >= enough_ && frame.time - last_value_.value_or(first_time_) >= kShortest;
  if (told_ || !is_long) return std::nullopt;
  return tell(file, log);
}

std::optional<Alert> SensorSilence::finish(const std::string& file, const SensorLog& log) {
  if (told_ || last_value_ || images_ == 0) return std::nullopt;
  return tell(file, log);
}

Alert SensorSilence::tell(const std::string& file, const SensorLog& log) {
  told_ = true;
  enough_ = 2 * images_;
  const auto [from, to] = log.span();
  return {
      newest_time_, newest_image_, AlertKind::sensor_stale,
      file + " says nothing of images " + std::to_string(first_image_) + " to " +
          std::to_string(newest_image_) + " (" + span(first_time_, newest_time_) + ")" +
          (last_value_ ? ", the last it told of was at " + in_seconds(*last_value_) + " s" : "") +
          "; its " + std::to_string(log.size()) + " rows are of " + span(from, to),
      "give sensor and images the same clock or correct timestamps.csv; rows more than "
      "0.5 s apart say nothing between them; the map goes on without this sensor"};
}

}  // namespace nadir::capture

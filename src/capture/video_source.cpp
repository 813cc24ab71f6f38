// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/capture/video_source.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "beside.hpp"
#include "child_process.hpp"
#include "file.hpp"
#include "nadir/core/check.hpp"
#include "nadir/image_io/reduce.hpp"
#include "survey_sensors.hpp"

namespace nadir::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds kPatience(60);  // a slow board and a large image

// Of this machine's files, whatever a playlist or a name says.
std::vector<std::string> input_of(const fs::path& video) {
  return {"-protocol_whitelist", "file", "-i", "file:" + video.string()};
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// 30000/1001
double ratio(std::string_view text) {
  const std::size_t slash = text.find('/');
  const auto above = number(text.substr(0, slash));
  const auto below = slash == text.npos ? std::optional(1.0) : number(text.substr(slash + 1));
  return above && below && *below > 0 ? *above / *below : 0;
}

struct VideoInfo {
  int width = 0, height = 0;
  double rate_hz = 0, duration_s = 0;  ///< 0: unknown
};

VideoInfo probe(const fs::path& video) {
  std::vector<std::string> command{"ffprobe",
                                   "-v",
                                   "error",
                                   "-select_streams",
                                   "v:0",
                                   "-show_entries",
                                   "stream=width,height,avg_frame_rate:format=duration",
                                   "-of",
                                   "default=noprint_wrappers=1"};
  std::ranges::move(input_of(video), std::back_inserter(command));
  std::string text;
  std::string fault;
  try {
    ChildProcess ffprobe(command);
    std::uint8_t byte = 0;
    constexpr std::size_t kMost = 4096;
    while (text.size() < kMost && ffprobe.read({&byte, 1}, kPatience))
      text += static_cast<char>(byte);
    ffprobe.end();
    while (const auto line = ffprobe.next_line()) fault = *line;
  } catch (const InputError& error) {
    throw InputError(printable(video.string()) +
                     ": videos are decoded by ffmpeg, which cannot be run (" + error.what() +
                     "); install it: apt-get install ffmpeg");
  }
  std::map<std::string, std::string> values;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    const std::size_t equals = line.find('=');
    if (equals != line.npos) values[line.substr(0, equals)] = line.substr(equals + 1);
    begin = end + 1;
  }
  VideoInfo info;
  info.width = static_cast<int>(number(values["width"]).value_or(0));
  info.height = static_cast<int>(number(values["height"]).value_or(0));
  info.rate_hz = ratio(values["avg_frame_rate"]);
  info.duration_s = number(values["duration"]).value_or(0);
  if (info.width <= 0 || info.height <= 0) {
    throw InputError(printable(video.string()) + ": is no video that ffmpeg can read" +
                     (fault.empty() ? "" : " (" + printable(fault) + ")") +
                     "; give a video file, or a folder of images");
  }
  return info;
}

std::vector<std::string> decoding(const fs::path& video, double rate_hz) {
  // Microseconds, since showinfo rounds seconds to six digits.
  std::string filter = "settb=1/1000000,showinfo";
  if (rate_hz > 0) {
    filter = "select='isnan(prev_selected_t)+gte(t-prev_selected_t," +
             std::to_string(kRateSlack / rate_hz) + ")'," + filter;
  }
  std::vector<std::string> command{"ffmpeg", "-nostdin", "-hide_banner", "-nostats",
                                   "-noautorotate"};
  std::ranges::move(input_of(video), std::back_inserter(command));
  for (const char* word : {"-map", "0:v:0", "-vf"}) command.emplace_back(word);
  command.push_back(filter);
  for (const char* word :
       {"-fps_mode", "passthrough", "-pix_fmt", "bgr24", "-f", "rawvideo", "pipe:1"})
    command.emplace_back(word);
  return command;
}

}  // namespace

struct VideoSource::State {
  fs::path video;
  VideoInfo info;
  CameraRig full_rig;
  std::shared_ptr<const CameraRig> rig;
  int divisor = 1;
  std::optional<calibration::Lasers> lasers;
  std::optional<SurveySensors> sensors;
  std::size_t expected = 0;
  std::optional<ChildProcess> ffmpeg;
  std::uint64_t next_image = 0;
  std::optional<Time> newest;
  std::string last_line;  ///< of ffmpeg that is no image's
  std::optional<Shot> following;

  std::optional<Time> time_of_next();
  std::optional<Shot> read();
  void finish(std::vector<Alert>& alerts);
};

// showinfo writes a line before each image: [Parsed_showinfo_2 @ 0x55] n:   7 pts: 1400000 ...
std::optional<Time> VideoSource::State::time_of_next() {
  constexpr std::string_view kBegin = "[Parsed_showinfo";
  while (const auto line = ffmpeg->next_line()) {
    const auto value = [&](std::string_view key) -> std::optional<std::int64_t> {
      const std::size_t at = line->find(key);
      const std::size_t first =
          at == line->npos ? at : line->find_first_not_of(' ', at + key.size());
      if (first == line->npos) return std::nullopt;
      std::int64_t whole = 0;
      const char* end = line->data() + line->size();
      const auto [stop, error] = std::from_chars(line->data() + first, end, whole);
      return error == std::errc() ? std::optional(whole) : std::nullopt;
    };
    const bool is_image = line->starts_with(kBegin);
    const auto number = is_image ? value(" n:") : std::nullopt;
    if (!is_image) last_line = *line;
    if (!number || static_cast<std::uint64_t>(*number) != next_image) continue;
    constexpr std::int64_t kLongest = 1'000'000'000'000'000;  // microseconds, 32 years
    const auto us = value(" pts:");
    return us && std::abs(*us) < kLongest ? std::optional(*us * 1000) : std::nullopt;
  }
  return std::nullopt;
}

VideoSource::VideoSource(const fs::path& video, const std::optional<fs::path>& calibration,
                         const Config& config)
    : state_(std::make_unique<State>()) {
  config.check();
  State& s = *state_;
  s.video = video;
  const fs::path folder = video.parent_path();
  s.full_rig = load_calibration(calibration_file(folder, calibration));
  s.full_rig.right.reset();
  s.full_rig.body_from_camera = config.body_from_camera();
  s.info = probe(video);
  const CameraModel& camera = s.full_rig.left;
  if (camera.width != s.info.width || camera.height != s.info.height) {
    throw InputError(printable(video.string()) + ": is " + std::to_string(s.info.width) + " x " +
                     std::to_string(s.info.height) + " px, the calibration is for " +
                     std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                     " px; give the calibration of this camera and video mode");
  }
  s.divisor = config.divisor();
  s.rig = std::make_shared<const CameraRig>(s.full_rig.reduced(s.divisor));
  s.sensors.emplace(folder);
  s.lasers = lasers_beside(folder);
  const double rate =
      config.rate_hz > 0 ? std::min(config.rate_hz, s.info.rate_hz) : s.info.rate_hz;
  s.expected = static_cast<std::size_t>(std::max(0.0, std::round(rate * s.info.duration_s)));
  s.ffmpeg.emplace(decoding(video, config.rate_hz));
  s.following = s.read();
  if (s.following) return;
  std::vector<Alert> alerts;
  s.finish(alerts);
  throw InputError(printable(video.string()) + ": ffmpeg decoded no image of it (" +
                   printable(s.last_line) + "); copy the video again, or convert it");
}

VideoSource::~VideoSource() = default;

std::size_t VideoSource::size() const {
  return std::max<std::size_t>(state_->expected, state_->next_image);
}
std::shared_ptr<const CameraRig> VideoSource::rig() const { return state_->rig; }
const std::optional<calibration::Lasers>& VideoSource::lasers() const { return state_->lasers; }

std::optional<Shot> VideoSource::next() {
  State& s = *state_;
  if (!s.following) return std::nullopt;
  Shot shot = *std::exchange(s.following, std::nullopt);
  s.following = s.read();
  if (!s.following) s.finish(shot.alerts);
  return shot;
}

std::optional<Shot> VideoSource::State::read() {
  cv::Mat picture(info.height, info.width, CV_8UC3);
  const std::span<std::uint8_t> bytes(picture.data, picture.total() * picture.elemSize());
  if (!ffmpeg->read(bytes, kPatience)) return std::nullopt;
  const std::optional<Time> time = time_of_next();
  Shot shot;
  shot.image = next_image++;
  shot.time = time.value_or(newest.value_or(0));
  std::string digits = std::to_string(shot.image);
  digits.insert(0, 6 - std::min<std::size_t>(6, digits.size()), '0');
  shot.name = printable(video.stem().string()) + '-' + digits;
  shot.alerts = sensors->new_faults(shot.time);
  if (!time || (newest && *time <= *newest)) {
    shot.time = std::max(shot.time, newest.value_or(shot.time));
    shot.alerts.push_back({shot.time, shot.image, AlertKind::image_rejected,
                           shot.name + ": has no time later than the image before",
                           "the dive goes on without it; convert the video to constant times"});
    return shot;
  }
  newest = time;
  Frame frame;
  frame.image = shot.image;
  frame.time = shot.time;
  frame.name = shot.name;
  frame.rig = rig;
  frame.colour = image_io::reduce(picture, divisor);
  cv::cvtColor(frame.colour, frame.grey, cv::COLOR_BGR2GRAY);
  sensors->read(frame, shot.alerts);
  shot.frame = std::make_shared<const Frame>(std::move(frame));
  return shot;
}

void VideoSource::State::finish(std::vector<Alert>& alerts) {
  const std::optional<int> status = ffmpeg->end();
  while (const auto line = ffmpeg->next_line()) last_line = *line;
  sensors->finish(alerts);
  if (status == 0) return;
  alerts.push_back({newest.value_or(0), std::nullopt, AlertKind::image_rejected,
                    printable(video.string()) + ": ffmpeg could not decode it to its end (" +
                        printable(last_line) + ")",
                    "the images before are mapped; copy the video again"});
}

}  // namespace nadir::capture

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/capture/camera_source.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "beside.hpp"
#include "camera_link.hpp"
#include "file.hpp"
#include "nadir/core/check.hpp"
#include "nadir/core/rounded.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/encode.hpp"
#include "nadir/pipeline/progress.hpp"
#include "pairing.hpp"

namespace nadir::capture {
namespace {

constexpr Time kMillisecond = 1'000'000;
constexpr Time kSecond = 1000 * kMillisecond;
constexpr Time kNoSkew = std::numeric_limits<Time>::max();
constexpr Time kTellLost = 10 * kSecond;  // losses of so long are told together

/// Wakes a thread that waits in poll(2).
class WakeUp {
 public:
  WakeUp() : file_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (file_ < 0) throw InputError(std::string("no eventfd: ") + std::strerror(errno));
  }
  ~WakeUp() { ::close(file_); }
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;
  int descriptor() const { return file_; }
  void ring() const { ::eventfd_write(file_, 1); }

 private:
  int file_;
};

image_io::Decoded decode(const Picture& picture, const CameraModel& camera, int divisor,
                         image_io::Colour colour) {
  if (!picture.encoding.raw)
    return image_io::decode(picture.bytes, camera.width, camera.height, divisor, colour);
  const image_io::RawImage raw{*picture.encoding.raw, picture.encoding.order,  camera.width,
                               camera.height,         picture.encoding.stride, picture.bytes};
  return image_io::decode_raw(raw, divisor, colour);
}

// As it came, or what was not compressed with next to no loss.
std::vector<std::uint8_t> as_jpeg(const Picture& picture, const CameraModel& camera) {
  if (!picture.encoding.raw) return {picture.bytes.begin(), picture.bytes.end()};
  constexpr int kQuality = 95;
  const image_io::Decoded full = decode(picture, camera, 1, image_io::Colour::bgr);
  return image_io::encode_jpeg(full.image, kQuality, image_io::Chroma::full);
}

std::string numbered(std::uint64_t image) {
  std::string digits = std::to_string(image);
  digits.insert(0, 6 - std::min<std::size_t>(6, digits.size()), '0');
  return digits;
}

CameraLink link_to(const std::string& name, std::string role, const CameraModel& camera,
                   const Config& config) {
  const CameraMode mode{camera.width,       camera.height, config.rate_hz,
                        config.exposure_ms, config.gain,   config.focus};
  return {std::move(role), [name, mode] { return open_camera(name, mode); }};
}

CameraRig rig_of(const Config& config) {
  config.check();
  CameraRig rig = load_calibration(config.calibration);
  if (config.camera_right.empty()) {
    rig.right.reset();
  } else if (!rig.right) {
    throw InputError(config.calibration +
                     ": has one camera, capture.camera_right makes two; calibrate the pair");
  }
  rig.body_from_camera = config.body_from_camera();
  return rig;
}

}  // namespace

struct CameraSource::State {
  State(const Config& configured, bool keep)
      : config(configured),
        keep_originals(keep),
        full_rig(rig_of(config)),
        rig(std::make_shared<const CameraRig>(full_rig.reduced(config.divisor()))),
        lasers(lasers_beside(std::filesystem::path(config.calibration).parent_path())) {
    if (is_pair()) {
      links.push_back(link_to(config.camera, "left camera", full_rig.left, config));
      links.push_back(link_to(config.camera_right, "right camera", full_rig.right->camera, config));
    } else {
      links.push_back(link_to(config.camera, "camera", full_rig.left, config));
    }
  }

  bool is_pair() const { return full_rig.right.has_value(); }
  std::optional<Picture> take_whole(CameraLink& link, Time now, std::vector<Alert>& alerts);
  std::optional<PicturePair> take_pictures(Time now, std::vector<Alert>& alerts);
  std::optional<Shot> next_shot(Time now, std::vector<Alert>& alerts);
  std::shared_ptr<const OriginalImages> originals_of(const PicturePair& pictures) const;
  std::string decode_into(Frame& frame, const PicturePair& pictures) const;
  std::uint32_t missed_before(Time time);
  void lose(std::uint32_t images, const std::string& fault);
  void tell_lost(Time now, std::optional<std::uint64_t> image, std::vector<Alert>& alerts);
  void tell_skew(const Shot& shot, std::vector<Alert>& alerts);
  void steer_exposure(const Frame& frame);
  void wait(Time until) const;

  const Config config;
  const bool keep_originals;
  const CameraRig full_rig;
  const std::shared_ptr<const CameraRig> rig;
  const std::optional<calibration::Lasers> lasers;
  WakeUp wake_up;
  std::vector<CameraLink> links;
  Pairing pairing;
  std::uint64_t next_image = 0;
  std::optional<Time> newest;  ///< image handed out
  std::uint32_t lost = 0;      ///< by the cameras since then
  std::uint64_t lost_untold = 0;
  std::string last_fault;    ///< of those
  std::optional<Time> told;  ///< when losses were
  double skew_told_ms = 0;   ///< the largest
  std::atomic<Time> last_skew = kNoSkew;
  std::atomic<double> speed_px = 0;  ///< of the ground in the images, a second
  std::optional<ExposureControl> exposure;
  std::atomic<double> exposure_ms = 0;  ///< 0: unknown
  int steered = 0;                      ///< which opening of the camera it is of
  int exposed = 0;                      ///< openings of all cameras when they were last set
};

CameraSource::CameraSource(const Config& config, bool keep_originals)
    : state_(std::make_unique<State>(config, keep_originals)) {}
CameraSource::~CameraSource() = default;
std::shared_ptr<const CameraRig> CameraSource::rig() const { return state_->rig; }
const std::optional<calibration::Lasers>& CameraSource::lasers() const { return state_->lasers; }

void CameraSource::count_anew() {
  state_->next_image = 0;
  state_->lost = 0;
}

void CameraSource::note_speed(double px_a_second) { state_->speed_px = px_a_second; }

std::optional<double> CameraSource::exposure_ms() const {
  if (state_->config.exposure_ms > 0) return state_->config.exposure_ms;
  const double known = state_->exposure_ms;
  return known > 0 ? std::optional(known) : std::nullopt;
}

std::optional<Time> CameraSource::skew() const {
  const Time skew = state_->last_skew;
  return skew == kNoSkew ? std::nullopt : std::optional(skew);
}

std::optional<Captured> CameraSource::next(const std::stop_token& stop) {
  State& s = *state_;
  const std::stop_callback wake(stop, [&] { s.wake_up.ring(); });
  const Time until = monotonic_now() + kSecond;
  Captured captured;
  for (Time now = 0; now < until; s.wait(until)) {
    if (stop.stop_requested()) return std::nullopt;
    now = monotonic_now();
    captured.shot = s.next_shot(now, captured.alerts);
    if (captured.shot) break;
    for (CameraLink& link : s.links) {
      link.keep_open(now, captured.alerts);
      pipeline::note_progress();
    }
    if (!captured.alerts.empty()) break;
  }
  // Of images that all come damaged no shot tells.
  if (!captured.shot) s.tell_lost(monotonic_now(), std::nullopt, captured.alerts);
  return captured;
}

// Until a camera has something, one is to be opened, or told to stop.
void CameraSource::State::wait(Time until) const {
  std::vector<pollfd> waiting{{wake_up.descriptor(), POLLIN, 0}};
  for (const CameraLink& link : links) {
    if (link.is_open()) waiting.push_back({link.descriptor(), POLLIN | POLLPRI, 0});
    until = std::min(until, link.due());
  }
  const Time left = std::max<Time>(0, until - monotonic_now());
  const Time whole_ms = (left + kMillisecond - 1) / kMillisecond;
  ::poll(waiting.data(), waiting.size(), static_cast<int>(whole_ms));
}

void CameraSource::State::lose(std::uint32_t images, const std::string& fault) {
  if (images == 0) return;
  lost += images;
  lost_untold += images;
  last_fault = fault;
}

std::optional<Picture> CameraSource::State::take_whole(CameraLink& link, Time now,
                                                       std::vector<Alert>& alerts) {
  while (auto picture = link.take(now, alerts)) {
    const bool counts = &link == &links.front();  // a pair is one image
    if (counts) lose(picture->lost_before, "lost on the way from the camera");
    if (picture->fault.empty()) return picture;
    if (counts) lose(1, picture->fault);
  }
  return std::nullopt;
}

std::optional<PicturePair> CameraSource::State::take_pictures(Time now,
                                                              std::vector<Alert>& alerts) {
  if (!is_pair()) {
    auto picture = take_whole(links[0], now, alerts);
    return picture ? std::optional(PicturePair{*std::move(picture), {}}) : std::nullopt;
  }
  while (auto left = take_whole(links[0], now, alerts))
    pairing.add(Pairing::Side::left, *std::move(left));
  while (auto right = take_whole(links[1], now, alerts))
    pairing.add(Pairing::Side::right, *std::move(right));
  auto pair = pairing.take(std::min(links[0].period(), links[1].period()));
  lose(pairing.take_unpaired(), "the other camera took none at that time");
  return pair;
}

std::optional<Shot> CameraSource::State::next_shot(Time now, std::vector<Alert>& alerts) {
  // A driver in trouble may give its last image over and over, as fast as it is asked.
  constexpr double kFastest_hz = 200;
  const double rate_hz = config.rate_hz > 0 ? config.rate_hz : kFastest_hz;
  const Time period = from_seconds(kRateSlack / rate_hz);
  while (const auto pictures = take_pictures(now, alerts)) {
    if (newest && pictures->left.time - *newest < period) continue;
    Frame frame;
    if (const std::string fault = decode_into(frame, *pictures); !fault.empty()) {
      lose(1, fault);
      continue;
    }
    Shot shot;
    shot.time = pictures->left.time;
    shot.missed_before = missed_before(shot.time);
    next_image += shot.missed_before;
    shot.image = next_image++;
    shot.name = numbered(shot.image);
    frame.image = shot.image;
    frame.time = shot.time;
    frame.name = shot.name;
    frame.rig = rig;
    steer_exposure(frame);
    shot.frame = std::make_shared<const Frame>(std::move(frame));
    if (keep_originals) shot.originals = originals_of(*pictures);
    newest = shot.time;
    tell_lost(shot.time, shot.image, shot.alerts);
    tell_skew(shot, shot.alerts);
    return shot;
  }
  return std::nullopt;
}

// Both cameras of a pair see the same ground and are set alike, by the left one.
void CameraSource::State::steer_exposure(const Frame& frame) {
  if (steered != links[0].opened() || !exposure) {
    steered = links[0].opened();
    const auto exposing = links[0].exposing();
    exposure.reset();
    exposure_ms = 0;
    if (!exposing) return;
    exposure.emplace(exposing->range, config.max_blur_px, exposing->now);
  }
  const double full_speed_px = speed_px * config.divisor();
  const double period_ms = static_cast<double>(links[0].period()) / kMillisecond;
  const bool changed =
      exposure->observe(cv::mean(frame.grey)[0], full_speed_px, period_ms).has_value();
  exposure_ms = exposure->exposure().ms;
  // Each opening leaves a camera as its driver has it.
  int opened = 0;
  for (const CameraLink& link : links) opened += link.opened();
  if (!changed && opened == exposed) return;
  exposed = opened;
  for (CameraLink& link : links) link.expose(exposure->exposure());
}

// What is wrong with a picture; empty when both are decoded.
std::string CameraSource::State::decode_into(Frame& frame, const PicturePair& pictures) const {
  using image_io::Colour;
  image_io::Decoded left = decode(pictures.left, full_rig.left, config.divisor(), Colour::bgr);
  if (!left.fault.empty()) return left.fault;
  frame.colour = std::move(left.image);
  cv::cvtColor(frame.colour, frame.grey, cv::COLOR_BGR2GRAY);
  if (!is_pair()) return {};
  image_io::Decoded right =
      decode(pictures.right, full_rig.right->camera, config.divisor(), Colour::grey);
  frame.right = std::move(right.image);
  return right.fault;
}

std::shared_ptr<const OriginalImages> CameraSource::State::originals_of(
    const PicturePair& pictures) const {
  OriginalImages originals{as_jpeg(pictures.left, full_rig.left), {}};
  if (is_pair()) originals.right = as_jpeg(pictures.right, full_rig.right->camera);
  return std::make_shared<const OriginalImages>(std::move(originals));
}

// Of a camera's images only some are wanted: a lost one was missed when the wanted rate shows a
// gap.
std::uint32_t CameraSource::State::missed_before(Time time) {
  const std::uint32_t between = std::exchange(lost, 0);
  if (!newest) return 0;
  if (config.rate_hz <= 0) return between;
  const double periods = seconds(time - *newest) * config.rate_hz;
  const auto wanted = static_cast<std::uint32_t>(std::clamp(std::round(periods), 1.0, 1e9));
  return std::min(between, wanted - 1);
}

void CameraSource::State::tell_lost(Time now, std::optional<std::uint64_t> image,
                                    std::vector<Alert>& alerts) {
  if (lost_untold == 0 || (told && now - *told < kTellLost)) return;
  told = now;
  alerts.push_back({now, image, AlertKind::images_dropped,
                    std::to_string(std::exchange(lost_untold, 0)) +
                        " images of the camera were lost or damaged: " + last_fault,
                    "check its cable and plug; a lower capture.rate_hz asks less of them"});
}

void CameraSource::State::tell_skew(const Shot& shot, std::vector<Alert>& alerts) {
  const auto skew = pairing.skew();
  if (!skew) return;
  last_skew = *skew;
  constexpr double kWorse = 1.5;  // than told before
  const double skew_ms = static_cast<double>(*skew) / kMillisecond;
  if (std::abs(skew_ms) <= std::max(config.max_skew_ms, kWorse * skew_told_ms)) return;
  skew_told_ms = std::abs(skew_ms);
  alerts.push_back({shot.time, shot.image, AlertKind::stereo_skew,
                    "the right camera's images are taken " + rounded(skew_ms) +
                        " ms after the left one's: in motion, scale and depth are wrong",
                    "trigger both cameras by one signal, or move slowly"});
}

std::vector<std::pair<std::string, std::string>> calibration_files(const Config& config) {
  const std::filesystem::path calibration = config.calibration;
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& [name, file] : {std::pair{"calib.yml", calibration},
                                   {"lasers.yml", calibration.parent_path() / "lasers.yml"}}) {
    constexpr std::uint64_t kMostBytes = 10u << 20;
    const FileBytes read = read_file(file, kMostBytes, Links::follow);
    if (read.fault.empty())
      files.emplace_back(name, std::string(read.bytes.begin(), read.bytes.end()));
  }
  return files;
}

}  // namespace nadir::capture

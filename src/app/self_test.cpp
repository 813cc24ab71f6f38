// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "self_test.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <thread>

#include "earlier_dives.hpp"
#include "nadir/capture/camera_source.hpp"
#include "nadir/core/check.hpp"
#include "nadir/odometry/visual_odometry.hpp"
#include "nadir/sensors/listener.hpp"

namespace nadir::app {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

std::string rounded(double value, int digits = 1) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

constexpr std::size_t kBlock = 1 << 20, kBlocks = 16;

// Megabytes a second of a file written through to the disk, and of its reading; 0 with errno.
double write_speed(const fs::path& file) {
  const int to = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (to < 0) return 0;
  std::vector<char> block(kBlock);
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = static_cast<char>(i * 2654435761u >> 7);
  const auto begin = Clock::now();
  bool good = true;
  for (std::size_t i = 0; good && i < kBlocks; ++i)
    good = ::write(to, block.data(), block.size()) == static_cast<ssize_t>(block.size());
  good = good && ::fdatasync(to) == 0;
  const int error = errno;
  ::close(to);
  errno = error;
  return good ? static_cast<double>(kBlock * kBlocks) / 1e6 / seconds_since(begin) : 0;
}

std::optional<long> number_in(const fs::path& file, int base = 10) {
  std::string text;
  if (!(std::ifstream(file) >> text)) return std::nullopt;
  char* end = nullptr;
  const long value = std::strtol(text.c_str(), &end, base);
  return end != text.c_str() ? std::optional(value) : std::nullopt;
}

std::vector<std::string> told_by(const sensors::Reading& reading) {
  std::vector<std::string> names;
  if (reading.roll && reading.pitch) names.emplace_back("roll and pitch");
  if (reading.heading || reading.magnetic_heading) names.emplace_back("heading");
  if (reading.depth || reading.pressure) names.emplace_back("depth");
  if (reading.altitude) names.emplace_back("altitude");
  if (reading.position) names.emplace_back("position");
  if (reading.utc) names.emplace_back("time of day");
  return names;
}

/// What a few images of the cameras showed.
struct Seen {
  std::vector<Shot> shots;
  std::vector<Alert> alerts;
};

Seen look(capture::CameraSource& cameras, std::chrono::seconds patience) {
  constexpr std::size_t kEnough = 20;
  Seen seen;
  std::stop_source never;
  for (const auto end = Clock::now() + patience; Clock::now() < end;) {
    auto captured = cameras.next(never.get_token());
    std::ranges::move(captured->alerts, std::back_inserter(seen.alerts));
    if (!captured->shot) continue;
    for (const Alert& alert : captured->shot->alerts) seen.alerts.push_back(alert);
    seen.shots.push_back(*std::move(captured->shot));
    if (seen.shots.size() == kEnough) break;
  }
  return seen;
}

Finding camera_finding(const Seen& seen, double wanted_hz) {
  if (seen.shots.size() < 2) {
    const bool told = !seen.alerts.empty();
    return {Verdict::bad, "camera", told ? seen.alerts.front().message : "gave no images",
            told ? seen.alerts.front().remedy : "check the camera and its cable"};
  }
  const double span = seconds(seen.shots.back().time - seen.shots.front().time);
  const double hz = static_cast<double>(seen.shots.size() - 1) / span;
  constexpr double kSlow = 0.7;
  const std::string found = rounded(hz) + " images a second";
  if (wanted_hz > 0 && hz < kSlow * wanted_hz) {
    return {Verdict::doubtful, "camera", found + " of " + rounded(wanted_hz) + " wanted",
            "more light, a fixed capture.exposure_ms or a faster format of the camera"};
  }
  return {Verdict::good, "camera", found};
}

// What odometry makes of them: it knows when an image is too dark or blurred, and when a pair is
// none.
void judge_images(const Config& config, const Seen& seen, std::vector<Finding>& findings) {
  odometry::VisualOdometry odometry(config.odometry,
                                    [](const Window&, const auto&) { return SubmapPlacement(); });
  std::map<std::string, Alert> suspicions;
  Health health;  // of the last: the camera's own exposure and focus settle within some images
  for (const Shot& shot : seen.shots) {
    const Orientation orientation = odometry.process(std::make_shared<const Shot>(shot));
    health = orientation.health;
    for (const Alert& alert : orientation.alerts) {
      const bool about_pair =
          alert.kind == AlertKind::calibration_suspect || alert.kind == AlertKind::stereo_skew;
      if (about_pair) suspicions.emplace(alert.message, alert);
    }
  }
  const bool dark = health.has(Weakness::dark), bright = health.has(Weakness::bright);
  findings.push_back({dark || bright ? Verdict::doubtful : Verdict::good, "exposure",
                      "mean grey level " + rounded(health.exposure, 0),
                      dark     ? "more light, or a longer capture.exposure_ms"
                      : bright ? "less light, or a shorter capture.exposure_ms"
                               : ""});
  const bool blurred = health.has(Weakness::blurred);
  findings.push_back({blurred ? Verdict::doubtful : Verdict::good, "focus",
                      "sharpness " + rounded(health.sharpness, 0),
                      blurred ? "clean the port, focus for the working distance under water, or "
                                "look at something with texture"
                              : ""});
  for (const auto& [message, alert] : suspicions)
    findings.push_back({Verdict::bad, "calibration", message, alert.remedy});
}

Finding skew_finding(const capture::CameraSource& cameras, double most_ms) {
  const auto skew = cameras.skew();
  if (!skew) {
    return {Verdict::doubtful, "stereo skew", "too few pairs to tell",
            "check that both cameras run at the same rate"};
  }
  const double skew_ms = 1e3 * seconds(*skew);
  const std::string found =
      "the right image " + rounded(skew_ms, 2) + " ms after the left one, by their stamps";
  if (std::abs(skew_ms) <= most_ms) return {Verdict::good, "stereo skew", found};
  return {Verdict::doubtful, "stereo skew", found, "trigger both cameras by one signal"};
}

}  // namespace

std::vector<Finding> check_disk(const fs::path& dives) {
  std::error_code error;
  fs::create_directories(dives, error);
  const fs::path file = dives / ".speed-test";
  const double speed = write_speed(file);
  const std::string reason = std::strerror(errno);
  fs::remove(file, error);
  if (speed == 0) {
    return {{Verdict::bad, "disk", dives.string() + " cannot be written: " + reason,
             "check the disk, its mount and record.dives"}};
  }
  std::vector<Finding> findings;
  constexpr double kSlow = 3;  // megabytes a second that projected images take at 5 Hz
  findings.push_back({speed < kSlow ? Verdict::doubtful : Verdict::good, "disk speed",
                      rounded(speed) + " MB a second, written through",
                      speed < kSlow ? "use a faster card; images may not all be saved" : ""});
  const fs::space_info space = fs::space(dives, error);
  constexpr double kLittle = 2, kGigabyte = 1e9;
  const double free = static_cast<double>(space.available) / kGigabyte;
  findings.push_back({free < kLittle ? Verdict::doubtful : Verdict::good, "disk space",
                      rounded(free) + " GB free",
                      free < kLittle ? "copy earlier dives away and delete them" : ""});
  return findings;
}

Finding check_clock() {
  if (clock_is_set()) return {Verdict::good, "clock", "set by another"};
  return {Verdict::doubtful, "clock", "not set by another: dives are named by their number only",
          "none needed; a network, a receiver or an autopilot tells the time"};
}

std::vector<Finding> check_heat(const fs::path& sys) {
  std::vector<Finding> findings;
  std::optional<double> hottest;
  std::error_code error;
  for (auto zone = fs::directory_iterator(sys / "class/thermal", error);
       zone != fs::directory_iterator(); zone.increment(error)) {
    const auto millidegrees = number_in(zone->path() / "temp");
    if (millidegrees)
      hottest = std::max(hottest.value_or(-273), 1e-3 * static_cast<double>(*millidegrees));
  }
  constexpr double kHot = 75;  // a Raspberry Pi slows down from 80
  if (!hottest) {
    findings.push_back({Verdict::absent, "temperature", "is not measured here"});
  } else {
    findings.push_back({*hottest >= kHot ? Verdict::doubtful : Verdict::good, "temperature",
                        rounded(*hottest, 0) + " degrees",
                        *hottest >= kHot ? "cool the housing; in water it will be cooler" : ""});
  }
  // Bits of the firmware: 0 voltage too low, 1 and 2 slowed down, 3 near the limit of temperature.
  const auto flags = number_in(sys / "devices/platform/soc/soc:firmware/get_throttled", 16);
  if (!flags) return findings;
  const bool voltage = (*flags & 1) != 0, slowed = (*flags & 0xE) != 0;
  findings.push_back({voltage || slowed ? Verdict::doubtful : Verdict::good, "throttling",
                      voltage  ? "the supply's voltage is too low"
                      : slowed ? "the processor is slowed down by heat"
                               : "none now",
                      voltage  ? "use a stronger supply or thicker cables"
                      : slowed ? "cool the housing"
                               : ""});
  return findings;
}

std::vector<Finding> check_sensors(const sensors::Config& config, std::chrono::seconds patience) {
  const std::vector<sensors::Input> inputs = sensors::parse_inputs(config.inputs);
  if (inputs.empty()) return {{Verdict::absent, "sensors", "none configured (sensors.inputs)"}};
  struct Heard {
    std::set<std::string> what;
    std::string fault;
  };
  std::vector<Heard> heard(inputs.size());
  const auto hear = [&](const sensors::Heard& one) {
    for (std::string& what : told_by(one.reading)) heard[one.input].what.insert(std::move(what));
  };
  const auto link = [&](const sensors::LinkChange& change) {
    heard[change.input].fault = change.fault;
  };
  std::stop_source stop;
  std::jthread patient([&, patience] {
    std::this_thread::sleep_for(patience);
    stop.request_stop();
  });
  sensors::Listener listener(inputs, {hear, link});
  listener.run(stop.get_token());
  const std::vector<sensors::LinkCounts> counts = listener.counts();
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Finding finding{Verdict::good, "sensor " + inputs[i].name(), "", ""};
    for (const std::string& what : heard[i].what)
      finding.found += (finding.found.empty() ? "tells " : ", ") + what;
    if (heard[i].what.empty()) {
      finding.verdict = Verdict::doubtful;
      finding.found = !heard[i].fault.empty() ? heard[i].fault : "is silent";
      finding.remedy = "check the sensor, its power, cable and sensors.inputs";
    } else if (!heard[i].fault.empty()) {
      finding.verdict = Verdict::doubtful;
      finding.found += "; " + heard[i].fault;
      finding.remedy = "check the sensor, its power and its cable";
    } else if (counts[i].damaged > counts[i].used / 10) {
      finding.verdict = Verdict::doubtful;
      finding.found += "; " + std::to_string(counts[i].damaged) + " messages came damaged";
      finding.remedy = "check the cable and the baud rate";
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

std::vector<Finding> check_cameras(const Config& config, std::chrono::seconds patience) {
  std::vector<Finding> findings;
  std::optional<capture::CameraSource> cameras;
  try {
    cameras.emplace(config.capture);
  } catch (const InputError& error) {
    return {{Verdict::bad, "calibration", error.what(), "see the README for its formats"}};
  }
  findings.push_back({Verdict::good, "calibration", config.capture.calibration + " is plausible"});
  const Seen seen = look(*cameras, patience);
  findings.push_back(camera_finding(seen, config.capture.rate_hz));
  if (seen.shots.size() < 2) return findings;
  for (const Alert& alert : seen.alerts) {
    if (alert.kind == AlertKind::camera_back || alert.kind == AlertKind::images_dropped)
      findings.push_back({Verdict::doubtful, "camera", alert.message, alert.remedy});
  }
  if (cameras->rig()->right) findings.push_back(skew_finding(*cameras, config.capture.max_skew_ms));
  judge_images(config, seen, findings);
  return findings;
}

Finding check_page(const serve::Config& config) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(config.port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  timeval patience{3, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::string answer(64, '\0');
  const std::string request = "GET / HTTP/1.1\r\nHost: localhost:" + std::to_string(config.port) +
                              "\r\nAccept-Encoding: gzip\r\n\r\n";
  ssize_t size = -1;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::send(socket, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
    size = ::recv(socket, answer.data(), answer.size(), MSG_WAITALL);
  }
  ::close(socket);
  answer.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  const std::string where = "port " + std::to_string(config.port);
  if (answer.starts_with("HTTP/1.1 200")) return {Verdict::good, "page", "is served at " + where};
  return {Verdict::doubtful, "page", "nothing serves it at " + where,
          "start the service: systemctl start nadir"};
}

}  // namespace nadir::app

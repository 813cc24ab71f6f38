// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "self_test.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <thread>

#include "image_check.hpp"
#include "nadir/capture/camera_source.hpp"
#include "nadir/core/check.hpp"
#include "nadir/odometry/visual_odometry.hpp"
#include "nadir/sensors/listener.hpp"

namespace nadir::app {

using Clock = std::chrono::steady_clock;

namespace {

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

/// What came over an input.
struct HeardOf {
  std::set<std::string> what;
  std::string fault;
};

Finding judge_sensor(const std::string& name, const HeardOf& heard,
                     const sensors::LinkCounts& counts) {
  const std::string item = "sensor " + name;
  std::string told;
  for (const std::string& what : heard.what) told += (told.empty() ? "tells " : ", ") + what;
  const auto doubt = [&](const std::string& found, const std::string& remedy) {
    return Finding{Verdict::doubtful, item, told.empty() ? found : told + "; " + found, remedy};
  };
  if (!heard.fault.empty())
    return doubt(heard.fault, "check the sensor, its power, cable and sensors.inputs");
  if (counts.damaged > counts.used / 10) {
    return doubt(std::to_string(counts.damaged) + " messages came damaged",
                 "check the cable and the baud rate");
  }
  if (!told.empty()) return {Verdict::good, item, told};
  if (counts.unused > 0)
    return doubt("speaks, but tells nothing of use", "see the README for what is of use");
  if (counts.bytes > 0) {
    return doubt("what comes is not understood",
                 "check the baud rate and the protocol in sensors.inputs");
  }
  return doubt("is silent", "check the sensor, its power, cable and sensors.inputs");
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
    const std::string remedy = told ? seen.alerts.front().remedy : "check the camera and its cable";
    return {Verdict::bad, "camera", told ? seen.alerts.front().message : "gave no images",
            remedy + "; while the service has it, the page says how it does, under System"};
  }
  const double span = seconds(seen.shots.back().time - seen.shots.front().time);
  const double hz = static_cast<double>(seen.shots.size() - 1) / span;
  return check_rate(hz, wanted_hz);
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
  std::ranges::move(check_picture(health), std::back_inserter(findings));
  const Frame& last = *seen.shots.back().frame;
  if (last.rig->right) findings.push_back(check_pair(odometry::pair_fit(last)));
  for (const auto& [message, alert] : suspicions)
    findings.push_back({Verdict::bad, "calibration", message, alert.remedy});
}

// Where this machine reaches its own page.
socklen_t own_address(const serve::Config& config, sockaddr_storage& storage) {
  auto& six = reinterpret_cast<sockaddr_in6&>(storage);
  if (::inet_pton(AF_INET6, config.address.c_str(), &six.sin6_addr) == 1) {
    six.sin6_family = AF_INET6;
    six.sin6_port = htons(config.port);
    if (IN6_IS_ADDR_UNSPECIFIED(&six.sin6_addr)) six.sin6_addr = in6addr_loopback;
    return sizeof six;
  }
  storage = {};
  auto& four = reinterpret_cast<sockaddr_in&>(storage);
  four.sin_family = AF_INET;
  four.sin_port = htons(config.port);
  if (::inet_pton(AF_INET, config.address.c_str(), &four.sin_addr) != 1 ||
      four.sin_addr.s_addr == htonl(INADDR_ANY)) {
    four.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  return sizeof four;
}

}  // namespace

std::vector<Finding> check_sensors(const sensors::Config& config, std::chrono::seconds patience) {
  const std::vector<sensors::Input> inputs = sensors::parse_inputs(config.inputs);
  if (inputs.empty()) return {{Verdict::absent, "sensors", "none configured (sensors.inputs)"}};
  std::vector<HeardOf> heard(inputs.size());
  const auto hear = [&](const sensors::Heard& one) {
    for (std::string& what : told_by(one.reading)) heard[one.input].what.insert(std::move(what));
  };
  const auto link = [&](const sensors::LinkChange& change) {
    const std::string name = inputs[change.input].name() + ": ";
    std::string& fault = heard[change.input].fault = change.fault;
    if (fault.starts_with(name)) fault.erase(0, name.size());
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
  for (std::size_t i = 0; i < inputs.size(); ++i)
    findings.push_back(judge_sensor(inputs[i].name(), heard[i], counts[i]));
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
  if (cameras->rig()->right)
    findings.push_back(check_skew(cameras->skew(), config.capture.max_skew_ms));
  judge_images(config, seen, findings);
  return findings;
}

std::vector<Finding> check_https(const serve::Config& config) {
  if (config.certificate.empty()) return {};
  const std::string fault = serve::certificate_fault(config);
  if (fault.empty()) return {{Verdict::good, "https", config.certificate + " can be used"}};
  return {{Verdict::doubtful, "https", fault, "until then the page is served without it"}};
}

Finding check_page(const serve::Config& config) {
  sockaddr_storage storage{};
  const socklen_t length = own_address(config, storage);
  const int socket = ::socket(storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  timeval patience{3, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::string answer(64, '\0');
  const std::string request = "GET / HTTP/1.1\r\nHost: localhost:" + std::to_string(config.port) +
                              "\r\nAccept-Encoding: gzip\r\n\r\n";
  ssize_t size = -1;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&storage), length) == 0 &&
      ::send(socket, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
    size = ::recv(socket, answer.data(), answer.size(), MSG_WAITALL);
  }
  ::close(socket);
  answer.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  const std::string where = "port " + std::to_string(config.port);
  if (answer.starts_with("HTTP/1.1 200")) return {Verdict::good, "page", "is served at " + where};
  return {Verdict::absent, "page",
          "nothing serves it at " + where + " now, as when the service is stopped"};
}

}  // namespace nadir::app

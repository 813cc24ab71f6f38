// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "live_check.hpp"

#include <pthread.h>

#include <algorithm>
#include <iterator>

#include "board_check.hpp"
#include "image_check.hpp"
#include "self_test.hpp"

namespace nadir::app {

using namespace std::chrono_literals;

namespace {

constexpr auto kPeriod = 5s;
constexpr auto kPairPeriod = 60s;  // it finds the corners of both images

double convergence_at(const std::string& origin) {
  const auto place = reference::parse_origin(origin);
  return place ? reference::UtmGrid(*place).convergence() : 0;
}

}  // namespace

LiveCheck::LiveCheck(const Config& config)
    : config_(config),
      convergence_(convergence_at(config.reference.origin)),
      image_rate_(config.capture.rate_hz),
      https_(check_https(config.serve)) {
  measure_disk();
}

LiveCheck::~LiveCheck() { stop_measuring(); }

void LiveCheck::measure_disk() {
  std::promise<Finding> speed;
  disk_speed_to_come_ = speed.get_future();
  measuring_ =
      std::jthread([this, speed = std::move(speed), enough = enough_.get_token()]() mutable {
        pthread_setname_np(pthread_self(), "disk check");
        speed.set_value(check_disk_speed(config_.record.dives, enough));
      });
}

bool LiveCheck::is_due(Clock::time_point now) {
  if (told_ && now - *told_ < kPeriod) return false;
  told_ = now;
  return true;
}

wire::Check LiveCheck::of_board(const Load& load) {
  if (disk_speed_to_come_.valid()) {
    if (disk_speed_to_come_.wait_for(0s) == std::future_status::ready)
      disk_ = disk_speed_to_come_.get();
  } else if (disk_ && disk_->verdict == Verdict::bad) {
    measure_disk();  // it may have come back
  }
  wire::Check check;
  if (disk_) check.findings.push_back(*disk_);
  std::ranges::move(check_board(load), std::back_inserter(check.findings));
  check.findings.push_back(check_clock());
  std::ranges::copy(https_, std::back_inserter(check.findings));
  return check;
}

const Finding& LiveCheck::pair_of(const Frame& frame, Clock::time_point now) {
  if (!pair_ || now - *pair_checked_ >= kPairPeriod) {
    pair_ = check_pair(odometry::pair_fit(frame));
    pair_checked_ = now;
  }
  return *pair_;
}

std::optional<wire::Check> LiveCheck::waiting(Clock::time_point now, const Load& load,
                                              const Finding& missing) {
  if (!is_due(now)) return std::nullopt;
  wire::Check check = of_board(load);
  check.findings.push_back(missing);
  return check;
}

std::optional<wire::Check> LiveCheck::mapping(Clock::time_point now, const Load& load,
                                              const Graph& graph, std::optional<Time> skew) {
  image_rate_.observe(now, graph.shots());
  if (!is_due(now)) return std::nullopt;
  wire::Check check = of_board(load);
  std::vector<Finding>& findings = check.findings;
  if (const auto silence = image_rate_.silence()) {
    findings.push_back(check_silence(*silence));
    return check;  // the newest picture says nothing of now
  }
  if (const auto hz = image_rate_.hz())
    findings.push_back(check_rate(*hz, config_.capture.rate_hz));
  const auto newest = graph.newest();
  if (!newest || !newest->shot || !newest->shot->frame) return check;
  const Frame& frame = *newest->shot->frame;
  std::ranges::move(check_picture(newest->health), std::back_inserter(findings));
  if (frame.rig->right) {
    findings.push_back(check_skew(skew, config_.capture.max_skew_ms));
    findings.push_back(pair_of(frame, now));
  }
  findings.push_back(check_vehicle(frame, config_.sensors.inputs, convergence_));
  return check;
}

}  // namespace nadir::app

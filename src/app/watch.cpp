// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "watch.hpp"

namespace nadir::app {
namespace {

constexpr std::chrono::seconds kBlocked{4}, kBlockedByDevice{6}, kLongest{60};
constexpr double kIdle = 0.02;  // of the processor, as a thread that is woken in vain

// A slow card and a camera's driver may take 5 s; what waits for the recorder does so for less.
std::chrono::seconds patience(const std::string& stage) {
  return stage == "record" || stage == "capture" ? kBlockedByDevice : kBlocked;
}

}  // namespace

std::optional<std::string> Watch::hung(Clock::time_point now,
                                       const std::vector<pipeline::StageActivity>& activities) {
  std::optional<std::string> found;
  for (const pipeline::StageActivity& activity : activities) {
    std::deque<Sample>& samples = samples_[activity.stage];
    if (!activity.busy) {
      samples.clear();
      continue;
    }
    // Those of an earlier item say nothing of this one.
    const Clock::time_point begun = now - *activity.busy;
    while (!samples.empty() && samples.front().time < begun) samples.pop_front();
    samples.push_back({now, activity.cpu_s});
    const auto most = patience(activity.stage);
    while (samples.size() > 2 && now - samples[1].time >= most) samples.pop_front();
    const Sample& first = samples.front();
    const double span = std::chrono::duration<double>(now - first.time).count();
    const bool blocked = now - first.time >= most && activity.cpu_s - first.cpu_s < kIdle * span;
    if (blocked || *activity.busy >= kLongest) found = activity.stage;
  }
  return found;
}

}  // namespace nadir::app

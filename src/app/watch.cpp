// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "watch.hpp"

namespace nadir::app {
namespace {

constexpr std::chrono::seconds kBlocked{4}, kBlockedByDevice{6}, kLongest{60};
constexpr double kIdle = 0.02;  // of the processor, as a thread that is woken in vain

// One call of a slow card or of a camera's driver may take 5 s.
std::chrono::seconds patience(const std::string& stage) {
  return stage == "record" || stage == "capture" ? kBlockedByDevice : kBlocked;
}

}  // namespace

// An item in hand, and no work on it.
bool Watch::is_blocked(Clock::time_point now, const pipeline::StageActivity& activity) {
  std::deque<Sample>& samples = samples_[activity.stage];
  if (!activity.busy || activity.wants_to_run) {
    samples.clear();
    return false;
  }
  // Those of an earlier item say nothing of this one.
  const Clock::time_point begun = now - *activity.busy;
  while (!samples.empty() && samples.front().time < begun) samples.pop_front();
  samples.push_back({now, activity.cpu_s});
  const auto most = patience(activity.stage);
  while (samples.size() > 2 && now - samples[1].time >= most) samples.pop_front();
  const Sample& first = samples.front();
  const double span = std::chrono::duration<double>(now - first.time).count();
  return now - first.time >= most && activity.cpu_s - first.cpu_s < kIdle * span;
}

// Items wait, and it takes none.
bool Watch::sleeps(Clock::time_point now, const pipeline::StageActivity& activity) {
  Neglect& neglect =
      neglects_.try_emplace(activity.stage, Neglect{now, activity.processed}).first->second;
  if (!activity.neglects_input || activity.wants_to_run || activity.processed != neglect.processed)
    neglect = {now, activity.processed};
  return now - neglect.since >= kBlocked;
}

std::optional<std::string> Watch::hung(Clock::time_point now,
                                       const std::vector<pipeline::StageActivity>& activities) {
  std::optional<std::string> found;
  for (const pipeline::StageActivity& activity : activities) {
    const bool blocked = is_blocked(now, activity), asleep = sleeps(now, activity);
    const bool endless = activity.busy && *activity.busy >= kLongest;
    if (blocked || asleep || endless) found = activity.stage;
  }
  return found;
}

}  // namespace nadir::app

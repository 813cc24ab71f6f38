// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "progress.hpp"

#include <unistd.h>

#include <string>

namespace nadir::app {
namespace {

constexpr auto kTerminalPeriod = std::chrono::milliseconds(100);
constexpr auto kPlainPeriod = std::chrono::seconds(5);

}  // namespace

void print(const Alert& alert, std::FILE* out) {
  std::fprintf(out, "%s: %s; %s\n", std::string(to_string(alert.kind)).c_str(),
               alert.message.c_str(), alert.remedy.c_str());
}

Progress::Progress(std::size_t total, std::FILE* out)
    : total_(total), out_(out), terminal_(isatty(fileno(out)) == 1) {}

void Progress::add(const record::Entry& entry) {
  const Orientation& orientation = *entry.orientation;
  if (orientation.shot) {
    captured_ = orientation.shot->image + 1;
    for (const Alert& alert : orientation.shot->alerts) add(alert);
  }
  state_ = orientation.state;
  for (const ImagePose& pose : orientation.poses) oriented_ += seen_.insert(pose.image).second;
  lost_ += orientation.lost.size();
  for (const Alert& alert : orientation.alerts) add(alert);
  if (entry.surface) {
    planes_ += entry.surface->plane.has_value();
    for (const Alert& alert : entry.surface->alerts) add(alert);
  }
  if (entry.mosaic) {
    for (const Alert& alert : entry.mosaic->alerts) add(alert);
  }
  if (entry.cloud) {
    for (const Alert& alert : entry.cloud->alerts) add(alert);
  }
  for (const auto& revision : entry.revisions) {
    for (const Alert& alert : revision->alerts) add(alert);
  }
  show(false);
}

void Progress::add(const Alert& alert) {
  clear_line();
  print(alert, out_);
}

void Progress::finish() {
  show(true);
  if (terminal_) std::fputc('\n', out_);
  std::fflush(out_);
}

void Progress::show(bool now) {
  const Clock::time_point time = Clock::now();
  if (!now && time - shown_ <
                  (terminal_ ? Clock::duration(kTerminalPeriod) : Clock::duration(kPlainPeriod)))
    return;
  shown_ = time;
  const double elapsed = std::chrono::duration<double>(time - begun_).count();
  std::fprintf(out_,
               "%s%llu%s images, %.1f per second, %s: %llu oriented, %llu lost, %llu planes%s",
               terminal_ ? "\r\033[K" : "", static_cast<unsigned long long>(captured_),
               total_ > 0 ? (" of " + std::to_string(total_)).c_str() : "",
               elapsed > 0 ? static_cast<double>(captured_) / elapsed : 0.0,
               std::string(to_string(state_)).c_str(), static_cast<unsigned long long>(oriented_),
               static_cast<unsigned long long>(lost_), static_cast<unsigned long long>(planes_),
               terminal_ ? "" : "\n");
  std::fflush(out_);
}

void Progress::clear_line() {
  if (terminal_) std::fputs("\r\033[K", out_);
}

}  // namespace nadir::app

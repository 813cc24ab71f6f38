// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "live_dive.hpp"

#include <utility>

#include "nadir/record/dive.hpp"

namespace nadir::app {

void LiveDive::tell(Tell tell) {
  const std::scoped_lock lock(mutex_);
  tell_ = std::move(tell);
  tell_now();
}

// The mutex is held, so that what is told keeps its order.
void LiveDive::tell_now() {
  if (tell_) tell_(recording_);
}

void LiveDive::prepare() {
  const std::scoped_lock lock(mutex_);
  recording_.phase = wire::Phase::waiting;
  recording_.saved = 0;
  recording_.began = 0;
  recording_.name.clear();
  tell_now();
}

void LiveDive::begin(const std::filesystem::path& folder) {
  const std::scoped_lock lock(mutex_);
  folder_ = std::filesystem::absolute(folder).lexically_normal();
  if (!folder_.has_filename()) folder_ = folder_.parent_path();  // "dives/today/"
  recording_.phase = wire::Phase::recording;
  recording_.saved = 0;
  recording_.began = 0;
  recording_.name = folder_.filename().string();
  is_recording_ = true;
  newest_ = 0;
  marks_.clear();
  tell_now();
}

void LiveDive::note(std::uint64_t saved, bool paused, Time newest) {
  const std::scoped_lock lock(mutex_);
  if (!is_recording_) return;
  recording_.saved = saved;
  recording_.phase = paused ? wire::Phase::paused : wire::Phase::recording;
  if (newest_ == 0) recording_.began = newest;
  newest_ = newest;
  tell_now();
}

void LiveDive::close() {
  const std::scoped_lock lock(mutex_);
  if (!is_recording_) return;
  recording_.phase = wire::Phase::ended;
  tell_now();
}

void LiveDive::end() {
  close();
  const std::scoped_lock lock(mutex_);
  is_recording_ = false;
}

void LiveDive::set_controllable(bool controllable) {
  const std::scoped_lock lock(mutex_);
  if (std::exchange(recording_.controllable, controllable) != controllable) tell_now();
}

void LiveDive::set_controller(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  if (std::exchange(recording_.controller, name) != name) tell_now();
}

LiveDive::Now LiveDive::now() const {
  const std::scoped_lock lock(mutex_);
  return {is_recording_, folder_, recording_.saved};
}

void LiveDive::record_marks(Record record) {
  const std::scoped_lock lock(mutex_);
  record_ = std::move(record);
}

std::optional<std::uint64_t> LiveDive::add(Mark mark) {
  const std::scoped_lock lock(mutex_);
  if (!record_) return std::nullopt;
  mark.id = next_mark_;
  mark.time = newest_;
  if (!record_(mark)) return std::nullopt;
  marks_[mark.id] = mark;
  return next_mark_++;
}

bool LiveDive::remove(std::uint64_t mark) {
  const std::scoped_lock lock(mutex_);
  const auto found = marks_.find(mark);
  if (!record_ || found == marks_.end()) return false;
  Mark removed = found->second;
  removed.removed = true;
  if (!record_(removed)) return false;
  marks_.erase(found);
  return true;
}

std::optional<std::filesystem::path> LiveDive::photograph(std::uint64_t mark) const {
  const std::scoped_lock lock(mutex_);
  const auto found = marks_.find(mark);
  if (found == marks_.end() || !found->second.image) return std::nullopt;
  return record::projected_name(folder_, *found->second.image);
}

}  // namespace nadir::app

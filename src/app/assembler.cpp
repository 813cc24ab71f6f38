// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "assembler.hpp"

namespace nadir::app {
namespace {

// The end of the input, where odometry settles what it still waited for, comes after every shot.
constexpr std::uint64_t kEnd = std::numeric_limits<std::uint64_t>::max();

std::uint64_t place(const Orientation& orientation) {
  return orientation.shot ? orientation.shot->image : kEnd;
}
std::uint64_t place(const Surface& surface) { return place(*surface.orientation); }
std::uint64_t place(const Cloud& cloud) { return place(*cloud.surface); }
std::uint64_t place(const MosaicUpdate& mosaic) { return place(*mosaic.surface); }

std::uint64_t place(const Revision& revision) { return revision.image.value_or(kEnd); }

template <class T>
std::shared_ptr<const T> taken(std::deque<std::shared_ptr<const T>>& stream, std::uint64_t wanted) {
  if (stream.empty() || place(*stream.front()) != wanted) return nullptr;
  std::shared_ptr<const T> part = std::move(stream.front());
  stream.pop_front();
  return part;
}

}  // namespace

void Assembler::finish() {
  ended_ = true;
  emit_whole();
}

void Assembler::emit_whole() {
  while (!orientations_.empty() && is_decided(surfaces_) && is_decided(clouds_) &&
         is_decided(mosaics_)) {
    const std::uint64_t wanted = place(*orientations_.front());
    if (waits_for_revision(wanted)) return;
    record::Entry entry;
    entry.orientation = taken(orientations_, wanted);
    entry.surface = taken(surfaces_, wanted);
    entry.cloud = taken(clouds_, wanted);
    entry.mosaic = taken(mosaics_, wanted);
    entry.revisions = taken_revisions(wanted);
    whole_(entry);
  }
}

// The last entry takes every revision that is still to come.
bool Assembler::waits_for_revision(std::uint64_t wanted) const {
  if (ended_) return false;
  if (in_step_) return revisions_.empty();
  return wanted == kEnd && (revisions_.empty() || place(*revisions_.back()) != kEnd);
}

// Those without content need no mention.
std::vector<std::shared_ptr<const Revision>> Assembler::taken_revisions(std::uint64_t wanted) {
  std::vector<std::shared_ptr<const Revision>> taken;
  while (!revisions_.empty() && place(*revisions_.front()) <= wanted) {
    const auto& revision = *revisions_.front();
    if (!revision.corrections.empty() || !revision.joins.empty() || !revision.scales.empty() ||
        !revision.alerts.empty()) {
      taken.push_back(std::move(revisions_.front()));
    }
    revisions_.pop_front();
  }
  return taken;
}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "assembler.hpp"

namespace nadir::app {
namespace {

// The end of the input, where odometry settles what it still waited for, comes after every shot.
std::uint64_t place(const Orientation& orientation) {
  return orientation.shot ? orientation.shot->image : std::numeric_limits<std::uint64_t>::max();
}
std::uint64_t place(const Surface& surface) { return place(*surface.orientation); }
std::uint64_t place(const Cloud& cloud) { return place(*cloud.surface); }
std::uint64_t place(const MosaicUpdate& mosaic) { return place(*mosaic.surface); }

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
    record::Entry entry;
    entry.orientation = taken(orientations_, wanted);
    entry.surface = taken(surfaces_, wanted);
    entry.cloud = taken(clouds_, wanted);
    entry.mosaic = taken(mosaics_, wanted);
    whole_(entry);
  }
}

}  // namespace nadir::app

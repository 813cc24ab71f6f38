// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Brings together again what the stages made of one shot, in the shots' order, whatever the
// threads' timing: so that the journal of a replay has the same bytes twice.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>

#include "nadir/record/dive.hpp"

namespace nadir::app {

/// An entry is whole when each of its parts has come, or a part of a later shot has come in its
/// place (the part was dropped on a live edge), or the stream has ended.
class Assembler {
 public:
  /// What recording does about revisions, which may take long to find.
  enum class Revisions {
    in_step,  ///< each goes with its own shot, which waits for it
    as_come,  ///< none is waited for: an entry takes what has come by then
  };

  Assembler(Revisions revisions, std::function<void(const record::Entry&)> whole)
      : in_step_(revisions == Revisions::in_step), whole_(std::move(whole)) {}

  void add(std::shared_ptr<const Orientation> orientation) {
    take(orientations_, std::move(orientation));
  }
  void add(std::shared_ptr<const Surface> surface) { take(surfaces_, std::move(surface)); }
  void add(std::shared_ptr<const Cloud> cloud) { take(clouds_, std::move(cloud)); }
  void add(std::shared_ptr<const MosaicUpdate> mosaic) { take(mosaics_, std::move(mosaic)); }
  void add(std::shared_ptr<const Revision> revision) { take(revisions_, std::move(revision)); }
  /// Nothing more will come.
  void finish();

 private:
  template <class T>
  using Stream = std::deque<std::shared_ptr<const T>>;

  template <class T>
  void take(Stream<T>& stream, std::shared_ptr<const T> part) {
    stream.push_back(std::move(part));
    emit_whole();
  }
  void emit_whole();
  template <class T>
  bool is_decided(const Stream<T>& stream) const {
    return ended_ || !stream.empty();
  }

  bool waits_for_revision(std::uint64_t wanted) const;
  std::vector<std::shared_ptr<const Revision>> taken_revisions(std::uint64_t wanted);

  bool in_step_;
  std::function<void(const record::Entry&)> whole_;
  Stream<Orientation> orientations_;
  Stream<Surface> surfaces_;
  Stream<Cloud> clouds_;
  Stream<MosaicUpdate> mosaics_;
  Stream<Revision> revisions_;
  bool ended_ = false;
};

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the viewers of one thing, the dive under way or one recorded, are sent and have still to be
// sent. The protocol is in nadir/wire/README.md.
#pragma once

#include <cstdint>
#include <memory>

#include "nadir/wire/envelope.hpp"

namespace nadir::serve {

/// How a record travels. In each lane a record takes the place of an older one of its key, also in
/// what a slow or late viewer has still to be sent.
enum class Lane {
  state,      ///< alerts, state, counts: in order, before all else, let go of last
  prompt,     ///< poses, planar clouds, overviews: newest first, at least half of the link
  data,       ///< tie points, tiles: newest first, shares with live; let go of first
  live,       ///< the current image: not part of what a viewer must have to be complete
  thin_live,  ///< the same, smaller, in its place for viewers whose link does not carry it
};

/// Made by a WebServer, which it may outlive. With its last holder its viewers are sent away.
class Feed {
 public:
  class Core;
  explicit Feed(std::shared_ptr<Core> core);
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;
  ~Feed();

  /// Gives the record its sequence and sends it to every viewer, now and later. Does not wait for
  /// any of them. Any thread; those of one thread in their order. Nothing once the server ended.
  void publish(Lane lane, std::uint64_t key, wire::Bytes record);

  /// Connected now. Any thread.
  std::uint64_t viewers() const;

 private:
  friend class WebServer;
  const std::shared_ptr<Core> core_;
};

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One page's WebSocket, from the handshake to the farewell.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "feed_core.hpp"
#include "stream.hpp"

namespace nadir::serve {

class Viewer {
 public:
  /// only: as Backlog has it.
  Viewer(Stream stream, std::shared_ptr<Feed::Core> feed, std::optional<std::uint8_t> only);

  /// The whole conversation; this lives until its end.
  asio::awaitable<void> converse(const HttpRequest& request);
  /// There are new records.
  void wake();
  /// The server ends.
  void dismiss();
  /// The feed ends; another may have its place.
  void send_away();

 private:
  class Conversation;
  std::shared_ptr<Conversation> conversation_;
};

}  // namespace nadir::serve

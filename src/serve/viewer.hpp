// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One page's WebSocket, from the handshake to the farewell.
#pragma once

#include <memory>

#include "feed.hpp"
#include "stream.hpp"

namespace nadir::serve {

class Viewer {
 public:
  /// The feed outlives it.
  Viewer(Stream stream, Feed& feed);

  /// The whole conversation; this lives until its end.
  asio::awaitable<void> converse(const HttpRequest& request);
  /// There are new records.
  void wake();
  /// The server ends.
  void dismiss();

 private:
  class Conversation;
  std::shared_ptr<Conversation> conversation_;
};

}  // namespace nadir::serve

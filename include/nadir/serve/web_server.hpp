// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The HTTP and WebSocket server: hands out the page, streams records to its viewers, in a thread of
// its own, and has calls answered, in another. A viewer says hello and nothing else. RFC 9110, RFC
// 6455; the protocol is in nadir/wire/README.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nadir/serve/call.hpp"
#include "nadir/serve/feed.hpp"
#include "nadir/wire/envelope.hpp"

namespace nadir::serve {

/// Where the page opens its WebSocket, and, with ?type=N, one more for the records of a single type
/// of Lane::state: they wait for no lost packet of the others.
constexpr std::string_view kFeedPath = "/feed", kRecordsPath = "/records";

struct Config {
  std::string address = "127.0.0.1";  ///< IP literal; "::" or "0.0.0.0" for every network
  std::uint16_t port = 8765;          ///< 0: the system's choice
  /// Host names this device goes by beside localhost; by default what mDNS (avahi) makes of a
  /// computer called nadir.
  std::vector<std::string> names{"nadir.local"};
  /// PEM files, both or neither: with them who begins with TLS is answered with TLS, on the same
  /// port.
  std::string certificate;                 ///< may be followed by its chain
  std::string key;                         ///< without a passphrase
  std::size_t max_clients = 32;            ///< viewers at a time
  std::size_t client_bytes = 32 << 10;     ///< kernel send buffer of a viewer: what may be stale
  std::size_t retained_bytes = 64u << 20;  ///< of records kept for late viewers; oldest data go
  double header_timeout = 5;               ///< s, for a header (with TLS's handshake) and for the
                                           ///< hello; a body: twice
  double idle_timeout = 10;                ///< s without an answer to a ping
  double stall_timeout = 30;               ///< s in which nothing was taken of what is sent

  /// Throws InputError.
  void check() const;
};

/// Why the configured certificate cannot be used, with the remedy; empty when it can, or when there
/// is none.
std::string certificate_fault(const Config& config);

/// A file of the page, compiled into the binary.
struct Asset {
  std::string path;  ///< as requested: "/index.html", which is also "/"
  std::string content_type;
  std::span<const std::uint8_t> gzip;  ///< outlives the server
};

/// The feed that a query names ("dive=ID" of /feed?dive=ID), kept by who finds it; null: there is
/// none. Called as Handler is.
using FindFeed = std::function<std::shared_ptr<Feed>(const std::string& query)>;

/// What the program does for pages. Without the first there are no calls, without the second only
/// the current feed.
struct Handlers {
  Handler call{};
  FindFeed feed{};
};

enum class Listen {
  at_once,  ///< or not at all
  in_time,  ///< when another program holds the port, as soon as it is free
};

class WebServer {
 public:
  /// Throws InputError when it cannot listen, with the address and the remedy, and with
  /// certificate_fault().
  /// listening: a TCP socket that does already, of systemd; instead of address and port. Owned from
  /// then on.
  WebServer(Config config, std::vector<Asset> assets, std::optional<int> listening = {},
            Listen listen = Listen::at_once, Handlers handlers = {});
  ~WebServer();

  /// 0 while it does not listen yet.
  std::uint16_t port() const;
  /// Why it did not at once; empty when it did.
  const std::string& listen_fault() const;

  /// What viewers of kFeedPath and kRecordsPath are sent; there is one from the beginning. Any
  /// thread.
  std::shared_ptr<Feed> feed() const;
  /// An empty one in its place. The one before ends: its viewers come over by themselves, and what
  /// is still published to it goes nowhere.
  std::shared_ptr<Feed> begin_feed();
  /// One for FindFeed to find.
  std::shared_ptr<Feed> make_feed(std::size_t retained_bytes) const;

  struct Stats {
    std::uint64_t clients = 0;         ///< viewers connected
    std::uint64_t retained_bytes = 0;  ///< of all records held
    std::uint64_t evicted = 0;         ///< records let go to stay within Config::retained_bytes
    std::uint64_t sent = 0;            ///< records, summed over viewers
    std::uint64_t refused = 0;         ///< requests and viewers turned away
    std::uint64_t timed_out = 0;       ///< viewers closed because they stalled or fell silent
  };
  /// Any thread.
  Stats stats() const;

  /// Says goodbye to the viewers and ends, within a second and what the call at work still takes.
  void stop();

 private:
  class Reactor;
  std::shared_ptr<Reactor> reactor_;
};

}  // namespace nadir::serve

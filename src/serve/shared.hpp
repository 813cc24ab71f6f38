// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What all connections share.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace nadir::serve {

/// One thread changes it, any reads it.
using Count = std::atomic<std::uint64_t>;

/// One more while it lives.
struct Counted {
  explicit Counted(Count& c) : count(c) { ++count; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted() { --count; }
  Count& count;
};

/// What the server counts, over all its feeds; lines: those of kRecordsPath.
struct Tally {
  Count connections = 0, clients = 0, lines = 0, sent = 0, refused = 0, timed_out = 0;
  Count retained_bytes = 0, evicted = 0;
};

struct Timeouts {
  std::chrono::steady_clock::duration header, idle, stall;
};

struct Shared {
  Timeouts timeouts;
  int client_bytes;
  Tally tally;
};

}  // namespace nadir::serve

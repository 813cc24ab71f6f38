// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What every record of the browser protocol starts with, and how a viewer says hello. See README.md
// beside this file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace nadir::wire {

using Bytes = std::vector<std::uint8_t>;

/// Raised when a record changes its meaning; a viewer of another version is refused by name.
constexpr std::uint8_t kVersion = 2;

/// One WebSocket message is one record. Little-endian:
/// u8 type, u8 version, u16 zero, u32 zero, u64 sequence, then the body.
constexpr std::size_t kHeaderSize = 16;

/// A record begun: header of the type with sequence 0; the server sets the sequence when it
/// publishes.
Bytes begin_record(std::uint8_t type);
void set_sequence(Bytes& record, std::uint64_t sequence);
std::uint64_t sequence(std::span<const std::uint8_t> record);

/// The only message a viewer must send, first: type 1 from the viewer; body u64 feed, u64
/// last_sequence. feed names the run of the server (0: none known); records after last_sequence of
/// that feed are sent.
struct Hello {
  std::uint64_t feed = 0;
  std::uint64_t last_sequence = 0;
};
constexpr std::uint8_t kHelloType = 1;
Bytes encode(const Hello& hello);
/// None when it is not a hello of this version.
std::optional<Hello> decode_hello(std::span<const std::uint8_t> message);

/// The server's answer to a hello, its first record: type 2; body u64 feed, u64 newest_sequence.
/// When the feed is not the one of the hello the viewer forgets what it has.
struct Welcome {
  std::uint64_t feed = 0;
  std::uint64_t newest_sequence = 0;
};
constexpr std::uint8_t kWelcomeType = 2;
Bytes encode(const Welcome& welcome);
std::optional<Welcome> decode_welcome(std::span<const std::uint8_t> record);

/// Data arrive newest first, so the greatest sequence seen says nothing about what is missing. This
/// does, each time a viewer has been sent all there is: type 14; body u64 sequence, u64 evicted.
/// The viewer gives the sequence of the last one as its next hello's last_sequence (0 before the
/// first). evicted: data records the server held once and let go to stay within its memory.
struct CaughtUp {
  std::uint64_t sequence = 0;
  std::uint64_t evicted = 0;
};
constexpr std::uint8_t kCaughtUpType = 14;
Bytes encode(const CaughtUp& caught_up);
std::optional<CaughtUp> decode_caught_up(std::span<const std::uint8_t> record);

}  // namespace nadir::wire

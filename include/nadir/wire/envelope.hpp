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
constexpr std::uint8_t kVersion = 1;

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

}  // namespace nadir::wire

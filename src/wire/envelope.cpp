// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/wire/envelope.hpp"

#include "little_endian.hpp"

namespace nadir::wire {
namespace {

constexpr std::size_t kSequenceOffset = 8;

/// Hello, Welcome and CaughtUp are a header and two numbers.
Bytes encode_pair(std::uint8_t type, std::uint64_t first, std::uint64_t second) {
  Bytes record = begin_record(type);
  append_little_endian(first, record);
  append_little_endian(second, record);
  return record;
}

template <class Message>
std::optional<Message> decode_pair(std::uint8_t type, std::span<const std::uint8_t> record) {
  if (record.size() != kHeaderSize + 16 || record[0] != type || record[1] != kVersion) {
    return std::nullopt;
  }
  return Message{load_little_endian<std::uint64_t>(record.data() + kHeaderSize),
                 load_little_endian<std::uint64_t>(record.data() + kHeaderSize + 8)};
}

}  // namespace

Bytes begin_record(std::uint8_t type) {
  Bytes record(kHeaderSize, 0);
  record[0] = type;
  record[1] = kVersion;
  return record;
}

void set_sequence(Bytes& record, std::uint64_t sequence) {
  store_little_endian(sequence, record.data() + kSequenceOffset);
}

std::uint64_t sequence(std::span<const std::uint8_t> record) {
  return load_little_endian<std::uint64_t>(record.data() + kSequenceOffset);
}

Bytes encode(const Hello& hello) {
  return encode_pair(kHelloType, hello.feed, hello.last_sequence);
}

std::optional<Hello> decode_hello(std::span<const std::uint8_t> message) {
  return decode_pair<Hello>(kHelloType, message);
}

Bytes encode(const Welcome& welcome) {
  return encode_pair(kWelcomeType, welcome.feed, welcome.newest_sequence);
}

std::optional<Welcome> decode_welcome(std::span<const std::uint8_t> record) {
  return decode_pair<Welcome>(kWelcomeType, record);
}

Bytes encode(const CaughtUp& caught_up) {
  return encode_pair(kCaughtUpType, caught_up.sequence, caught_up.evicted);
}

std::optional<CaughtUp> decode_caught_up(std::span<const std::uint8_t> record) {
  return decode_pair<CaughtUp>(kCaughtUpType, record);
}

}  // namespace nadir::wire

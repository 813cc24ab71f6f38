// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/wire/envelope.hpp"

#include "little_endian.hpp"

namespace nadir::wire {
namespace {

constexpr std::size_t kSequenceOffset = 8;
constexpr std::size_t kHelloSize = kHeaderSize + 16;

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
  Bytes message = begin_record(kHelloType);
  append_little_endian(hello.feed, message);
  append_little_endian(hello.last_sequence, message);
  return message;
}

std::optional<Hello> decode_hello(std::span<const std::uint8_t> message) {
  if (message.size() != kHelloSize || message[0] != kHelloType || message[1] != kVersion) {
    return std::nullopt;
  }
  return Hello{load_little_endian<std::uint64_t>(message.data() + kHeaderSize),
               load_little_endian<std::uint64_t>(message.data() + kHeaderSize + 8)};
}

}  // namespace nadir::wire

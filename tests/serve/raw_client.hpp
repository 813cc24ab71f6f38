// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A client that says exactly what a test wants, right or wrong, on a plain socket (RFC 6455, 5.2).
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "nadir/wire/envelope.hpp"

namespace nadir::serve {

struct Message {
  unsigned opcode = 0;
  wire::Bytes bytes;
  std::uint8_t type() const { return bytes.empty() ? std::uint8_t{0} : bytes[0]; }
  unsigned close_code() const { return bytes.size() < 2 ? 0u : bytes[0] * 256u + bytes[1]; }
  std::string close_reason() const {
    return bytes.size() < 2 ? "" : std::string(bytes.begin() + 2, bytes.end());
  }
};

/// What follows a record's header, 0 when nothing does.
inline std::uint32_t content(const Message& message) {
  std::uint32_t value = 0;
  if (message.bytes.size() >= wire::kHeaderSize + sizeof value) {
    std::memcpy(&value, message.bytes.data() + wire::kHeaderSize, sizeof value);
  }
  return value;
}

class RawClient {
 public:
  static constexpr unsigned kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;
  static constexpr int kPatience = 5000;  // ms

  explicit RawClient(std::uint16_t port, int receive_buffer = 0, in_addr_t from = INADDR_ANY)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), port_(port) {
    if (receive_buffer > 0) {
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    }
    const int now = 1;  // else a test of small pieces waits for the kernel to join them
    ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &now, sizeof now);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(from);
    if (from != INADDR_ANY &&
        ::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      return;
    }
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  RawClient(RawClient&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)),
        port_(other.port_),
        connected_(other.connected_),
        input_(std::move(other.input_)) {}
  RawClient& operator=(RawClient&&) = delete;
  virtual ~RawClient() {
    if (socket_ >= 0) ::close(socket_);
  }

  bool connected() const { return connected_; }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  virtual std::string origin() const { return "http://" + host(); }

  /// False when the server no longer takes it.
  bool send(std::string_view text) {
    while (!text.empty()) {
      const ssize_t sent = write(text);
      if (sent <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  /// Bytes that have come and were not read.
  std::size_t unread() const {
    int size = 0;
    return ::ioctl(socket_, FIONREAD, &size) == 0 ? static_cast<std::size_t>(size) : 0;
  }

  /// All the server says until it closes.
  std::string rest() {
    while (receive()) {
    }
    return std::exchange(input_, {});
  }
  bool closed() {
    rest();
    return ended_;
  }

  std::string get(std::string_view target, std::string_view extra = "") {
    send("GET " + std::string(target) + " HTTP/1.1\r\nHost: " + host() + "\r\n" +
         std::string(extra) + "\r\n");
    return rest();
  }

  std::string upgrade_request(const std::string& target = "/feed") const {
    return "GET " + target + " HTTP/1.1\r\nHost: " + host() + "\r\nOrigin: " + origin() +
           "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
  }

  /// The answer's header.
  std::string header() {
    std::size_t end;
    while ((end = input_.find("\r\n\r\n")) == std::string::npos) {
      if (!receive()) return std::exchange(input_, {});
    }
    const std::string header = input_.substr(0, end + 4);
    input_.erase(0, end + 4);
    return header;
  }
  std::string upgrade(const std::string& target = "/feed") {
    send(upgrade_request(target));
    return header();
  }

  /// A masked frame, with the length's bytes as given where they should lie.
  static std::string frame(unsigned first_byte, std::string_view payload,
                           std::optional<std::uint64_t> declared = std::nullopt) {
    const std::uint64_t length = declared.value_or(payload.size());
    std::string frame(1, static_cast<char>(first_byte));
    const int bytes = length < 126 ? 0 : length < 65536 ? 2 : 8;
    frame += static_cast<char>(0x80 | (bytes == 0 ? length : bytes == 2 ? 126u : 127u));
    for (int i = bytes; i-- > 0;) frame += static_cast<char>(length >> (8 * i));
    frame += "mask";
    for (std::size_t i = 0; i < payload.size(); ++i) {
      frame += static_cast<char>(payload[i] ^ "mask"[i % 4]);
    }
    return frame;
  }
  static std::string hello_frame(std::uint64_t feed = 0, std::uint64_t last = 0) {
    const wire::Bytes hello = wire::encode(wire::Hello{feed, last});
    return frame(0x80 | kBinary, {reinterpret_cast<const char*>(hello.data()), hello.size()});
  }

  /// Upgraded, hello said, welcome received.
  wire::Welcome join(std::uint64_t feed = 0, std::uint64_t last = 0,
                     const std::string& target = "/feed") {
    upgrade(target);
    send(hello_frame(feed, last));
    const auto message = next();
    return wire::decode_welcome(message ? message->bytes : wire::Bytes{}).value_or(wire::Welcome{});
  }

  /// The next whole message or control frame; pings are answered, fragments joined. None when the
  /// server closed or is silent for too long.
  std::optional<Message> next(int patience_ms = kPatience) {
    Message message;
    for (;;) {
      std::optional<Message> part = next_frame(patience_ms);
      if (!part) return std::nullopt;
      const bool last = (part->opcode & 0x80) != 0;
      const unsigned opcode = part->opcode & 0x0f;
      if (opcode == kPing) {
        send(frame(0x80 | kPong,
                   {reinterpret_cast<const char*>(part->bytes.data()), part->bytes.size()}));
        continue;
      }
      if (opcode >= kClose) return Message{opcode, std::move(part->bytes)};
      if (opcode != 0) message.opcode = opcode;
      message.bytes.insert(message.bytes.end(), part->bytes.begin(), part->bytes.end());
      if (last) return message;
    }
  }

  /// Messages until one of the type, it included.
  std::vector<Message> until(std::uint8_t type) {
    std::vector<Message> messages;
    while (auto message = next()) {
      messages.push_back(*std::move(message));
      if (messages.back().opcode == kClose || messages.back().type() == type) break;
    }
    return messages;
  }

 protected:
  int socket() const { return socket_; }
  virtual ssize_t write(std::string_view text) {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  virtual ssize_t read(char* into, std::size_t size) { return ::recv(socket_, into, size, 0); }
  /// Whether read() has something without waiting for the socket.
  virtual bool pending() const { return false; }

 private:
  bool receive(int patience_ms = kPatience) {
    pollfd ready{socket_, POLLIN, 0};
    if (!pending() && ::poll(&ready, 1, patience_ms) <= 0) return false;
    char bytes[4096];
    const ssize_t size = read(bytes, sizeof bytes);
    ended_ = size <= 0;
    if (!ended_) input_.append(bytes, static_cast<std::size_t>(size));
    return !ended_;
  }

  bool have(std::size_t size, int patience_ms) {
    while (input_.size() < size) {
      if (!receive(patience_ms)) return false;
    }
    return true;
  }

  std::optional<Message> next_frame(int patience_ms) {
    const auto byte = [this](std::size_t i) { return static_cast<std::uint8_t>(input_[i]); };
    if (!have(2, patience_ms)) return std::nullopt;
    std::uint64_t size = byte(1);
    const std::size_t extra = size == 126 ? 2 : size == 127 ? 8 : 0;
    if (!have(2 + extra, patience_ms)) return std::nullopt;
    if (extra > 0) size = 0;
    for (std::size_t i = 0; i < extra; ++i) size = size << 8 | byte(2 + i);
    if (!have(2 + extra + size, patience_ms)) return std::nullopt;
    const auto begin = input_.begin() + static_cast<std::ptrdiff_t>(2 + extra);
    Message message{byte(0), wire::Bytes(begin, begin + static_cast<std::ptrdiff_t>(size))};
    input_.erase(0, 2 + extra + size);
    return message;
  }

  int socket_;
  std::uint16_t port_;
  bool connected_ = false, ended_ = false;
  std::string input_;
};

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The page, calls and the feed under TLS, beside plain ones on the same port.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <optional>
#include <thread>

#include "nadir/serve/web_server.hpp"
#include "tls_client.hpp"

namespace nadir::serve {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr std::uint8_t kType = 100;
constexpr std::array<std::uint8_t, 5> kPage = {0x1f, 0x8b, 'a', 'b', 'c'};
constexpr std::uint64_t kLarge = 3'000'001;

char byte_at(std::uint64_t at) { return static_cast<char>(at * 7 + at / 251); }

wire::Bytes record(std::uint32_t content, std::size_t body = 8) {
  wire::Bytes bytes = wire::begin_record(kType);
  for (std::size_t i = 0; i < body; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(byte_at(i)));
  }
  std::memcpy(bytes.data() + wire::kHeaderSize, &content, sizeof content);
  return bytes;
}

template <class Condition>
bool soon(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + 5s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

Answer answer(const Call& call) {
  if (call.path == "/api/large") {
    return {200, "image/png", {}, Download{"a", kLarge, "t", [](auto at, std::span<char> into) {
                                             for (char& c : into) c = byte_at(at++);
                                             return static_cast<std::ptrdiff_t>(into.size());
                                           }}};
  }
  return {200, "text/plain", call.method + (call.local ? " local " : " ") + call.body};
}

class Tls : public testing::Test {
 protected:
  static Config settings(const CertificateFiles& files) {
    Config config;
    config.port = 0;
    config.header_timeout = 0.8;
    config.idle_timeout = 0.8;
    config.stall_timeout = 1.2;
    config.certificate = files.certificate();
    config.key = files.key();
    return config;
  }
  TlsClient client(int receive_buffer = 0, int version = 0) {
    return TlsClient(server->port(), files.certificate(), receive_buffer, version);
  }
  RawClient plain() { return RawClient(server->port()); }

  const CertificateFiles files;
  std::optional<WebServer> server{
      std::in_place, settings(files), std::vector<Asset>{{"/index.html", "text/html", kPage}},
      std::nullopt,  Listen::at_once, Handlers{.call = answer}};
};

TEST_F(Tls, ServesThePageOnThePortThatServesItPlain) {
  const std::string port = std::to_string(server->port());
  TlsClient secure = client();
  ASSERT_TRUE(secure.secure());
  const std::string page = secure.get("/");
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(page, HasSubstr("connect-src 'self' wss://127.0.0.1:" + port + ";"));
  EXPECT_TRUE(
      page.ends_with("\r\n\r\n\x1f\x8b"
                     "abc"));
  EXPECT_TRUE(secure.was_told());
  const std::string beside = plain().get("/");
  EXPECT_THAT(beside, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(beside, HasSubstr("connect-src 'self' ws://127.0.0.1:" + port + ";"));
}

TEST_F(Tls, IsOfVersion12AtLeastWithForwardSecrecy) {
  EXPECT_EQ(client(0, TLS1_3_VERSION).version(), "TLSv1.3");
  TlsClient older = client(0, TLS1_2_VERSION);
  ASSERT_TRUE(older.secure());
  EXPECT_EQ(older.version(), "TLSv1.2");
  EXPECT_THAT(SSL_get_cipher_name(older.ssl()), StartsWith("ECDHE-"));
  EXPECT_FALSE(client(0, TLS1_1_VERSION).secure());
}

TEST_F(Tls, IsNotNegotiatedAgain) {
  TlsClient older = client(0, TLS1_2_VERSION);
  ASSERT_TRUE(older.secure());
  EXPECT_EQ(SSL_renegotiate(older.ssl()), 1);
  SSL_do_handshake(older.ssl());
  EXPECT_THAT(older.get("/"), Not(StartsWith("HTTP/1.1 200")));
}

TEST_F(Tls, CarriesCallsAndDownloads) {
  TlsClient calling = client();
  calling.send("POST /api/x HTTP/1.1\r\nHost: " + calling.host() +
               "\r\nOrigin: " + calling.origin() + "\r\nContent-Length: 5\r\n\r\nhello");
  EXPECT_THAT(calling.rest(), testing::EndsWith("\r\n\r\nPOST local hello"));
  TlsClient loading = client();
  const std::string large = loading.get("/api/large");
  const std::size_t body = large.find("\r\n\r\n") + 4;
  ASSERT_EQ(large.size() - body, kLarge);
  std::uint64_t at = 0;
  EXPECT_TRUE(std::all_of(large.begin() + static_cast<std::ptrdiff_t>(body), large.end(),
                          [&](char c) { return c == byte_at(at++); }));
  EXPECT_TRUE(loading.was_told());
}

TEST_F(Tls, OpensTheFeedToThePageOfItsOwnSchemeOnly) {
  EXPECT_THAT(client().upgrade(), StartsWith("HTTP/1.1 101 "));
  TlsClient of_plain = client();
  std::string request = of_plain.upgrade_request();
  request.replace(request.find("https://"), 8, "http://");
  of_plain.send(request);
  EXPECT_THAT(of_plain.rest(), StartsWith("HTTP/1.1 403 "));
  RawClient of_secure = plain();
  request = of_secure.upgrade_request();
  request.replace(request.find("http://"), 7, "https://");
  of_secure.send(request);
  EXPECT_THAT(of_secure.rest(), StartsWith("HTTP/1.1 403 "));
}

TEST_F(Tls, CarriesLargeRecordsAndManyOfThem) {
  const wire::Bytes large = record(7, 3'000'001);
  server->feed()->publish(Lane::data, 1'000'000, large);
  for (std::uint32_t i = 1; i <= 2000; ++i) server->feed()->publish(Lane::state, i, record(i));
  TlsClient viewer = client();
  EXPECT_NE(viewer.join().feed, 0u);
  for (std::uint32_t i = 1; i <= 2000; ++i) {
    const auto message = viewer.next();
    ASSERT_TRUE(message);
    ASSERT_EQ(content(*message), i);
  }
  const auto message = viewer.next();
  ASSERT_TRUE(message);
  ASSERT_EQ(message->bytes.size(), large.size());
  EXPECT_TRUE(std::equal(large.begin() + wire::kHeaderSize, large.end(),
                         message->bytes.begin() + wire::kHeaderSize));
}

TEST_F(Tls, KeepsTheBudgetOfWhatAViewerMaySay) {
  TlsClient raw = client();
  raw.upgrade();
  std::string flood = RawClient::hello_frame();
  for (int i = 0; i < 3000; ++i) flood += RawClient::frame(0x89, "");
  std::thread sender([&] {
    while (raw.send(flood)) {
    }
  });
  EXPECT_TRUE(soon([&] { return server->stats().refused == 1; }));
  EXPECT_TRUE(soon([&] { return server->stats().clients == 0; }));
  sender.join();
}

TEST_F(Tls, FreesThePlacesOfViewersThatStallOrFallSilent) {
  TlsClient alive = client(), silent = client(), stalled = client(1024);
  alive.join();
  silent.join();
  stalled.join();
  EXPECT_EQ(server->stats().clients, 3u);
  std::uint32_t i = 0;
  EXPECT_TRUE(soon([&] {
    server->feed()->publish(Lane::data, 1, record(++i, 100'000));
    alive.next(50);  // answers pings
    return server->stats().timed_out == 2;
  }));
  EXPECT_EQ(server->stats().clients, 1u);
}

TEST_F(Tls, EndsWhatOnlyBeginsAsAHandshake) {
  for (const std::string& garbage :
       {std::string("\x16\x03\x01\x00\x05hello", 10), "\x16" + std::string(100'000, 'x')}) {
    RawClient raw = plain();
    raw.send(garbage);
    EXPECT_THAT(raw.rest(), Not(HasSubstr("HTTP")));
    EXPECT_TRUE(raw.closed());
  }
  EXPECT_THAT(client().get("/"), StartsWith("HTTP/1.1 200 "));
}

TEST_F(Tls, WaitsForNoHandshakeForLong) {
  RawClient silent = plain(), first = plain(), more = plain();
  first.send("\x16");
  more.send(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11));
  TlsClient without_request = client();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(silent.closed());
  EXPECT_TRUE(first.closed());
  EXPECT_TRUE(more.closed());
  EXPECT_EQ(without_request.rest(), "");
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST_F(Tls, CountsHandshakesAmongTheConnections) {
  std::vector<RawClient> crowd;
  for (std::size_t i = 0; i < 3 * settings(files).max_clients; ++i) {
    crowd.push_back(plain());
    crowd.back().send("\x16");
  }
  EXPECT_TRUE(soon([&] {
    plain();
    return server->stats().refused > 0;
  }));
  EXPECT_TRUE(soon([&] { return client().secure(); })) << "once they are gone";
}

TEST_F(Tls, SaysGoodbyeAndStopsWithViewersConnected) {
  TlsClient polite = client(), deaf = client();
  polite.join();
  deaf.join();
  RawClient half = plain();
  half.send("\x16\x03");
  const auto start = std::chrono::steady_clock::now();
  server->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);
  const auto messages = polite.until(0xff);
  ASSERT_FALSE(messages.empty());
  EXPECT_EQ(messages.back().close_code(), 1001u);
  server.reset();
  EXPECT_TRUE(half.closed());
}

TEST_F(Tls, SendsViewersOverWhenAFeedEnds) {
  TlsClient viewer = client();
  viewer.join();
  server->begin_feed();
  const auto messages = viewer.until(0xff);
  ASSERT_FALSE(messages.empty());
  EXPECT_EQ(messages.back().close_code(), 1012u);
  viewer.send(RawClient::frame(0x88, "\x03\xf4"));
  EXPECT_TRUE(viewer.closed());
  EXPECT_TRUE(viewer.was_told());
  EXPECT_TRUE(soon([&] { return server->stats().clients == 0; }));
}

}  // namespace
}  // namespace nadir::serve

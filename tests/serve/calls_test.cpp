// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Calls and downloads beside the feed, over real sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <latch>
#include <mutex>
#include <thread>

#include "download_places.hpp"
#include "nadir/serve/web_server.hpp"
#include "raw_client.hpp"

namespace nadir::serve {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::uint8_t kType = 100;
constexpr std::uint64_t kLarge = 3'000'001, kSmall = 9;

Config quick() {
  Config config;
  config.port = 0;
  config.header_timeout = 0.5;
  config.stall_timeout = 1.2;
  return config;
}

char byte_at(std::uint64_t at) { return static_cast<char>(at * 7 + at / 251); }

std::string bytes(std::uint64_t begin, std::uint64_t end) {
  std::string text;
  for (std::uint64_t at = begin; at < end; ++at) text += byte_at(at);
  return text;
}

std::string body_of(const std::string& answer) {
  return answer.substr(answer.find("\r\n\r\n") + 4);
}

/// Answers calls under a few paths, and remembers them.
class Calls : public testing::Test {
 protected:
  Answer answer(const Call& call) {
    {
      const std::scoped_lock lock(mutex);
      calls.push_back(call);
    }
    if (call.path == "/api/wait") {
      waiting = true;
      go_on.wait();
    }
    if (call.path == "/api/throw") throw std::runtime_error("not for strangers");
    if (call.path == "/api/large") return {200, "image/png", {}, large(kLarge)};
    if (call.path == "/api/small") return {200, "image/jpeg", {}, small()};
    if (call.path == "/api/short") return {200, "image/png", {}, large(kLarge / 2)};
    if (call.path == "/api/slow") {
      Download slow = large(kLarge);
      slow.read = [this, read = slow.read](std::uint64_t at, std::span<char> into) {
        if (at > 0) waiting = true;
        if (at > 0) go_on.wait();
        return read(at, into);
      };
      return {200, "image/png", {}, slow};
    }
    return {call.path == "/api/none" ? 404u : 200u, "application/json", "{\"a\":1}"};
  }
  /// There are so many bytes, of the kLarge that are promised.
  static Download large(std::uint64_t there) {
    return {"a file\".bin", kLarge, "t-1", [there](std::uint64_t at, std::span<char> into) {
              const std::uint64_t end = std::min<std::uint64_t>(there, at + into.size());
              for (std::uint64_t i = at; i < end; ++i) into[i - at] = byte_at(i);
              return at < end ? static_cast<std::ptrdiff_t>(end - at) : 0;
            }};
  }

  static Download small() {
    Download small = large(kSmall);
    small.size = kSmall;
    return small;
  }

  RawClient client() { return RawClient(server.port()); }
  std::string told(const std::string& method, const std::string& path, const std::string& fields,
                   const std::string& body) {
    RawClient raw = client();
    raw.send(method + ' ' + path + " HTTP/1.1\r\nHost: " + raw.host() + "\r\n" + fields +
             "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    return raw.rest();
  }
  void await_worker() const {
    while (!waiting) std::this_thread::sleep_for(1ms);
  }

  std::mutex mutex;
  std::vector<Call> calls;
  std::atomic<bool> waiting = false;
  std::latch go_on{1};
  WebServer server{quick(), {}, {}, Listen::at_once, {.call = [this](const Call& call) {
                     return answer(call);
                   }}};
};

TEST_F(Calls, AreHandedOnWithAllThatMatters) {
  const std::string answer = told("POST", "/api/a/b?c=d%20e?f",
                                  "Authorization: Bearer abc\r\nNadir-Session: s-1\r\n"
                                  "Nadir-Name: Jo%C5%BEe\r\n",
                                  "{\"x\":1}");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: application/json\r\n"));
  EXPECT_THAT(answer, HasSubstr("Cache-Control: no-store\r\n"));
  EXPECT_THAT(answer, HasSubstr("Cross-Origin-Resource-Policy: same-origin\r\n"));
  EXPECT_EQ(body_of(answer), "{\"a\":1}");
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_EQ(calls[0].method, "POST");
  EXPECT_EQ(calls[0].path, "/api/a/b");
  EXPECT_EQ(calls[0].query, "c=d%20e?f");
  EXPECT_EQ(calls[0].token, "abc");
  EXPECT_EQ(calls[0].session, "s-1");
  EXPECT_EQ(calls[0].name, "Jo%C5%BEe");
  EXPECT_EQ(calls[0].caller, "127.0.0.1");
  EXPECT_TRUE(calls[0].local);
  EXPECT_EQ(calls[0].body, "{\"x\":1}");
}

TEST_F(Calls, NeedNoCompressionAndTellTheirStatus) {
  EXPECT_THAT(client().get("/api/none", "Accept-Encoding: identity\r\n"),
              StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(client().get("/apix"), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(client().get("/api"), StartsWith("HTTP/1.1 404 "));
  EXPECT_EQ(calls.size(), 1u);
}

TEST_F(Calls, HaveOneTokenOrNone) {
  told("DELETE", "/api/a", "Authorization: Bearer a\r\nAuthorization: Bearer b\r\n", "");
  told("DELETE", "/api/a", "Authorization: Basic abc\r\n", "");
  told("DELETE", "/api/a", "Nadir-Session: a\r\nNadir-Session: b\r\n", "");
  ASSERT_EQ(calls.size(), 3u);
  for (const Call& call : calls) EXPECT_EQ(call.token + call.session, "");
}

TEST_F(Calls, ThatChangeThingsComeFromTheOwnPageOrFromNone) {
  const std::string own = "Origin: http://" + client().host() + "\r\n";
  EXPECT_THAT(told("POST", "/api/a", own, "{}"), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(told("POST", "/api/a", "", "{}"), StartsWith("HTTP/1.1 200 "));
  for (const auto* origin : {"http://evil.example", "null", "http://127.0.0.1", "",
                             "http://127.0.0.1:1", "https://127.0.0.1"}) {
    const std::string field = "Origin: " + std::string(origin) + "\r\n";
    EXPECT_THAT(told("POST", "/api/a", field, "{}"), StartsWith("HTTP/1.1 403 ")) << origin;
    EXPECT_THAT(told("DELETE", "/api/a", field, ""), StartsWith("HTTP/1.1 403 ")) << origin;
  }
  EXPECT_THAT(told("POST", "/api/a", own + own, "{}"), StartsWith("HTTP/1.1 403 "));
  EXPECT_EQ(calls.size(), 2u);
}

TEST_F(Calls, AreNoOtherMethodsAndNoBodiesElsewhere) {
  const std::string refused = told("PUT", "/api/a", "", "{}");
  EXPECT_THAT(refused, StartsWith("HTTP/1.1 405 "));
  EXPECT_THAT(refused, HasSubstr("Allow: GET, POST, DELETE\r\n"));
  EXPECT_EQ(body_of(refused), "{\"error\":\"only GET, POST and DELETE are understood\"}");
  for (const auto* method : {"HEAD", "OPTIONS", "PATCH", "TRACE", "post"}) {
    EXPECT_THAT(told(method, "/api/a", "", ""), StartsWith("HTTP/1.1 405 ")) << method;
  }
  EXPECT_THAT(told("GET", "/api/a", "", "x"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(told("DELETE", "/api/a", "", "x"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(told("POST", "/feed", "", "x"), StartsWith("HTTP/1.1 405 "));
  EXPECT_THAT(told("POST", "/", "", ""), StartsWith("HTTP/1.1 405 "));
  EXPECT_TRUE(calls.empty());
}

TEST_F(Calls, HaveBodiesOfBoundedSizeOnly) {
  EXPECT_THAT(told("POST", "/api/a", "", std::string(kMostBody, 'x')), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(told("POST", "/api/a", "", std::string(kMostBody + 1, 'x')),
              AllOf(StartsWith("HTTP/1.1 413 "), HasSubstr("\r\n\r\n{\"error\":")));
  const std::string begin = "POST /api/a HTTP/1.1\r\nHost: localhost\r\n";
  RawClient declared = client(), chunked = client(), behind = client(), both = client();
  declared.send(begin + "Content-Length: 18446744073709551615\r\n\r\n");
  EXPECT_THAT(declared.rest(), StartsWith("HTTP/1.1 4"));
  chunked.send(begin + "Transfer-Encoding: chunked\r\n\r\n11000\r\n" + std::string(0x11000, 'x'));
  EXPECT_THAT(chunked.rest(), StartsWith("HTTP/1.1 413 "));
  behind.send(begin + "Content-Length: 2\r\n\r\n{}GET / HTTP/1.1\r\n");
  EXPECT_THAT(behind.rest(), StartsWith("HTTP/1.1 400 "));
  both.send(begin + "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n{}");
  EXPECT_THAT(both.rest(), StartsWith("HTTP/1.1 400 "));
  ASSERT_EQ(calls.size(), 1u);
}

TEST_F(Calls, WaitForNoBodyForLong) {
  RawClient slow = client();
  const std::string begin = "POST /api/a HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n";
  slow.send(begin + "abcd");
  EXPECT_TRUE(slow.closed());
  RawClient byte_by_byte = client();
  for (const char c : begin + "abcde") byte_by_byte.send({&c, 1});
  EXPECT_THAT(byte_by_byte.rest(), StartsWith("HTTP/1.1 200 "));
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_EQ(calls[0].body, "abcde");
}

TEST_F(Calls, ThatFailTellNothingOfTheInside) {
  const std::string answer = client().get("/api/throw");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 500 "));
  EXPECT_THAT(answer, Not(HasSubstr("strangers")));
}

TEST_F(Calls, HoldUpNothingOfTheFeed) {
  RawClient viewer = client(), waits = client();
  viewer.join();
  waits.send("GET /api/wait HTTP/1.1\r\nHost: localhost\r\n\r\n");
  await_worker();
  constexpr std::uint32_t kRecords = 100;
  for (std::uint32_t i = 0; i < kRecords; ++i) {
    server.feed()->publish(Lane::state, i, wire::begin_record(kType));
    const auto message = viewer.until(kType);
    ASSERT_FALSE(message.empty());
    ASSERT_EQ(message.back().type(), kType) << i;
  }
  EXPECT_THAT(client().get("/"), StartsWith("HTTP/1.1 404 "));
  go_on.count_down();
  EXPECT_THAT(waits.rest(), StartsWith("HTTP/1.1 200 "));
}

TEST_F(Calls, ThatAreTooManyAreTurnedAway) {
  std::vector<RawClient> crowd;
  for (int i = 0; i < 8; ++i) {
    crowd.emplace_back(server.port());
    crowd.back().send("GET /api/wait HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  await_worker();
  std::string turned_away;
  do {  // until all eight are there
    turned_away = client().get("/api/wait");
  } while (turned_away.empty());
  EXPECT_THAT(turned_away, StartsWith("HTTP/1.1 503 "));
  for (int i = 0; i < 2; ++i) {  // who commands is not kept out by who looks
    crowd.emplace_back(server.port());
    crowd.back().send("POST /api/wait HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
  }
  go_on.count_down();
  for (RawClient& waits : crowd) EXPECT_THAT(waits.rest(), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(client().get("/api/wait"), StartsWith("HTTP/1.1 200 "));
}

TEST_F(Calls, HandOutFilesWholeAndInParts) {
  const std::string whole = client().get("/api/large");
  EXPECT_THAT(whole, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(whole, HasSubstr("Content-Length: 3000001\r\n"));
  EXPECT_THAT(whole, HasSubstr("Content-Disposition: attachment; filename=\"a_file_.bin\"\r\n"));
  EXPECT_THAT(whole, HasSubstr("ETag: \"t-1\"\r\n"));
  EXPECT_THAT(whole, HasSubstr("Content-Type: image/png\r\n"));
  EXPECT_TRUE(body_of(whole) == bytes(0, kLarge));
  const std::string rest =
      client().get("/api/large", "Range: bytes=2900000-\r\nIf-Range: \"t-1\"\r\n");
  EXPECT_THAT(rest, StartsWith("HTTP/1.1 206 Partial Content\r\n"));
  EXPECT_THAT(rest, HasSubstr("Content-Range: bytes 2900000-3000000/3000001\r\n"));
  EXPECT_TRUE(body_of(rest) == bytes(2'900'000, kLarge));
  const std::string changed =
      client().get("/api/large", "Range: bytes=2900000-\r\nIf-Range: \"t-0\"\r\n");
  EXPECT_THAT(changed, StartsWith("HTTP/1.1 200 OK\r\n"));
  const std::string beyond = client().get("/api/large", "Range: bytes=3000001-\r\n");
  EXPECT_THAT(beyond, StartsWith("HTTP/1.1 416 "));
  EXPECT_THAT(beyond, HasSubstr("Content-Range: bytes */3000001\r\n"));
}

TEST_F(Calls, BreakOffAFileThatIsShorterThanItWas) {
  const std::string answer = client().get("/api/short");
  EXPECT_THAT(answer, HasSubstr("Content-Length: 3000001\r\n"));
  EXPECT_TRUE(body_of(answer) == bytes(0, kLarge / 2));
}

TEST_F(Calls, DownloadsTakeNothingOfTheFeed) {
  RawClient viewer = client();
  viewer.join();
  std::vector<RawClient> stalled;
  for (int i = 0; i < 7; ++i) {
    stalled.emplace_back(server.port(), 1024);
    stalled.back().send("GET /api/large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  RawClient slow_disk = client();
  slow_disk.send("GET /api/slow HTTP/1.1\r\nHost: localhost\r\n\r\n");
  await_worker();  // a read that does not return
  std::uint32_t received = 0;
  constexpr std::uint32_t kRecords = 100;
  for (std::uint32_t i = 0; i < kRecords; ++i) {
    wire::Bytes record = wire::begin_record(kType);
    record.resize(40'000);
    server.feed()->publish(Lane::data, i % 10, std::move(record));
    for (const Message& message : viewer.until(wire::kCaughtUpType)) {
      received += message.type() == kType;
    }
  }
  EXPECT_EQ(received, kRecords);
  go_on.count_down();
  EXPECT_TRUE(body_of(slow_disk.rest()) == bytes(0, kLarge));
  const auto end = std::chrono::steady_clock::now() + 5s;
  while (server.stats().timed_out < 7 && std::chrono::steady_clock::now() < end) viewer.next(50);
  EXPECT_EQ(server.stats().timed_out, 7u) << "stalled downloads are ended";
}

TEST_F(Calls, SlowDownloadsOfOneLeaveRoomForOthers) {
  std::vector<RawClient> stalled;
  for (std::size_t i = 0; i < DownloadPlaces::kMostOfOne; ++i) {
    stalled.emplace_back(server.port(), 1024);
    stalled.back().send("GET /api/large HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_THAT(stalled.back().header(), StartsWith("HTTP/1.1 200 "));
  }
  EXPECT_THAT(client().get("/api/large"), StartsWith("HTTP/1.1 503 "));
  EXPECT_TRUE(body_of(client().get("/api/small")) == bytes(0, kSmall));
  constexpr in_addr_t kOther = 0x7F000002;
  RawClient other(server.port(), 0, kOther);
  ASSERT_TRUE(other.connected()) << "from another address of this machine";
  EXPECT_TRUE(body_of(other.get("/api/large")) == bytes(0, kLarge));
  stalled.pop_back();
  while (client().get("/api/large").starts_with("HTTP/1.1 503 ")) std::this_thread::sleep_for(1ms);
}

TEST_F(Calls, TheServerEndsWithCallsAndDownloadsUnderWay) {
  std::vector<RawClient> stalled;
  for (int i = 0; i < 4; ++i) {
    stalled.emplace_back(server.port(), 1024);
    stalled.back().send("GET /api/large HTTP/1.1\r\nHost: localhost\r\n\r\n");
    stalled.back().header();
  }
  RawClient waits = client(), queued = client();
  waits.send("GET /api/wait HTTP/1.1\r\nHost: localhost\r\n\r\n");
  await_worker();
  queued.send("GET /api/a HTTP/1.1\r\nHost: localhost\r\n\r\n");
  std::thread later([this] {
    std::this_thread::sleep_for(50ms);
    go_on.count_down();
  });
  server.stop();
  later.join();
}

TEST(WithoutAHandler, ThereAreNoCalls) {
  WebServer server(quick(), {});
  EXPECT_THAT(RawClient(server.port()).get("/api/a"), StartsWith("HTTP/1.1 404 "));
}

}  // namespace
}  // namespace nadir::serve

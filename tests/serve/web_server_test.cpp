// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/serve/web_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <thread>
#include <utility>

#include "nadir/core/check.hpp"
#include "raw_client.hpp"

namespace nadir::serve {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::uint8_t kType = 100;
constexpr std::array<std::uint8_t, 5> kPage = {0x1f, 0x8b, 'a', 'b', 'c'};

Config quick() {
  Config config;
  config.port = 0;
  config.header_timeout = 0.8;
  config.idle_timeout = 0.8;
  config.stall_timeout = 1.2;
  return config;
}

wire::Bytes record(std::uint32_t content, std::size_t body = 8) {
  wire::Bytes bytes = wire::begin_record(kType);
  bytes.resize(bytes.size() + body);
  std::memcpy(bytes.data() + wire::kHeaderSize, &content, sizeof content);
  return bytes;
}

/// Contents of the records up to CaughtUp.
std::vector<std::uint32_t> contents(RawClient& client) {
  std::vector<std::uint32_t> all;
  for (const Message& message : client.until(wire::kCaughtUpType)) {
    if (message.type() == kType) all.push_back(content(message));
  }
  return all;
}

template <class Condition>
bool soon(Condition condition, std::chrono::milliseconds patience = 5s) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

class WebServerTest : public testing::Test {
 protected:
  RawClient client() { return RawClient(server.port()); }

  /// What a client that only sends these bytes is told.
  std::string answer(std::string_view bytes) {
    RawClient raw = client();
    raw.send(bytes);
    return raw.rest();
  }

  WebServer server{quick(), {{"/index.html", "text/html", kPage}}};
};

TEST_F(WebServerTest, HandsOutThePageCompressedUnderAStrictPolicy) {
  const std::string answer = client().get("/");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Encoding: gzip\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: text/html\r\n"));
  EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'self'; connect-src 'self' "
                                "ws://127.0.0.1:" +
                                std::to_string(server.port()) + ";"));
  EXPECT_TRUE(
      answer.ends_with("\r\n\r\n\x1f\x8b"
                       "abc"));
}

TEST_F(WebServerTest, KnowsNoOtherPath) {
  for (const auto* path :
       {"/index.htm", "/../etc/passwd", "/..%2f..%2fetc/passwd", "/%00", "//index.html",
        "/index.html/", "/./index.html", "/%c0%ae%c0%ae/", "/index.html%00.png", "/\\..\\", "/a"}) {
    EXPECT_THAT(client().get(path), StartsWith("HTTP/1.1 404 ")) << path;
  }
}

TEST_F(WebServerTest, RefusesWhatIsNoProperRequest) {
  const std::string host = "Host: localhost\r\n";
  for (const std::string& request :
       {std::string("GET / HTTP/1.1\r\n\r\n"), std::string("GET / HTTP/1.0\r\n\r\n"),
        "GET / HTTP/1.1\r\n" + host + host + "\r\n", "GET / HTTP/1.1\n" + host + "\r\n",
        "GET / HTTP/9.1\r\n" + host + "\r\n", std::string("GET /\r\n\r\n"),
        "GET / HTTP/1.1\r\n" + host + "Content-Length: 5\r\n\r\nhello",
        "GET / HTTP/1.1\r\n" + host + "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n",
        "GET / HTTP/1.1\r\n" + host + "Content-Length: 5\r\nContent-Length: 6\r\n\r\n",
        "GET / HTTP/1.1\r\n" + host + "\r\nGET / HTTP/1.1\r\n" + host + "\r\n",
        "GET / HTTP/1.1\r\n" + host + "X: a" + std::string(1, '\0') + "b\r\n\r\n",
        "GET http://localhost/ HTTP/1.1\r\n" + host + "\r\n", std::string("\x16\x03\x01\x02"),
        "GET / HTTP/1.1\r\n" + host + " folded: x\r\n y\r\n\r\n"}) {
    EXPECT_THAT(answer(request), StartsWith("HTTP/1.1 400 ")) << request;
  }
  EXPECT_THAT(answer("POST / HTTP/1.1\r\n" + host + "\r\n"), StartsWith("HTTP/1.1 405 "));
  EXPECT_THAT(answer("GET / HTTP/1.1\r\nHost: rebound.example\r\n\r\n"),
              StartsWith("HTTP/1.1 421 "));
  EXPECT_THAT(answer("GET / HTTP/1.1\r\n" + host + "X: " + std::string(1 << 20, 'x')),
              StartsWith("HTTP/1.1 431 "));
  EXPECT_THAT(client().get("/feed"), StartsWith("HTTP/1.1 426 "));
}

TEST_F(WebServerTest, OpensTheFeedToItsOwnPageOnly) {
  RawClient good = client();
  const std::string header = good.upgrade();
  EXPECT_THAT(header, StartsWith("HTTP/1.1 101 "));
  EXPECT_THAT(header, HasSubstr("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));

  RawClient foreign = client();
  std::string request = foreign.upgrade_request();
  request.replace(request.find("http://127"), 10, "http://128");
  foreign.send(request);
  EXPECT_THAT(foreign.rest(), StartsWith("HTTP/1.1 403 "));
}

TEST_F(WebServerTest, DeclinesCompressionOfMessages) {
  RawClient raw = client();
  std::string request = raw.upgrade_request();
  request.insert(request.size() - 2, "Sec-WebSocket-Extensions: permessage-deflate\r\n");
  raw.send(request);
  const std::string header = raw.header();
  EXPECT_THAT(header, StartsWith("HTTP/1.1 101 "));
  EXPECT_THAT(header, Not(HasSubstr("Extensions")));
}

TEST_F(WebServerTest, WelcomesALateViewerWithAllThatIsRetained) {
  server.feed()->publish(Lane::data, 1, record(10));
  server.feed()->publish(Lane::state, 1, record(20));
  server.feed()->publish(Lane::data, 2, record(30));
  server.feed()->publish(Lane::data, 1, record(11));
  RawClient late = client();
  const wire::Welcome welcome = late.join();
  EXPECT_NE(welcome.feed, 0u);
  EXPECT_EQ(welcome.newest_sequence, 4u);
  EXPECT_THAT(contents(late), testing::ElementsAre(20, 11, 30));
  server.feed()->publish(Lane::state, 1, record(21));
  EXPECT_THAT(contents(late), testing::ElementsAre(21));
}

TEST_F(WebServerTest, ResumesWhereAViewerOfTheSameFeedWas) {
  RawClient first = client();
  const wire::Welcome welcome = first.join();
  for (std::uint32_t i = 1; i <= 5; ++i) server.feed()->publish(Lane::data, i, record(i));
  while (server.stats().sent < 5) std::this_thread::sleep_for(1ms);

  RawClient again = client();
  again.join(welcome.feed, 3);
  EXPECT_THAT(contents(again), testing::ElementsAre(5, 4));
  RawClient other = client();
  other.join(welcome.feed + 1, 3);
  EXPECT_THAT(contents(other), testing::ElementsAre(5, 4, 3, 2, 1));
  RawClient liar = client();
  liar.join(welcome.feed, 1000);
  EXPECT_THAT(contents(liar), testing::ElementsAre(5, 4, 3, 2, 1));
}

TEST_F(WebServerTest, SendsARecordOfManyFramesWhole) {
  const wire::Bytes large = record(7, 3'000'001);
  server.feed()->publish(Lane::data, 1, large);
  RawClient viewer = client();
  viewer.join();
  const auto message = viewer.next();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->opcode, RawClient::kBinary);
  EXPECT_EQ(message->bytes.size(), large.size());
  EXPECT_EQ(wire::sequence(message->bytes), 1u);
}

TEST_F(WebServerTest, TellsAPageOfAnotherVersionToReload) {
  RawClient old = client();
  old.upgrade();
  std::string hello = RawClient::hello_frame();
  hello[6 + 1] = static_cast<char>(9 ^ "mask"[1]);
  old.send(hello);
  const auto message = old.next();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->close_code(), 4000u);
  EXPECT_EQ(message->close_reason(), "this page speaks protocol 9, the device " +
                                         std::to_string(wire::kVersion) + ": reload the page");
}

TEST_F(WebServerTest, ClosesOnAnythingButOneHello) {
  const auto code = [this](const std::string& bytes) {
    RawClient raw = client();
    raw.upgrade();
    raw.send(bytes);
    const auto messages = raw.until(0xff);
    return messages.empty() ? 0u : messages.back().close_code();
  };
  const std::string hello = RawClient::hello_frame();
  const std::string large(5000, 'x');
  EXPECT_EQ(code(RawClient::frame(0x82, "garbage")), 1002u);
  EXPECT_EQ(code(RawClient::frame(0x81, "hello")), 1002u);
  EXPECT_EQ(code(hello + hello), 1008u);
  EXPECT_EQ(code(RawClient::frame(0x82, large)), 1009u);
  EXPECT_EQ(code(RawClient::frame(0x82, "", 64 << 10)), 1009u);
  EXPECT_EQ(code(RawClient::frame(0x82, "", 1ull << 30)), 1009u);
  EXPECT_EQ(code(RawClient::frame(0x82, "", 1ull << 63)), 1009u);
  EXPECT_EQ(code(RawClient::frame(0x02, large.substr(0, 3000)) +
                 RawClient::frame(0x80, large.substr(0, 3000))),
            1009u);
  EXPECT_EQ(code("\x82\x01x"), 1002u) << "unmasked";
  EXPECT_EQ(code(RawClient::frame(0xc2, "x")), 1002u) << "reserved bit";
  EXPECT_EQ(code(RawClient::frame(0x83, "x")), 1002u) << "reserved opcode";
  EXPECT_EQ(code(RawClient::frame(0x80, "x")), 1002u) << "continues nothing";
  EXPECT_EQ(code(RawClient::frame(0x09, "x")), 1002u) << "fragmented ping";
  EXPECT_EQ(code(RawClient::frame(0x81, "\xc0\xaf")), 1007u) << "not UTF-8";
  EXPECT_EQ(code(RawClient::frame(0x88, "\x03\xe8")), 1000u) << "a proper close is answered";
}

TEST_F(WebServerTest, EndsFloodsOfFragmentsAndOfPings) {
  for (const std::string& grain : {RawClient::frame(0x00, ""), RawClient::frame(0x89, "")}) {
    RawClient raw = client();
    raw.upgrade();
    raw.send(RawClient::hello_frame());
    raw.send(RawClient::frame(0x02, ""));
    std::string flood;
    for (int i = 0; i < 3000; ++i) flood += grain;
    std::thread sender([&] {
      while (raw.send(flood)) {
      }
    });
    EXPECT_TRUE(soon([&] { return server.stats().clients == 0; }));
    sender.join();
  }
}

TEST_F(WebServerTest, UnderstandsAHandshakeThatComesByteByByte) {
  RawClient slow = client();
  for (const char c : slow.upgrade_request()) slow.send({&c, 1});
  EXPECT_THAT(slow.header(), StartsWith("HTTP/1.1 101 "));
  for (const char c : RawClient::hello_frame()) slow.send({&c, 1});
  const auto welcome = slow.next();
  ASSERT_TRUE(welcome);
  EXPECT_EQ(welcome->type(), wire::kWelcomeType);
}

TEST_F(WebServerTest, UnderstandsAHandshakeSplitAnywhere) {
  for (std::size_t at = 1; at < client().upgrade_request().size(); at += 7) {
    RawClient raw = client();
    const std::string request = raw.upgrade_request(), hello = RawClient::hello_frame();
    raw.send(request.substr(0, at));
    std::this_thread::sleep_for(1ms);
    raw.send(request.substr(at));
    ASSERT_THAT(raw.header(), StartsWith("HTTP/1.1 101 ")) << at;
    raw.send(hello.substr(0, at % hello.size()));
    std::this_thread::sleep_for(1ms);
    raw.send(hello.substr(at % hello.size()));
    const auto welcome = raw.next();
    ASSERT_TRUE(welcome) << at;
    EXPECT_EQ(welcome->type(), wire::kWelcomeType);
  }
}

TEST_F(WebServerTest, WaitsForNoHeaderAndNoHelloForLong) {
  RawClient header = client(), hello = client(), silent = client();
  header.send("GET / HTTP/1.1\r\nHost: local");
  hello.upgrade();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(header.closed());
  EXPECT_TRUE(hello.closed());
  EXPECT_TRUE(silent.closed());
  EXPECT_LT(std::chrono::steady_clock::now() - start, 3s);
}

TEST_F(WebServerTest, FreesThePlaceOfAViewerThatFellSilent) {
  RawClient alive = client(), gone = client();
  alive.join();
  gone.join();
  EXPECT_EQ(server.stats().clients, 2u);
  const auto end = std::chrono::steady_clock::now() + 2s;
  while (std::chrono::steady_clock::now() < end) alive.next(50);  // answers pings
  EXPECT_EQ(server.stats().clients, 1u);
  EXPECT_EQ(server.stats().timed_out, 1u);
  server.feed()->publish(Lane::state, 1, record(1));
  EXPECT_THAT(contents(alive), testing::ElementsAre(1));
}

TEST_F(WebServerTest, LetsNoStalledViewerDisturbAnother) {
  std::vector<RawClient> stalled;
  for (int i = 0; i < 31; ++i) {
    stalled.emplace_back(server.port(), 1024);
    stalled.back().join();
  }
  RawClient good = client();
  good.join();
  constexpr std::uint32_t kRecords = 200;
  std::uint32_t received = 0;
  std::chrono::steady_clock::duration slowest{};
  for (std::uint32_t i = 1; i <= kRecords; ++i) {
    const auto start = std::chrono::steady_clock::now();
    server.feed()->publish(Lane::data, i % 10, record(i, 40'000));
    for (const std::uint32_t c : contents(good)) received += c == i;
    slowest = std::max(slowest, std::chrono::steady_clock::now() - start);
  }
  EXPECT_EQ(received, kRecords);
  EXPECT_LT(slowest, 1s);
  EXPECT_LE(server.stats().retained_bytes, 10u * 40'016u);
  EXPECT_TRUE(soon([&] {
    good.next(50);
    return server.stats().timed_out == 31;
  }));
  EXPECT_EQ(server.stats().clients, 1u);
}

TEST_F(WebServerTest, GivesASlowViewerTheNewestAndLeavesItComplete) {
  RawClient slow(server.port(), 4096);
  slow.join();
  for (std::uint32_t i = 1; i <= 100; ++i) {
    server.feed()->publish(Lane::data, i % 20, record(i, 20'000));
    server.feed()->publish(Lane::live, 0, record(1000 + i, 20'000));
    std::this_thread::sleep_for(1ms);
  }
  server.feed()->publish(Lane::state, 1, record(500));
  std::map<std::uint32_t, std::uint32_t> newest;
  std::size_t received = 0;
  for (bool complete = false; !complete;) {
    const auto message = slow.next();
    ASSERT_TRUE(message);
    const auto caught_up = wire::decode_caught_up(message->bytes);
    complete = caught_up && caught_up->sequence == 201;
    received += message->type() == kType;
    if (content(*message) <= 100) {
      newest[content(*message) % 20] = std::max(newest[content(*message) % 20], content(*message));
    }
  }
  ASSERT_EQ(newest.size(), 20u);
  for (const auto& [key, last] : newest) EXPECT_GT(last, 80u);
  EXPECT_LT(received, 201u) << "superseded records are not sent";
}

TEST(WebServer, LetsAnAlertOvertakeWhatIsNotUnderWay) {
  constexpr std::uint32_t kAlert = 500, kRecords = 200;
  constexpr std::size_t kRecord = 1000;
  Config patient = quick();
  patient.stall_timeout = 60;
  WebServer server(patient, {});
  RawClient slow(server.port(), 64 << 10);
  slow.join();
  for (std::uint32_t i = 1; i <= kRecords; ++i) {
    server.feed()->publish(Lane::data, i, record(i, kRecord - wire::kHeaderSize));
  }
  std::uint64_t sent = 0;  // until it takes no more
  EXPECT_TRUE(soon([&] {
    std::this_thread::sleep_for(100ms);
    const std::uint64_t before = std::exchange(sent, server.stats().sent);
    return sent > 0 && sent == before;
  }));
  EXPECT_LT(sent, kRecords) << "some wait";
  const std::size_t under_way = slow.unread();
  server.feed()->publish(Lane::state, 1, record(kAlert));
  std::size_t before_it = 0;
  auto message = slow.next();
  for (; message && content(*message) != kAlert; message = slow.next()) {
    before_it += message->bytes.size();
  }
  ASSERT_TRUE(message) << "the alert came";
  EXPECT_LT(before_it, under_way + 4 * kRecord) << "4 kB may wait in the kernel";
}

TEST(WebServer, TurnsAwayMoreViewersThanItServesAndRecovers) {
  Config config = quick();
  config.max_clients = 3;
  WebServer server(config, {});
  std::vector<RawClient> viewers;
  for (int i = 0; i < 3; ++i) {
    viewers.emplace_back(server.port());
    EXPECT_NE(viewers.back().join().feed, 0u);
  }
  RawClient fourth(server.port());
  fourth.send(fourth.upgrade_request());
  EXPECT_THAT(fourth.rest(), StartsWith("HTTP/1.1 503 "));
  viewers.pop_back();
  ASSERT_TRUE(soon([&] { return server.stats().clients == 2; }));
  EXPECT_NE(RawClient(server.port()).join().feed, 0u);
}

TEST(WebServer, SurvivesFarMoreConnectionsThanItTakes) {
  Config config = quick();
  config.max_clients = 4;
  WebServer server(config, {{"/index.html", "text/html", kPage}});
  {
    std::vector<RawClient> crowd;
    for (int i = 0; i < 300; ++i) crowd.emplace_back(server.port());
  }
  EXPECT_TRUE(soon([&] { return RawClient(server.port()).get("/").starts_with("HTTP/1.1 200 "); }));
}

TEST(WebServer, SaysWhoHoldsThePortAndWhatToDo) {
  const WebServer first(quick(), {});
  Config config = quick();
  config.port = first.port();
  try {
    const WebServer second(config, {});
    FAIL() << "two servers on one port";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("127.0.0.1 port " + std::to_string(config.port)));
    EXPECT_THAT(e.what(), HasSubstr("choose another (serve.address, serve.port)"));
  }
}

TEST(WebServer, WaitsForThePortWhenTold) {
  auto first = std::make_unique<WebServer>(quick(), std::vector<Asset>());
  Config config = quick();
  config.port = first->port();
  WebServer second(config, {}, {}, Listen::in_time);
  EXPECT_EQ(second.port(), 0);
  EXPECT_THAT(second.listen_fault(), HasSubstr("127.0.0.1 port " + std::to_string(config.port)));
  first.reset();
  EXPECT_TRUE(soon([&] { return second.port() == config.port; }));
  EXPECT_TRUE(RawClient(second.port()).get("/feed").starts_with("HTTP/1.1 426 "));
}

TEST(WebServer, EndsWhileItWaitsForThePort) {
  const WebServer first(quick(), {});
  Config config = quick();
  config.port = first.port();
  WebServer second(config, {}, {}, Listen::in_time);
  second.stop();
}

TEST(WebServer, RefusesSettingsThatCannotWork) {
  const auto refused = [](auto change) {
    Config config;
    change(config);
    EXPECT_THROW(config.check(), InputError);
  };
  EXPECT_NO_THROW(Config().check());
  refused([](Config& c) { c.address = "example.org"; });
  refused([](Config& c) { c.max_clients = 0; });
  refused([](Config& c) { c.client_bytes = 1; });
  refused([](Config& c) { c.retained_bytes = 1; });
  refused([](Config& c) { c.idle_timeout = 0; });
}

TEST(WebServer, ServesBothFamiliesFromTheIPv6Wildcard) {
  Config config = quick();
  config.address = "::";
  WebServer server(config, {{"/index.html", "text/html", kPage}});
  EXPECT_THAT(RawClient(server.port()).get("/"), StartsWith("HTTP/1.1 200 "));
}

TEST(WebServer, SaysGoodbyeAndStopsWithViewersConnected) {
  std::optional<WebServer> server(std::in_place, quick(), std::vector<Asset>());
  RawClient polite(server->port()), deaf(server->port()), half(server->port());
  polite.join();
  deaf.join();
  half.send("GET /");
  const auto start = std::chrono::steady_clock::now();
  server->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);
  const auto goodbye = polite.next();
  ASSERT_TRUE(goodbye);
  EXPECT_EQ(goodbye->close_code(), 1001u);
  const std::shared_ptr<Feed> feed = server->feed();
  feed->publish(Lane::state, 1, record(1));
  server->stop();
  server.reset();
  feed->publish(Lane::state, 1, record(1));
  EXPECT_TRUE(half.closed());
}

TEST_F(WebServerTest, BeginsAnotherFeedAndSendsItsViewersOver) {
  const std::shared_ptr<Feed> first = server.feed();
  first->publish(Lane::state, 1, record(1));
  RawClient viewer = client();
  viewer.join();
  EXPECT_THAT(contents(viewer), testing::ElementsAre(1));
  const auto second = server.begin_feed();
  first->publish(Lane::state, 2, record(2));
  second->publish(Lane::state, 1, record(11));
  const auto goodbye = viewer.next();
  ASSERT_TRUE(goodbye);
  EXPECT_EQ(goodbye->close_code(), 1012u) << "come again";
  EXPECT_TRUE(soon([&] { return first->viewers() == 0; }));
  RawClient again = client();
  again.join();
  EXPECT_THAT(contents(again), testing::ElementsAre(11));
  EXPECT_EQ(second->viewers(), 1u);
  EXPECT_EQ(server.stats().retained_bytes, wire::kHeaderSize + 8) << "of the first nothing is kept";
}

TEST_F(WebServerTest, LetsGoOfAViewerThatTakesNoFarewell) {
  RawClient deaf(server.port(), 1024);
  deaf.join();
  for (std::uint32_t i = 0; i < 40; ++i) server.feed()->publish(Lane::data, i, record(i, 40'000));
  std::this_thread::sleep_for(100ms);  // until nothing more fits on the way
  server.begin_feed();
  EXPECT_TRUE(soon([&] { return server.stats().clients == 0; }));
}

TEST(WebServer, GivesTheFeedThatAQueryNamesWhileItIsHeld) {
  std::shared_ptr<Feed> recorded;
  WebServer server(quick(), {}, {}, Listen::at_once, {.feed = [&](const std::string& query) {
                     return query == "dive=7" ? recorded : nullptr;
                   }});
  recorded = server.make_feed(1 << 20);
  recorded->publish(Lane::data, 1, record(7));
  server.feed()->publish(Lane::data, 1, record(1));
  RawClient live(server.port()), of_the_dive(server.port());
  live.join();
  of_the_dive.join(0, 0, "/feed?dive=7");
  EXPECT_THAT(contents(live), testing::ElementsAre(1));
  EXPECT_THAT(contents(of_the_dive), testing::ElementsAre(7));
  EXPECT_EQ(recorded->viewers(), 1u);
  EXPECT_EQ(server.stats().clients, 2u);
  EXPECT_THAT(RawClient(server.port()).upgrade("/feed?dive=8"), StartsWith("HTTP/1.1 404 "));
  recorded.reset();
  const auto goodbye = of_the_dive.next();
  ASSERT_TRUE(goodbye);
  EXPECT_EQ(goodbye->close_code(), 1012u);
  server.feed()->publish(Lane::data, 1, record(2));
  EXPECT_THAT(contents(live), testing::ElementsAre(2)) << "goes on";
}

TEST_F(WebServerTest, GivesRecordsOfOneTypeBesideTheFeed) {
  server.feed()->publish(Lane::state, 1, record(1));
  const std::string type = std::to_string(record(1).front());
  RawClient some = client(), none = client();
  some.join(0, 0, "/records?type=" + type);
  none.join(0, 0, "/records?type=99");
  server.feed()->publish(Lane::data, 2, record(2));
  server.feed()->publish(Lane::state, 3, record(3));
  EXPECT_EQ(server.stats().clients, 0u) << "seats are for those who see all";
  const auto next = [](RawClient& from) { return from.next().value_or(Message()); };
  EXPECT_EQ(content(next(some)), 1u);
  EXPECT_EQ(content(next(some)), 3u);
  const auto beat = wire::decode_caught_up(next(none).bytes);
  ASSERT_TRUE(beat) << "it is alive";
  EXPECT_EQ(beat->sequence, 3u);
  RawClient all = client();
  all.join();
  EXPECT_THAT(contents(all), testing::ElementsAre(1, 3, 2));
  for (const char* wrong :
       {"/records", "/records?type=", "/records?type=256", "/records?type=4&a"}) {
    EXPECT_THAT(client().upgrade(wrong), StartsWith("HTTP/1.1 404 ")) << wrong;
  }
  EXPECT_THAT(client().get("/records?type=4"), StartsWith("HTTP/1.1 426 "));
}

TEST(WebServer, StopsWhilePublishing) {
  WebServer server(quick(), {});
  RawClient viewer(server.port());
  viewer.join();
  std::thread publisher([&] {
    for (std::uint32_t i = 0; i < 2000; ++i)
      server.feed()->publish(Lane::data, i % 50, record(i, 1000));
  });
  std::this_thread::sleep_for(2ms);
  server.stop();
  publisher.join();
}

}  // namespace
}  // namespace nadir::serve

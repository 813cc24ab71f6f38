// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "request_rules.hpp"

#include <gtest/gtest.h>

namespace nadir::serve {
namespace {

constexpr std::string_view kLocal = "192.168.2.2";

Request page(std::string_view host) { return {"GET", "/", {host}, {}, "gzip, deflate"}; }

Request feed(std::string_view host, std::vector<std::string_view> origins) {
  return {"GET", "/feed", {host}, std::move(origins), std::nullopt, true};
}

unsigned status(const Request& request, std::string_view local = kLocal) {
  const auto refusal = refusal_of(request, local, {"Rov.local", "10.0.0.9"});
  return refusal ? refusal->status : 200;
}

TEST(RequestRules, AnswerToTheNamesOfThisDevice) {
  for (const auto* host : {"192.168.2.2", "192.168.2.2:8765", "localhost", "localhost:1",
                           "LocalHost:8765", "rov.local:8765", "ROV.local", "10.0.0.9:80"}) {
    EXPECT_EQ(status(page(host)), 200u) << host;
  }
  EXPECT_EQ(status(page("[::1]:8765"), "[::1]"), 200u);
}

TEST(RequestRules, RefuseNamesThatOnlyResolveToThisDevice) {
  for (const auto* host :
       {"evil.example", "192.168.2.3:8765", "localhost.", "localhost.evil", "rov.local.:8765",
        "192.168.2.2.nip.io", "[::1]:8765", "3232236034", "0x7f.1", "127.1"}) {
    EXPECT_EQ(status(page(host)), 421u) << host;
  }
}

TEST(RequestRules, RefuseMalformedMissingAndDoubleHosts) {
  for (const auto* host : {"", ":8765", "localhost:", "localhost:0", "localhost:65536",
                           "localhost:80x", "localhost:80:80", "user@localhost", "localhost/x",
                           "local host", "[::1", "a\"b", "localhost:-1"}) {
    EXPECT_EQ(status(page(host)), 400u) << host;
  }
  EXPECT_EQ(status({"GET", "/", {}, {}, "gzip"}), 400u);
  EXPECT_EQ(status({"GET", "/", {"localhost", "localhost"}, {}, "gzip"}), 400u);
}

TEST(RequestRules, OpenTheFeedToThePageOfTheSameHostOnly) {
  EXPECT_EQ(status(feed("localhost:8765", {"http://localhost:8765"})), 200u);
  EXPECT_EQ(status(feed("localhost", {"http://localhost"})), 200u);
  for (const auto* origin :
       {"http://localhost", "http://localhost:8766", "https://localhost:8765",
        "http://192.168.2.2:8765", "null", "", "http://localhost:8765.evil",
        "http://localhost:8765/", "HTTP://localhost:8765", "file://", "localhost:8765"}) {
    EXPECT_EQ(status(feed("localhost:8765", {origin})), 403u) << origin;
  }
  EXPECT_EQ(status(feed("localhost:8765", {})), 403u);
  EXPECT_EQ(status(feed("localhost:8765", {"http://localhost:8765", "http://localhost:8765"})),
            403u);
}

TEST(RequestRules, TakeAPageForTheirOwnByTheSchemeOfItsConnection) {
  for (const bool tls : {false, true}) {
    Request secure = feed("localhost", {"https://localhost"});
    Request plain = feed("localhost", {"http://localhost"});
    secure.tls = plain.tls = tls;
    EXPECT_EQ(status(secure), tls ? 200u : 403u);
    EXPECT_EQ(status(plain), tls ? 403u : 200u);
  }
}

TEST(RequestRules, UnderstandOnlyAPlainGet) {
  for (const auto* method : {"POST", "HEAD", "PUT", "OPTIONS", "get"}) {
    EXPECT_EQ(status({method, "/", {"localhost"}, {}, "gzip"}), 405u) << method;
  }
  EXPECT_EQ(status({"GET", "/", {"localhost"}, {}, "gzip", false, true}), 400u);
  EXPECT_EQ(status({"GET", "http://localhost/", {"localhost"}, {}, "gzip"}), 400u);
  EXPECT_EQ(status({"GET", "*", {"localhost"}, {}, "gzip"}), 400u);
}

TEST(RequestRules, SendThePageToWhoCanUnpackIt) {
  const auto with = [](std::optional<std::string_view> coding) {
    return status({"GET", "/", {"localhost"}, {}, coding});
  };
  EXPECT_EQ(with(std::nullopt), 200u);
  EXPECT_EQ(with("br, gzip;q=0.5"), 200u);
  EXPECT_EQ(with("*"), 200u);
  EXPECT_EQ(with("identity"), 406u);
  EXPECT_EQ(with("gzip;q=0, br"), 406u);
  EXPECT_EQ(with(""), 406u);
}

TEST(RequestRules, FindThePathBeforeTheQuery) {
  EXPECT_EQ(path_of("/"), "/index.html");
  EXPECT_EQ(path_of("/?view=top"), "/index.html");
  EXPECT_EQ(path_of("/assets/a.js?b=/c"), "/assets/a.js");
}

Request call(std::string_view method, std::vector<std::string_view> origins, bool body = false) {
  return {method, "/api/x", {"localhost:8765"}, std::move(origins), "identity", false, body};
}

TEST(RequestRules, LetCallsChangeThingsForThePageOfTheSameHostOrNoPage) {
  const std::string_view own = "http://localhost:8765";
  for (const auto* method : {"POST", "DELETE"}) {
    EXPECT_EQ(status(call(method, {own})), 200u) << method;
    EXPECT_EQ(status(call(method, {})), 200u) << method;
    EXPECT_EQ(status(call(method, {"null"})), 403u) << method;
    EXPECT_EQ(status(call(method, {"http://localhost:8766"})), 403u) << method;
    EXPECT_EQ(status(call(method, {own, own})), 403u) << method;
  }
  EXPECT_EQ(status(call("GET", {"http://elsewhere"})), 200u);  // which cannot read the answer
}

TEST(RequestRules, KnowThreeMethodsOfCallsAndOneElsewhere) {
  EXPECT_EQ(status(call("POST", {}, true)), 200u);
  EXPECT_EQ(status(call("GET", {}, true)), 400u);
  EXPECT_EQ(status(call("DELETE", {}, true)), 400u);
  EXPECT_EQ(status(call("PUT", {})), 405u);
  EXPECT_EQ(status(call("", {})), 405u);
  EXPECT_EQ(status({"POST", "/apis", {"localhost"}, {}, "gzip"}), 405u);
  EXPECT_EQ(status({"POST", "/api/x", {"localhost"}, {}, {}, true}), 405u);
}

}  // namespace
}  // namespace nadir::serve

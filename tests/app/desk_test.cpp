// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "desk.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "device_token.hpp"
#include "publisher.hpp"
#include "record/small_dive.hpp"
#include "serve/raw_client.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using record::ScratchFolder;
using record::write_text;
using serve::Call;

/// A page that says what a test wants.
struct Page {
  Desk& desk;
  std::string token, session, name;
  std::string caller = "10.0.0.7";
  bool local = false;

  std::pair<unsigned, json> say(const std::string& method, const std::string& path,
                                const std::string& body = "", const std::string& query = "") const {
    Call call{method, "/api/" + path, query, token, session, name, caller, local, body};
    const serve::Answer answer = desk.answer(call);
    return {answer.status,
            answer.download ? json("a download") : json::parse(answer.text, nullptr, false)};
  }
  unsigned status(const std::string& method, const std::string& path,
                  const std::string& body = "") const {
    return say(method, path, body).first;
  }
};

class AtTheDesk : public testing::Test {
 protected:
  AtTheDesk() {
    fs::create_directories(scratch / "dives/dive-0001/projected");
    write_text(scratch / "dives/dive-0001/journal-000.nadir", "x");
    fs::create_directories(scratch / "dives/dive-0002/projected");
    write_text(scratch / "dives/dive-0002/journal-000.nadir", "x");
  }
  /// Marks are taken from now on.
  void begin_dive() {
    desk.live().begin(scratch / "dives/dive-0002");
    desk.live().note(5, false, 1234);
    desk.live().record_marks([this](const Mark& mark) {
      marks.push_back(mark);
      return true;
    });
  }
  std::string id_of(const std::string& dive) const {
    for (const json& entry : stranger.say("GET", "dives").second) {
      if (entry["name"] == dive) return entry["id"];
    }
    return "none";
  }

  ScratchFolder scratch;
  const std::string token = new_token();
  Desk desk{scratch / "dives", token, "http://nadir.local:8765/"};
  Page ann{desk, token, "session-ann", "Ann"}, bob{desk, token, "session-bob", "Bob"},
      stranger{desk, "", "session-eve", "Eve"};
  std::vector<Mark> marks;
};

TEST_F(AtTheDesk, TheTokenIsShownOnThisMachineOnly) {
  EXPECT_EQ(stranger.status("GET", "token"), 403u);
  Page board = stranger;
  board.local = true;
  EXPECT_EQ(board.say("GET", "token").second,
            (json{{"token", token}, {"url", "http://nadir.local:8765/"}}));
}

TEST_F(AtTheDesk, AnyoneMayLook) {
  EXPECT_EQ(stranger.say("GET", "dives").second.size(), 2u);
  const std::string dive = "dives/" + id_of("dive-0001");
  const json told = stranger.say("GET", dive).second;
  EXPECT_EQ(told["products"].size(), 1u);
  const std::string file = told["products"][0]["id"];
  EXPECT_EQ(stranger.say("GET", dive + "/files/" + file).second, "a download");
  EXPECT_EQ(stranger.say("GET", dive + "/archive").second, "a download");
  EXPECT_EQ(stranger.say("GET", dive, "", "folder=projected").second["products"], json::array());
  EXPECT_EQ(stranger.say("GET", "control").second, (json{{"controller", nullptr}}));
}

TEST_F(AtTheDesk, KnowsNoOtherPaths) {
  const std::string dive = "dives/" + id_of("dive-0001");
  for (const std::string& path : {std::string(),
                                  std::string("/"),
                                  std::string("dives/"),
                                  std::string("dives/.."),
                                  std::string("dives/../dives"),
                                  dive + "/",
                                  dive + "/..",
                                  dive + "/files",
                                  dive + "/files/",
                                  dive + "/files/../../etc/passwd",
                                  dive + "/files/..%2f..%2fetc",
                                  dive + "/archive/x",
                                  dive + "/images/x",
                                  dive + "/images/-1",
                                  dive + "/images/7",
                                  std::string("marks/x/photo"),
                                  std::string("marks//photo"),
                                  std::string("marks/-1/photo"),
                                  std::string("marks/0/photo"),
                                  std::string("tokens"),
                                  std::string("dive/start")}) {
    EXPECT_EQ(ann.status("GET", path), 404u) << path;
  }
  EXPECT_EQ(stranger.say("GET", dive, "", "folder=..").first, 404u);
  EXPECT_EQ(stranger.say("GET", dive, "", "folder=%2e%2e%2f").first, 404u);
}

TEST_F(AtTheDesk, OnlyWhoHasTheTokenCommands) {
  Page liar = stranger;
  liar.token = std::string(43, 'a');
  for (const char* path : {"control/take", "control/release", "marks", "dive/start", "shutdown"}) {
    EXPECT_EQ(stranger.status("POST", path), 401u) << path;
    EXPECT_EQ(liar.status("POST", path), 401u) << path;
  }
  EXPECT_EQ(stranger.status("DELETE", "dives/" + id_of("dive-0001")), 401u);
  EXPECT_TRUE(fs::exists(scratch / "dives/dive-0001"));
}

TEST_F(AtTheDesk, GuessersAreSlowed) {
  Page liar = stranger;
  int wrong = 0, barred = 0;
  for (int i = 0; i < 1000; ++i) {
    liar.token = new_token();
    const unsigned status = liar.status("POST", "control/take");
    wrong += status == 401;
    barred += status == 429;
  }
  EXPECT_EQ(wrong, 10);
  EXPECT_EQ(barred, 990);
  liar.caller = "10.0.0.8";
  liar.token = token;
  EXPECT_EQ(liar.status("POST", "control/take"), 200u);
}

TEST_F(AtTheDesk, OnePageControlsAndTheOthersAreToldWho) {
  EXPECT_EQ(ann.say("POST", "dive/stop").second,
            (json{{"controller", nullptr}, {"error", "nobody controls; take control first"}}));
  EXPECT_EQ(ann.say("POST", "control/take").second, (json{{"controller", "Ann"}}));
  const auto [status, told] = bob.say("POST", "control/take");
  EXPECT_EQ(status, 409u);
  EXPECT_EQ(told, (json{{"controller", "Ann"}, {"error", "Ann controls"}}));
  for (const char* path : {"marks", "dive/start", "control/renew", "control/release"}) {
    EXPECT_EQ(bob.status("POST", path), 409u) << path;
  }
  EXPECT_EQ(bob.status("DELETE", "dives/" + id_of("dive-0001")), 409u);
  EXPECT_EQ(ann.status("POST", "control/renew"), 200u);
  EXPECT_EQ(bob.status("POST", "control/take", R"({"force": true})"), 200u);
  EXPECT_EQ(ann.status("POST", "control/renew"), 409u);
  EXPECT_EQ(bob.say("POST", "control/release").second, (json{{"controller", nullptr}}));
}

TEST_F(AtTheDesk, SessionsAndNamesAreMadeFit) {
  for (const char* session : {"", "short", "has space in it", "a/b/c/d/e/f", "semi;colon;s"}) {
    Page odd = ann;
    odd.session = session;
    EXPECT_EQ(odd.status("POST", "control/take"), 400u) << session;
  }
  Page named = ann;
  const auto name_of = [&](const std::string& name) {
    named.name = name;
    return named.say("POST", "control/take").second["controller"];
  };
  EXPECT_EQ(name_of("Jo%C5%BEe"), "Jože");
  EXPECT_EQ(name_of("a%0d%0aX-Evil: 1%00%1b[2J"), "a X-Evil: 1[2J");
  EXPECT_EQ(name_of(std::string(1000, 'x')), std::string(40, 'x'));
  EXPECT_EQ(name_of("%ff%fe"), "a page without a name");
}

TEST_F(AtTheDesk, BadBodiesDoNothing) {
  begin_dive();
  for (const char* body :
       {"{", "[]", "null", "1", "{\"force\": 1}", "{\"force\": \"yes\"}", "\xff"}) {
    EXPECT_EQ(ann.status("POST", "control/take", body), 400u) << body;
  }
  ann.say("POST", "control/take");
  for (const std::string& body :
       {std::string(""), std::string("{}"), std::string("[1,2,3]"), std::string(R"({"x":1,"y":2})"),
        std::string(R"({"x":1,"y":2,"z":"3"})"), std::string(R"({"x":1,"y":2,"z":1e300})"),
        std::string(R"({"x":1,"y":2,"z":NaN})"), std::string(R"({"x":1,"y":2,"z":1e999})"),
        std::string(R"({"x":1,"y":2,"z":3,"image":-1})"),
        std::string(R"({"x":1,"y":2,"z":3,"image":1.5})"),
        std::string(R"({"x":1,"y":2,"z":3,"note":7})"), std::string(64 << 10, '['),
        R"({"x":)" + std::string(60 << 10, '[')}) {
    EXPECT_EQ(ann.status("POST", "marks", body), 400u) << body.substr(0, 80);
  }
  EXPECT_TRUE(marks.empty());
}

TEST_F(AtTheDesk, MarksAreHandedToTheDive) {
  ann.say("POST", "control/take");
  EXPECT_EQ(ann.say("POST", "marks", R"({"x":1,"y":2,"z":3})").second["error"],
            "no dive is being recorded: a mark would be lost");
  begin_dive();
  const auto [status, told] =
      ann.say("POST", "marks", R"({"x":1,"y":-2.5,"z":3,"image":4,"note":"an\nanchor"})");
  EXPECT_EQ(status, 202u);
  EXPECT_EQ(told, (json{{"id", 0}}));
  EXPECT_EQ(ann.say("POST", "marks", R"({"x":0,"y":0,"z":0,"note":null})").second["id"], 1);
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(marks[0].note, "an anchor");
  EXPECT_EQ(marks[0].image, 4u);
  EXPECT_EQ(marks[0].time, 1234);
  EXPECT_EQ(marks[0].position, Eigen::Vector3d(1, -2.5, 3));
  EXPECT_EQ(ann.say("GET", "marks/0/photo").first, 404u);
  write_text(scratch / "dives/dive-0002/projected/000004.png", "png");
  EXPECT_EQ(ann.say("GET", "marks/0/photo").second, "a download");
  EXPECT_EQ(ann.status("GET", "marks/1/photo"), 404u);
  EXPECT_EQ(ann.status("DELETE", "marks/7"), 404u);
  EXPECT_EQ(ann.status("DELETE", "marks/0"), 202u);
  EXPECT_EQ(ann.status("DELETE", "marks/0"), 404u);
  ASSERT_EQ(marks.size(), 3u);
  EXPECT_TRUE(marks[2].removed);
  const std::string note(3000, 'n');
  ann.say("POST", "marks", json{{"x", 0}, {"y", 0}, {"z", 0}, {"note", note}}.dump());
  EXPECT_EQ(marks.back().note.size(), 500u);
}

TEST_F(AtTheDesk, ADiveIsRemovedByWhoControls) {
  begin_dive();
  ann.say("POST", "control/take");
  EXPECT_EQ(ann.status("DELETE", "dives/" + id_of("dive-0002")), 409u);
  EXPECT_EQ(ann.status("DELETE", "dives/" + id_of("dive-0001")), 200u);
  EXPECT_EQ(ann.status("DELETE", "dives/" + id_of("dive-0001")), 404u);
  EXPECT_FALSE(fs::exists(scratch / "dives/dive-0001"));
}

TEST_F(AtTheDesk, CommandsReachWhoWaitsForThem) {
  ann.say("POST", "control/take");
  EXPECT_EQ(ann.status("POST", "dive/start"), 409u);
  desk.commands().accept({PageCommand::begin_dive});
  EXPECT_EQ(ann.status("POST", "dive/stop"), 409u);
  EXPECT_EQ(ann.status("GET", "dive/start"), 404u) << "never by GET";
  EXPECT_EQ(ann.status("POST", "dive/start"), 202u);
  EXPECT_EQ(desk.commands().take({}, std::chrono::seconds(0)), PageCommand::begin_dive);
}

TEST_F(AtTheDesk, PagesSeeWhereTheRecordingStandsAndWhoControls) {
  serve::Config config;
  config.port = 0;
  serve::WebServer server(config, {}, {}, serve::Listen::at_once, desk.handlers());
  Publisher page(server.feed(), "live", 0, {}, &desk.live());
  serve::RawClient viewer(server.port());
  viewer.join();
  begin_dive();
  serve::RawClient commanding(server.port());
  commanding.send("POST /api/control/take HTTP/1.1\r\nHost: " + commanding.host() +
                  "\r\nAuthorization: Bearer " + token +
                  "\r\nNadir-Session: session-ann\r\nNadir-Name: Ann\r\nContent-Length: 0\r\n\r\n");
  EXPECT_THAT(commanding.rest(), testing::HasSubstr("{\"controller\":\"Ann\"}"));
  std::optional<wire::Recording> recording;
  while (!recording || recording->controller.empty()) {
    const auto message = viewer.next();
    ASSERT_TRUE(message);
    if (const auto decoded = wire::decode_recording(message->bytes)) recording = decoded;
  }
  EXPECT_EQ(recording->controller, "Ann");
  EXPECT_EQ(recording->phase, wire::Phase::recording);
  EXPECT_EQ(recording->name, "dive-0002");
  EXPECT_EQ(recording->saved, 5u);
  EXPECT_EQ(recording->began, 1234);
}

TEST(UrlForOthers, IsANameOfThisDeviceWhereItServesAllNetworks) {
  serve::Config config;
  EXPECT_EQ(url_for_others(config), std::nullopt);
  config.address = "0.0.0.0";
  EXPECT_EQ(url_for_others(config), "http://nadir.local:8765/");
  config.names = {};
  EXPECT_EQ(url_for_others(config), std::nullopt);
  config.address = "192.168.2.2";
  EXPECT_EQ(url_for_others(config), "http://192.168.2.2:8765/");
  config.certificate = config.key = "/nonexistent.pem";
  EXPECT_EQ(url_for_others(config), "https://192.168.2.2:8765/");
  EXPECT_EQ(url_for_others(with_usable_certificate(config)), "http://192.168.2.2:8765/");
  config.address = "::1";
  EXPECT_EQ(url_for_others(config), std::nullopt);
}

}  // namespace
}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What pages may ask of this device beside the feed, and who may command it. Looking is free;
// commanding takes the device's token, and control, which one page has at a time. Recorded dives
// are feeds: dive=ID.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "control.hpp"
#include "dives.hpp"
#include "live_dive.hpp"
#include "nadir/serve/web_server.hpp"
#include "recorded_feeds.hpp"

namespace nadir::app {

class Desk {
 public:
  /// dives: the folder of those that are shown. url: where others find the page, if they can.
  Desk(const std::filesystem::path& dives, std::string token, std::optional<std::string> url);

  /// Status 401 without the token, 429 after too many wrong ones, 409 when another page controls or
  /// it cannot be now; the text is JSON, {"error": why} when it was not done.
  serve::Answer answer(const serve::Call& call);
  /// Refers to this.
  serve::Handlers handlers() {
    return {[this](const serve::Call& call) { return answer(call); },
            [this](const std::string& query) { return recorded(query); }};
  }
  /// Recorded dives are shown from now on, each in a feed of retained_bytes. The server has the
  /// handlers of this, and ends before this does.
  void serve_by(const serve::WebServer& server, std::size_t retained_bytes);

  LiveDive& live() { return live_; }
  Commands& commands() { return commands_; }

 private:
  using Steps = std::vector<std::string_view>;
  std::shared_ptr<serve::Feed> recorded(const std::string& query);
  serve::Answer look_up(const serve::Call& call, const Steps& steps);
  serve::Answer look_up_dive(const serve::Call& call, const Steps& steps);
  serve::Answer show_token(const serve::Call& call) const;
  serve::Answer photograph(std::string_view mark) const;
  std::optional<serve::Answer> refusal_of(const serve::Call& call);
  serve::Answer command(const serve::Call& call, const Steps& steps);
  serve::Answer change_control(const serve::Call& call, std::string_view how);
  serve::Answer add_mark(const serve::Call& call);
  serve::Answer remove_mark(std::string_view mark);
  serve::Answer remove_dive(const std::string& dive);
  serve::Answer give(PageCommand command);
  serve::Answer who_controls(unsigned status, const std::string& error) const;

  const std::optional<std::string> url_;
  LiveDive live_;
  Commands commands_;
  Dives dives_;
  Control control_;
  RecordedFeeds feeds_;
};

/// Without a certificate that cannot be used, which is told on stderr: the page is plain then.
serve::Config with_usable_certificate(serve::Config config);

/// Where the page is found under a name of this device, by https with a certificate; none when it
/// is for this machine only.
std::optional<std::string> url_for_others(serve::Config config);

}  // namespace nadir::app

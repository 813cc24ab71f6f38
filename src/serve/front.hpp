// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One request of a connection and its answer: the page, a call, a download. Who asks for the feed
// is handed on.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "answer_rules.hpp"
#include "download_places.hpp"
#include "nadir/serve/web_server.hpp"
#include "request_rules.hpp"
#include "shared.hpp"
#include "stream.hpp"
#include "worker.hpp"

namespace nadir::serve {

class Front {
 public:
  /// config and shared outlive it. Throws certificate_fault() as InputError.
  Front(const Config& config, Shared& shared, std::vector<Asset> assets, Handlers handlers);

  /// The request when it is a proper one for the feed; else it was answered.
  asio::awaitable<std::optional<HttpRequest>> answer(Stream& stream);
  asio::awaitable<void> refuse(Stream& stream, Refusal refusal, bool of_call = false);
  /// What the query of a proper request for a feed names; null when there is no such feed.
  asio::awaitable<std::shared_ptr<Feed>> find_feed(Stream& stream, std::string query);
  /// Waits for the call at work. The reactor has stopped.
  void stop() { worker_.stop(); }

 private:
  struct Reading;
  asio::awaitable<error_code> begin(Stream& stream, Reading& reading);
  asio::awaitable<void> answer_call(Stream& stream, Reading& reading);
  asio::awaitable<void> send(Stream& stream, const Answer& answer);
  asio::awaitable<void> send_file(Stream& stream, const HttpRequest& request, const Answer& answer);
  asio::awaitable<void> send_bytes(Stream& stream, const Download& download, Part part);
  asio::awaitable<void> send_asset(Stream& stream, const HttpRequest& request, const Asset& asset);

  const Config& config_;
  Shared& shared_;
  std::optional<asio::ssl::context> tls_;
  std::map<std::string, Asset, std::less<>> assets_;
  const Handlers handlers_;
  Count calls_ = 0;
  DownloadPlaces places_;
  Worker worker_;
};

}  // namespace nadir::serve

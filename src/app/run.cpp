// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The live service: waits for what is missing, maps, and tells the service manager that it lives.
#include <cstdio>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <utility>

#include "configured.hpp"
#include "device_token.hpp"
#include "dive_course.hpp"
#include "earlier_dives.hpp"
#include "interrupt.hpp"
#include "nadir/core/check.hpp"
#include "page_assets.hpp"
#include "service.hpp"
#include "verbs.hpp"

namespace nadir::app {
namespace {

// What nadir.socket was made of must not keep a dive from being recorded.
std::unique_ptr<serve::WebServer> open_page(const serve::Config& config,
                                            const ServiceManager& manager,
                                            const serve::Handlers& handlers) {
  std::unique_ptr<serve::WebServer> server;
  try {
    server = std::make_unique<serve::WebServer>(config, page_assets(), manager.socket(),
                                                serve::Listen::in_time, handlers);
  } catch (const InputError& error) {
    if (!manager.socket()) throw;
    std::fprintf(stderr, "%s\n", error.what());
    server = std::make_unique<serve::WebServer>(config, page_assets(), std::nullopt,
                                                serve::Listen::in_time, handlers);
  }
  if (server->port() != 0) {
    std::fprintf(stderr, "the map: %s\n", page_url(config, server->port()).c_str());
  } else {
    std::fprintf(stderr, "%s; it is tried every second\n", server->listen_fault().c_str());
  }
  return server;
}

std::string token_of(const Config& config) {
  const DeviceToken token = device_token(token_file(config.record.dives), record::system_disk());
  if (!token.message.empty()) std::fprintf(stderr, "%s\n", token.message.c_str());
  return token.token;
}

// The page says what is wrong with the settings until they are right; the service manager then
// starts it again.
int wait_for_settings(const Run& live, std::string fault, ServiceManager& manager, Heartbeat& heart,
                      const std::stop_token& stop) {
  serve::Config config;
  if (live.serve && !live.serve->host.empty()) config.address = live.serve->host;
  if (live.serve) config.port = live.serve->port;
  const auto server = open_page(config, manager, {});
  Publisher page(server->feed(), "live", 0);
  manager.ready();
  manager.status("waiting for its settings");
  std::string told;
  do {
    if (std::exchange(told, fault) != fault) {
      const Alert alert{monotonic_now(), std::nullopt, AlertKind::storage, fault,
                        "correct the file; nadir begins by itself"};
      print(alert, stderr);
      page.publish(alert);
    }
    try {
      configured(live.settings, live.serve);
      std::fprintf(stderr, "the settings are right; nadir starts again\n");
      return 1;
    } catch (const InputError& error) {
      fault = error.what();
    }
  } while (heart.pause(stop));
  return 0;
}

}  // namespace

int run(const Run& live) {
  ServiceManager manager;
  cv::setNumThreads(1);
  Interrupt interrupt;
  std::stop_source stop;
  interrupt.on_interrupt([stop]() mutable { stop.request_stop(); });
  Heartbeat heart(manager);
  Config config;
  try {
    config = configured(live.settings, live.serve);
  } catch (const InputError& error) {
    if (!manager.is_there()) throw;
    return wait_for_settings(live, error.what(), manager, heart, stop.get_token());
  }
  const serve::Config serving = with_usable_certificate(config.serve);
  Desk desk(config.record.dives, token_of(config), url_for_others(serving));
  const auto server = open_page(serving, manager, desk.handlers());
  desk.serve_by(*server, serving.retained_bytes);
  manager.ready();
  const Recoveries recoveries(unfinished_dives(config.record.dives));
  return Service(config, manager, heart, *server, desk, stop.get_token()).run();
}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the live service does once its settings are right: dive after dive. The first begins by
// itself at power-on; a page may end it and begin others.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "beginning.hpp"
#include "desk.hpp"
#include "watched_disk.hpp"

namespace nadir::app {

class Service {
 public:
  /// All are to outlive it; stop: to end in good order.
  Service(const Config& config, ServiceManager& manager, Heartbeat& heart, serve::WebServer& server,
          Desk& desk, std::stop_token stop);

  /// The exit status. Throws what a stage of a dive threw.
  int run();

 private:
  std::optional<PageCommand> map_dive();
  std::optional<PageCommand> supervise(Graph& graph);
  std::set<PageCommand> accepted_while_mapping() const;
  void power_off();

  const Config& config_;
  ServiceManager& manager_;
  Heartbeat& heart_;
  serve::WebServer& server_;
  Desk& desk_;
  const std::stop_token stop_;
  std::optional<Publisher> page_;
  LiveCheck check_;
  Beginning beginning_;
  std::unique_ptr<capture::CameraSource> cameras_;
  int status_ = 0;  ///< of the last dive
};

}  // namespace nadir::app

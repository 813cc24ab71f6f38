// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "configured.hpp"

#include "config_file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::app {

Config configured(const Settings& settings, const std::optional<Address>& address) {
  Config config;
  if (settings.file) {
    read_config_file(*settings.file, config);
    try {
      config.check();
    } catch (const InputError& error) {
      throw InputError(settings.file->string() + ": " + error.what());
    }
  }
  try {
    for (const std::string& assignment : settings.assignments) read_assignment(assignment, config);
    if (address && !address->host.empty()) config.serve.address = address->host;
    if (address) config.serve.port = address->port;
    config.check();
  } catch (const InputError& error) {
    throw UsageError(error.what());
  }
  return config;
}

Settings settings_of_service(Settings settings) {
  const std::filesystem::path of_service = "/etc/nadir/nadir.toml";
  std::error_code none;
  if (!settings.file && std::filesystem::exists(of_service, none)) settings.file = of_service;
  return settings;
}

}  // namespace nadir::app

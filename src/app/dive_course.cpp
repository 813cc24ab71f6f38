// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "dive_course.hpp"

#include <sys/resource.h>

#include <opencv2/core/utility.hpp>
#include <utility>

#include "version.hpp"

namespace nadir::app {
namespace {

nlohmann::json as_json(const Config& config) {
  nlohmann::json json;
  for (const Setting& setting : settings()) {
    const auto dot = setting.key.find('.');
    std::visit(
        [&](const auto& value) {
          json[setting.key.substr(0, dot)][setting.key.substr(dot + 1)] = value;
        },
        setting.get(config));
  }
  return json;
}

nlohmann::json as_json(const std::vector<StageStats>& stages) {
  nlohmann::json json = nlohmann::json::array();
  for (const StageStats& stage : stages) {
    json.push_back({{"stage", stage.stage},
                    {"processed", stage.processed},
                    {"dropped", stage.dropped},
                    {"rate_out_hz", stage.rate_out_hz},
                    {"last_ms", stage.last_ms},
                    {"p95_ms", stage.p95_ms},
                    {"cpu_s", stage.cpu_s}});
  }
  return json;
}

// Of the stages, the process and the time since begun.
nlohmann::json rates(const Graph& graph, std::chrono::steady_clock::time_point begun) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begun;
  nlohmann::json json{{"stages", as_json(graph.stats())},
                      {"wall_s", wall.count()},
                      {"cpu_s", in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime)},
                      {"peak_memory_mb", static_cast<double>(usage.ru_maxrss) / 1024}};
  if (const auto utc = graph.utc_offset()) json["utc_minus_time_by_sensors_s"] = seconds(*utc);
  return json;
}

}  // namespace

record::DiveInfo dive_info(nlohmann::json input, const std::string& engine, const Config& config) {
  record::DiveInfo info;
  info.about = {{"input", std::move(input)},
                {"engine", engine},
                {"configuration", as_json(config)},
                {"versions", {{"nadir", kVersion}, {"opencv", CV_VERSION}}}};
  info.origin = reference::parse_origin(config.reference.origin);
  return info;
}

int finish_dive(const EndOfDive& end) {
  const std::exception_ptr fault = end.graph.join();
  if (end.live) end.live->close();
  const auto tell = [&](const Alert& alert) {
    end.progress.add(alert);
    if (end.page) end.page->publish(alert);
  };
  const Dropped& dropped = end.graph.dropped_at_end();
  for (const Alert& alert : dropped.told(dropped.last_image, dropped.last_time)) {
    end.dive.add(alert);
    tell(alert);
  }
  const std::vector<Alert> unwritten = end.dive.finish(rates(end.graph, end.begun), dropped.images);
  for (const Alert& alert : unwritten) tell(alert);
  if (end.live) end.live->end();
  end.progress.finish();
  if (fault) std::rethrow_exception(fault);
  if (end.page) end.page->finish(dropped.images);
  return unwritten.empty() ? 0 : 1;
}

// A page asked for under "every address" would be refused: it is nobody's name.
std::string page_url(const serve::Config& config, std::uint16_t port) {
  const std::string& address = config.address;
  std::string host = address;
  if (address == "0.0.0.0" || address == "::") {
    host = "localhost";
  } else if (address.find(':') != std::string::npos) {
    host = '[' + address + ']';
  }
  const bool here = host == "localhost" || host.starts_with("127.") || host == "[::1]";
  const bool secure = !config.certificate.empty() && !here;
  return (secure ? "https://" : "http://") + host + ':' + std::to_string(port);
}

}  // namespace nadir::app

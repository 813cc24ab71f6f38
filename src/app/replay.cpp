// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>
#include <sys/utsname.h>

#include <chrono>
#include <cstdio>
#include <opencv2/core/utility.hpp>

#include "config_file.hpp"
#include "configured.hpp"
#include "graph.hpp"
#include "interrupt.hpp"
#include "nadir/capture/pose_files.hpp"
#include "nadir/core/check.hpp"
#include "page_assets.hpp"
#include "verbs.hpp"
#include "version.hpp"

namespace nadir::app {
namespace {

using Clock = std::chrono::steady_clock;

// A page asked for under "every address" would be refused: it is nobody's name.
std::string in_url(const std::string& address) {
  if (address == "0.0.0.0" || address == "::") return "localhost";
  return address.find(':') == std::string::npos ? address : '[' + address + ']';
}

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

std::optional<GivenPoses> given_poses(const Replay& replay, const capture::Source& source) {
  if ((replay.poses || replay.colmap) && source.images().empty()) {
    throw InputError(replay.folder.string() +
                     ": poses belong to the images of a folder; take the images out of the video");
  }
  if (replay.poses) return capture::read_tum(*replay.poses, source.images());
  if (replay.colmap) return capture::read_colmap_poses(*replay.colmap, source.images());
  return std::nullopt;
}

std::string engine(const Replay& replay) {
  if (replay.poses) return "poses " + replay.poses->string();
  if (replay.colmap) return "colmap " + replay.colmap->string();
  return "odometry";
}

record::DiveInfo dive_info(const Replay& replay, const Config& config,
                           const capture::Source& source) {
  record::DiveInfo info;
  info.about = {{"input", {{"folder", replay.folder.string()}, {"images", source.size()}}},
                {"engine", engine(replay)},
                {"configuration", as_json(config)},
                {"versions", {{"nadir", kVersion}, {"opencv", CV_VERSION}}}};
  return info;
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

nlohmann::json rates(const Graph& graph, Clock::time_point begun) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {{"stages", as_json(graph.stats())},
          {"wall_s", std::chrono::duration<double>(Clock::now() - begun).count()},
          {"cpu_s", in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime)},
          {"peak_memory_mb", static_cast<double>(usage.ru_maxrss) / 1024}};
}

}  // namespace

int run(const DumpConfig& dump_config) {
  std::fputs(dump(configured(dump_config.settings)).c_str(), stdout);
  return 0;
}

int run(const Replay& replay) {
  const Config config = configured(replay.settings, replay.serve);

  // One thread per stage; more inside a stage would take cores from the others and change nothing
  // else.
  cv::setNumThreads(1);
  Interrupt interrupt;
  const Clock::time_point begun = Clock::now();
  const auto opened = capture::open_survey(replay.folder, replay.calibration, config.capture);
  capture::Source& source = *opened;
  std::optional<GivenPoses> poses = given_poses(replay, source);
  std::optional<serve::WebServer> server;
  std::optional<Publisher> page;
  if (replay.serve) {
    server.emplace(config.serve, page_assets());
    page.emplace(*server, replay.folder.filename().string(), source.size());
  }
  record::Dive dive(replay.dive, dive_info(replay, config, source), config.record);
  if (server)
    std::fprintf(stderr, "the map: http://%s:%u\n", in_url(config.serve.address).c_str(),
                 server->port());

  Progress progress(source.size(), stderr);
  Graph graph(config, replay.rate, {source, dive, page ? &*page : nullptr, progress},
              std::move(poses));
  interrupt.on_interrupt([stop = graph.stop_source()]() mutable { stop.request_stop(); });
  const std::exception_ptr fault = graph.join();
  const auto tell = [&](const Alert& alert) {
    progress.add(alert);
    if (page) page->publish(alert);
  };
  const Dropped& dropped = graph.dropped_at_end();
  for (const Alert& alert : dropped.told(dropped.last_image, dropped.last_time)) {
    dive.add(alert);
    tell(alert);
  }
  const std::vector<Alert> unwritten = dive.finish(rates(graph, begun), dropped.images);
  for (const Alert& alert : unwritten) tell(alert);
  progress.finish();
  if (fault) std::rethrow_exception(fault);
  if (page) page->finish(dropped.images);
  if (server && replay.keep_serving) interrupt.wait();
  return unwritten.empty() ? 0 : 1;
}

}  // namespace nadir::app

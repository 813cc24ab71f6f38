// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <opencv2/core/utility.hpp>

#include "config_file.hpp"
#include "configured.hpp"
#include "desk.hpp"
#include "device_token.hpp"
#include "dive_course.hpp"
#include "graph.hpp"
#include "interrupt.hpp"
#include "nadir/capture/pose_files.hpp"
#include "nadir/core/check.hpp"
#include "page_assets.hpp"
#include "verbs.hpp"

namespace nadir::app {
namespace {

std::optional<GivenPoses> given_poses(const Replay& replay, const capture::Source& source) {
  if ((replay.poses || replay.colmap) && source.images().empty()) {
    throw InputError(replay.folder.string() +
                     ": poses belong to the images of a folder; take the images out of the video");
  }
  if (replay.poses) return capture::read_tum(*replay.poses, source.images());
  if (replay.colmap) return capture::read_colmap_poses(*replay.colmap, source.images());
  return std::nullopt;
}

// The dives it shows are those beside the one it makes.
std::filesystem::path dives_of(const Replay& replay) {
  std::filesystem::path dive = std::filesystem::absolute(replay.dive).lexically_normal();
  if (!dive.has_filename()) dive = dive.parent_path();  // "dives/today/"
  return dive.parent_path();
}

std::string engine(const Replay& replay) {
  if (replay.poses) return "poses " + replay.poses->string();
  if (replay.colmap) return "colmap " + replay.colmap->string();
  return "odometry";
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
  const auto begun = std::chrono::steady_clock::now();
  const auto opened = capture::open_survey(replay.folder, replay.calibration, config.capture);
  capture::Source& source = *opened;
  std::optional<GivenPoses> poses = given_poses(replay, source);
  // Its token is good for this replay: it writes nowhere but into its dive.
  std::optional<Desk> desk;
  std::optional<serve::WebServer> server;
  std::optional<Publisher> page;
  if (replay.serve) {
    desk.emplace(dives_of(replay), new_token(), url_for_others(config.serve));
    server.emplace(config.serve, page_assets(), std::nullopt, serve::Listen::at_once,
                   desk->handlers());
    desk->serve_by(*server, config.serve.retained_bytes);
    page.emplace(server->feed(), replay.folder.filename().string(), source.size(), config,
                 &desk->live());
    page->watch_disk(replay.dive);
  }
  const nlohmann::json input{{"folder", replay.folder.string()}, {"images", source.size()}};
  record::Dive dive(replay.dive, dive_info(input, engine(replay), config), config.record);
  LiveDive* const live = desk ? &desk->live() : nullptr;
  if (live) live->begin(replay.dive);
  if (server) std::fprintf(stderr, "the map: %s\n", page_url(config.serve, server->port()).c_str());

  Progress progress(source.size(), stderr);
  const auto next = [&](const std::stop_token&) -> std::optional<capture::Captured> {
    std::optional<Shot> shot = source.next();
    return shot ? std::optional(capture::Captured{std::move(shot), {}}) : std::nullopt;
  };
  Graph graph(config, replay.rate,
              {next, source.lasers(), {}, dive, page ? &*page : nullptr, progress, live},
              std::move(poses));
  interrupt.on_interrupt([stop = graph.stop_source()]() mutable { stop.request_stop(); });
  const int status = finish_dive({graph, dive, page ? &*page : nullptr, progress, begun, live});
  if (server && replay.keep_serving) interrupt.wait();
  return status;
}

}  // namespace nadir::app

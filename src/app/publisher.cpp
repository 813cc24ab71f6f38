// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "publisher.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "nadir/image_io/encode.hpp"

namespace nadir::app {
namespace {

constexpr int kLiveWidth = 640;  // px; a tablet shows the live image in a corner
constexpr int kLiveQuality = 75;
constexpr auto kLivePeriod = std::chrono::milliseconds(100);  // machine.md: image 10 Hz
constexpr auto kRatePeriod = std::chrono::seconds(10);
constexpr int kGridQuality = 85;  // 150 x 100 cells: 5 to 8 kB, of at most 10 kB an image
constexpr int kTileQuality = 92;  // within 8 grey levels of the mosaic file

wire::MosaicTile encoded(const Tile& tile) {
  cv::Mat bgr, alpha;
  cv::cvtColor(tile.bgra, bgr, cv::COLOR_BGRA2BGR);
  cv::extractChannel(tile.bgra, alpha, 3);
  wire::MosaicTile record{tile.mosaic,
                          tile.column,
                          tile.row,
                          image_io::encode_jpeg(bgr, kTileQuality, image_io::Chroma::full),
                          {}};
  if (cv::countNonZero(alpha < 255) > 0) record.mask_png = image_io::encode_png(alpha);
  return record;
}

wire::CameraInfo camera_info(const CameraModel& camera) {
  return {static_cast<std::uint32_t>(camera.width),
          static_cast<std::uint32_t>(camera.height),
          camera.fx,
          camera.fy,
          camera.cx,
          camera.cy};
}

}  // namespace

Publisher::Publisher(serve::WebServer& server, std::string input, std::uint64_t images_total)
    : server_(server) {
  state_.input = std::move(input);
  state_.images_total = images_total;
  send_state();
}

template <class Record>
void Publisher::send(serve::Lane lane, const Record& record) {
  server_.publish(lane, wire::key(record), wire::encode(record));
}

void Publisher::send_state() {
  const Clock::time_point now = Clock::now();
  recent_.emplace_back(now, state_.captured);
  while (recent_.size() > 2 && now - recent_[1].first > kRatePeriod) recent_.pop_front();
  const auto& [since, captured] = recent_.front();
  const double elapsed = std::chrono::duration<double>(now - since).count();
  state_.rate_hz = elapsed > 0 ? static_cast<double>(state_.captured - captured) / elapsed : 0;
  send(serve::Lane::state, state_);
}

void Publisher::publish(const Orientation& orientation) {
  if (const Shot* shot = orientation.shot.get()) {
    state_.captured = shot->image + 1;
    state_.dropped += shot->dropped_before + (shot->frame ? 0 : 1);
    state_.image = shot->image;
    state_.time = shot->time;
    for (const Alert& alert : shot->alerts) publish(alert);
    if (shot->frame) send_live_image(*shot->frame);
  }
  for (const Alert& alert : orientation.alerts) publish(alert);
  for (const ImagePose& pose : orientation.poses) {
    oriented_.insert(pose.image);
    send(serve::Lane::data, pose);
  }
  if (orientation.window) {
    for (const wire::TiePoints& block :
         tie_points_.update(orientation.window->tie_points, orientation.window->given_up)) {
      send(serve::Lane::data, block);
    }
    state_.scale = orientation.window->scale;
    state_.axes = orientation.window->axes;
    ++state_.windows;
  }
  state_.tracking = orientation.state;
  state_.submap = orientation.submap;
  state_.oriented = oriented_.size();
  state_.lost += orientation.lost.size();
  state_.tie_points = tie_points_.size();
  send_state();
}

void Publisher::send_live_image(const Frame& frame) {
  if (!camera_sent_) send(serve::Lane::state, camera_info(frame.rig->left));
  camera_sent_ = true;
  const Clock::time_point now = Clock::now();
  if (now - live_sent_ < kLivePeriod) return;
  live_sent_ = now;
  cv::Mat small = frame.colour;
  if (frame.colour.cols > kLiveWidth) {
    const double ratio = static_cast<double>(kLiveWidth) / frame.colour.cols;
    cv::resize(frame.colour, small, {}, ratio, ratio, cv::INTER_AREA);
  }
  send(serve::Lane::live,
       wire::LiveImage{frame.image, frame.time, image_io::encode_jpeg(small, kLiveQuality)});
}

void Publisher::publish(const Surface& surface) {
  for (const Alert& alert : surface.alerts) publish(alert);
}

void Publisher::publish(const Cloud& cloud) {
  for (const Alert& alert : cloud.alerts) publish(alert);
  if (!cloud.grid) return;
  send(serve::Lane::data, wire::plane_grid(*cloud.grid));
  send(serve::Lane::data,
       wire::PlaneColour{cloud.grid->image, image_io::encode_jpeg(cloud.grid->bgr, kGridQuality)});
  ++state_.planes;
  send_state();
}

void Publisher::publish(const MosaicUpdate& mosaic) {
  for (const Alert& alert : mosaic.alerts) publish(alert);
  if (!mosaic.grid) return;
  if (mosaics_.insert(mosaic.grid->mosaic).second) send(serve::Lane::state, *mosaic.grid);
  for (const auto& tile : mosaic.tiles) {
    tiles_.insert({tile->mosaic, tile->column, tile->row});
    send(serve::Lane::data, encoded(*tile));
  }
  state_.mosaic_tiles = tiles_.size();
  send_state();
}

void Publisher::publish(const Alert& alert) {
  send(serve::Lane::state, wire::AlertRecord{alerts_++, alert});
}

void Publisher::publish(const std::vector<StageStats>& stages) {
  send(serve::Lane::state, wire::Statistics{stages});
}

void Publisher::finish(std::uint32_t dropped_at_end) {
  state_.captured += dropped_at_end;
  state_.dropped += dropped_at_end;
  state_.finished = true;
  send_state();
}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "publisher.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "nadir/image_io/encode.hpp"
#include "nadir/mosaic2d/corrected.hpp"

namespace nadir::app {
namespace {

constexpr int kLiveWidth = 640;  // px; a tablet shows the live image in a corner
constexpr int kLiveQuality = 75;
constexpr int kThinLiveWidth = 320, kThinLiveQuality = 50;
constexpr std::size_t kMostTiePoints = 1000;
constexpr auto kLivePeriod = std::chrono::milliseconds(100);  // machine.md: image 10 Hz
constexpr auto kSlowLivePeriod = std::chrono::milliseconds(500);
constexpr auto kRatePeriod = std::chrono::seconds(10);
constexpr int kGridQuality = 85;      // 150 x 100 cells: 5 to 8 kB, of at most 10 kB an image
constexpr int kTileQuality = 85;      // within 8 grey levels of the mosaic file
constexpr int kOverviewQuality = 80;  // to look at only

// Overviews change with every image: more of them would keep planes from thin links.
constexpr auto kOverviewPeriod = std::chrono::seconds(1);
constexpr std::size_t kMostOverviews = 2;

template <class Record>
Record encoded(const Tile& tile, int quality) {
  cv::Mat bgr, alpha;
  cv::cvtColor(tile.bgra, bgr, cv::COLOR_BGRA2BGR);
  cv::extractChannel(tile.bgra, alpha, 3);
  Record record{tile.mosaic, tile.column, tile.row, image_io::encode_jpeg(bgr, quality), {}};
  if (cv::countNonZero(alpha < 255) > 0) record.mask_png = image_io::encode_png(alpha);
  return record;
}

using TiePointPlaces = std::vector<std::array<std::uint16_t, 2>>;
const TiePointPlaces kNoTiePoints;

/// Those of the window that the shot's image shows; none when it has no pose.
TiePointPlaces tie_points_in(const Orientation& orientation, const Window& window) {
  const Frame& frame = *orientation.shot->frame;
  if (!frame.rig) return {};
  const auto pose = std::find_if(orientation.poses.begin(), orientation.poses.end(),
                                 [&](const ImagePose& p) { return p.image == frame.image; });
  if (pose == orientation.poses.end()) return {};
  const Rigid3 camera_from_survey = pose->survey_from_camera.inverse();
  const CameraModel& camera = frame.rig->left;
  const Eigen::Vector2d size(camera.width, camera.height);
  TiePointPlaces places;
  for (const TiePoint& point : window.tie_points) {
    const auto pixel = camera.project(camera_from_survey * point.x_in_survey);
    if (!pixel) continue;
    const Eigen::Array2d share = (*pixel + Eigen::Vector2d(0.5, 0.5)).cwiseQuotient(size);
    if ((share < 0).any() || (share > 1).any()) continue;
    const auto place = [](double part) { return static_cast<std::uint16_t>(65535 * part); };
    places.push_back({place(share.x()), place(share.y())});
    if (places.size() == kMostTiePoints) break;
  }
  return places;
}

cv::Mat at_most(int width, const cv::Mat& image) {
  if (image.cols <= width) return image;
  cv::Mat small;
  const double ratio = static_cast<double>(width) / image.cols;
  cv::resize(image, small, {}, ratio, ratio, cv::INTER_AREA);
  return small;
}

/// The newest image that the window, which has tie points, was adjusted with.
std::uint64_t newest_of(const Window& window, const Orientation& orientation) {
  if (!window.images.empty()) return window.images.back().image;
  // A recorded one has no images, but they are among those that were oriented with it.
  std::uint64_t newest = orientation.shot ? orientation.shot->image : 0;
  for (const ImagePose& pose : orientation.poses) {
    if (pose.key_frame) newest = pose.image;
  }
  return newest;
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

Publisher::Publisher(std::shared_ptr<serve::Feed> feed, std::string input,
                     std::uint64_t images_total, const Config& config, LiveDive* live)
    : feed_(std::move(feed)), live_(live), guide_(config) {
  state_.input = std::move(input);
  state_.images_total = images_total;
  send_state();
  if (!live_) return;
  live_->tell([this](const wire::Recording& recording) { send(serve::Lane::state, recording); });
}

Publisher::Publisher(std::shared_ptr<serve::Feed> feed, RecordedDive dive)
    : feed_(std::move(feed)), live_(nullptr), guide_({}), recorded_(wire::Recording{}) {
  recorded_->phase = wire::Phase::ended;
  recorded_->name = dive.name;
  send(serve::Lane::state, *recorded_);
  state_.input = std::move(dive.name);
  send_state();
}

Publisher::~Publisher() {
  if (live_) live_->tell({});
}

template <class Record>
void Publisher::send(serve::Lane lane, const Record& record) {
  feed_->publish(lane, wire::key(record), wire::encode(record));
}

void Publisher::send_state() {
  const Clock::time_point now = Clock::now();
  recent_.emplace_back(now, state_.captured);
  while (recent_.size() > 2 && now - recent_[1].first > kRatePeriod) recent_.pop_front();
  const auto& [since, captured] = recent_.front();
  const double elapsed = std::chrono::duration<double>(now - since).count();
  if (!recorded_)
    state_.rate_hz = elapsed > 0 ? static_cast<double>(state_.captured - captured) / elapsed : 0;
  send(serve::Lane::state, state_);
}

void Publisher::send(Guide::Told told) {
  if (recorded_) {
    told.measures.reset();
    told.last_view.reset();
    told.way_back.reset();
    if (told.guidance) told.guidance->gaps.clear();
  }
  for (const wire::CoverageTile& tile : told.tiles) send(serve::Lane::data, tile);
  if (told.guidance) send(serve::Lane::state, *told.guidance);
  if (told.measures) send(serve::Lane::state, *told.measures);
  if (told.last_view) send(serve::Lane::prompt, *told.last_view);
  if (told.way_back) send(serve::Lane::state, *told.way_back);
}

void Publisher::publish(const Orientation& orientation) {
  if (orientation.window) window_ = orientation.window;
  std::optional<wire::LiveImage> live;
  if (const Shot* shot = orientation.shot.get()) {
    state_.captured = shot->image + 1;
    state_.dropped += shot->dropped_before + shot->missed_before + (shot->frame ? 0 : 1);
    state_.image = shot->image;
    state_.time = shot->time;
    if (recorded_) count_recorded(*shot);
    for (const Alert& alert : shot->alerts) publish(alert);
    // A recorded dive has no pixels.
    if (shot->frame && !shot->frame->colour.empty()) live = send_live_image(orientation);
  }
  for (const Alert& alert : orientation.alerts) publish(alert);
  for (const ImagePose& pose : orientation.poses) {
    poses_[pose.image] = pose;
    send_corrected(pose);
  }
  if (orientation.window) {
    for (const wire::TiePoints& block :
         tie_points_.update(orientation.window->tie_points, orientation.window->given_up)) {
      seen_[block.block] = {orientation.window->submap,
                            newest_of(*orientation.window, orientation)};
      send_corrected(block);
    }
    const auto corrected = scales_.find(orientation.window->submap);
    state_.scale = corrected == scales_.end() ? orientation.window->scale : corrected->second;
    if (orientation.axes == SurveyAxes::none) state_.axes = orientation.window->axes;
    ++state_.windows;
  }
  if (orientation.axes != SurveyAxes::none) state_.axes = orientation.axes;
  state_.tracking = orientation.state;
  state_.submap = orientation.submap;
  state_.oriented = poses_.size();
  state_.lost += orientation.lost.size();
  state_.tie_points = tie_points_.size();
  send_state();
  guide_.observe(orientation, live ? &*live : nullptr);
  send(guide_.tell(Clock::now()));
  send_overviews_in_time();
}

void Publisher::count_recorded(const Shot& shot) {
  if (recorded_->saved++ == 0) recorded_->began = shot.time;
  send(serve::Lane::state, *recorded_);
}

// None when the last was sent just now.
std::optional<wire::LiveImage> Publisher::send_live_image(const Orientation& orientation) {
  const Frame& frame = *orientation.shot->frame;
  if (!camera_sent_ && frame.rig) {
    send(serve::Lane::state, camera_info(frame.rig->left));
    camera_sent_ = true;
  }
  const Clock::time_point now = Clock::now();
  if (now - live_sent_ < (slow_ ? kSlowLivePeriod : kLivePeriod)) return std::nullopt;
  live_sent_ = now;
  const cv::Mat small = at_most(kLiveWidth, frame.colour);
  wire::LiveImage live{frame.image, frame.time, image_io::encode_jpeg(small, kLiveQuality),
                       window_ ? tie_points_in(orientation, *window_) : kNoTiePoints};
  send(serve::Lane::live, live);
  wire::LiveImage thin = live;
  thin.jpeg = image_io::encode_jpeg(at_most(kThinLiveWidth, small), kThinLiveQuality);
  send(serve::Lane::thin_live, thin);
  return live;
}

void Publisher::publish(const Surface& surface) {
  for (const Alert& alert : surface.alerts) publish(alert);
}

void Publisher::publish(const Cloud& cloud) {
  for (const Alert& alert : cloud.alerts) publish(alert);
  if (!cloud.grid) return;
  grids_[cloud.grid->image] = wire::plane_grid(*cloud.grid);
  send_corrected(grids_[cloud.grid->image]);
  send(serve::Lane::prompt,
       wire::PlaneColour{cloud.grid->image, image_io::encode_jpeg(cloud.grid->bgr, kGridQuality)});
  ++state_.planes;
  send_state();
  guide_.observe(cloud);
  send(guide_.tell(Clock::now()));
}

void Publisher::publish(const MosaicUpdate& mosaic) {
  for (const Alert& alert : mosaic.alerts) publish(alert);
  if (!mosaic.grid) return;
  const std::uint64_t image = mosaic.projected ? mosaic.projected->image : 0;
  const auto [known, is_new] =
      mosaics_.try_emplace(mosaic.grid->mosaic, std::pair(*mosaic.grid, image));
  if (is_new) send_corrected(known->second.first, image);
  send_tiles(mosaic.tiles);
}

void Publisher::publish_corrected(const MosaicGrid& grid,
                                  const std::vector<std::shared_ptr<const Tile>>& tiles) {
  if (mosaics_.try_emplace(grid.mosaic, grid, 0).second) send(serve::Lane::state, grid);
  send_tiles(tiles);
}

void Publisher::send_tiles(const std::vector<std::shared_ptr<const Tile>>& tiles) {
  for (const auto& tile : tiles) {
    tiles_.insert({tile->mosaic, tile->column, tile->row});
    send(serve::Lane::data, encoded<wire::MosaicTile>(*tile, kTileQuality));
    overviews_.add(*tile);
  }
  state_.mosaic_tiles = tiles_.size();
  send_state();
  send_overviews_in_time();
}

void Publisher::send_overviews_in_time() {
  const Clock::time_point now = Clock::now();
  if (now - overviews_sent_ < kOverviewPeriod) return;
  overviews_sent_ = now;
  send_overviews(kMostOverviews);
}

void Publisher::send_overviews(std::size_t most) {
  for (const Tile& overview : overviews_.take(most)) {
    send(serve::Lane::prompt, encoded<wire::MosaicOverview>(overview, kOverviewQuality));
  }
}

void Publisher::send_corrected(const ImagePose& pose) {
  ImagePose corrected = pose;
  corrected.survey_from_camera = corrections_.at(pose.submap, pose.image) * pose.survey_from_camera;
  send(serve::Lane::prompt, corrected);
}

void Publisher::send_corrected(wire::PlaneGrid grid) {
  const Similarity3 correction = corrections_.at(grid.submap, grid.image);
  Eigen::Matrix4d by = Eigen::Matrix4d::Identity();
  by.topLeftCorner<3, 3>() = correction.scale * correction.rigid.rotation.toRotationMatrix();
  by.topRightCorner<3, 1>() = correction.rigid.translation;
  grid.survey_from_grid = by * grid.survey_from_grid;
  grid.camera_in_survey = correction * grid.camera_in_survey;
  grid.max_range *= correction.scale;
  send(serve::Lane::prompt, grid);
}

void Publisher::send_corrected(const wire::TiePoints& block) {
  const Seen& seen = seen_.at(block.block);
  const Similarity3 correction = corrections_.at(seen.submap, seen.image);
  wire::TiePoints corrected = block;
  corrected.origin = correction * block.origin;
  for (auto& point : corrected.points) {
    const Eigen::Map<const Eigen::Vector3f> offset(point.offset.data());
    const Eigen::Vector3f turned =
        (correction.scale * (correction.rigid.rotation * offset.cast<double>())).cast<float>();
    point.offset = {turned.x(), turned.y(), turned.z()};
  }
  send(serve::Lane::data, corrected);
}

void Publisher::send_corrected(const MosaicGrid& grid, std::uint64_t first_image) {
  send(serve::Lane::state, mosaic2d::moved(grid, corrections_.at(grid.submap, first_image)));
}

void Publisher::publish(const Revision& revision) {
  for (const Alert& alert : revision.alerts) publish(alert);
  for (const auto& [submap, scale] : revision.scales) {
    scales_[submap] = scale;
    if (submap == state_.submap) state_.scale = scale;
  }
  if (!revision.scales.empty()) send_state();
  guide_.observe(revision);
  if (revision.corrections.empty()) return;
  std::set<std::uint64_t> moved;  // key frames
  for (const Correction& correction : revision.corrections) {
    corrections_.add(correction);
    moved.insert(correction.image);
  }
  const auto is_moved = [&](std::uint32_t submap, std::uint64_t image) {
    const auto key_frame = corrections_.key_frame_of(submap, image);
    return key_frame && moved.contains(*key_frame);
  };
  for (const auto& [image, pose] : poses_) {
    if (is_moved(pose.submap, image)) send_corrected(pose);
  }
  for (const auto& [image, grid] : grids_) {
    if (is_moved(grid.submap, image)) send_corrected(grid);
  }
  for (const auto& [number, block] : tie_points_.blocks()) {
    const Seen& seen = seen_.at(number);
    if (is_moved(seen.submap, seen.image)) send_corrected(block);
  }
  for (const auto& [id, mark] : marks_) {
    const auto pose = mark.image ? poses_.find(*mark.image) : poses_.end();
    if (pose != poses_.end() && is_moved(pose->second.submap, pose->first)) send_corrected(mark);
  }
  for (const auto& [number, mosaic] : mosaics_) {
    if (is_moved(mosaic.first.submap, mosaic.second)) {
      send_corrected(mosaic.first, mosaic.second);
    }
  }
}

void Publisher::publish(const Alert& alert) {
  send(serve::Lane::state, wire::AlertRecord{alerts_++, alert});
}

void Publisher::publish(const Mark& mark) {
  Mark as_put = mark;
  const auto pose = mark.image ? poses_.find(*mark.image) : poses_.end();
  if (pose != poses_.end()) {
    as_put.position = corrections_.at(pose->second.submap, *mark.image).inverse() * mark.position;
  }
  if (mark.removed) {
    marks_.erase(mark.id);
  } else {
    marks_[mark.id] = as_put;
  }
  send_corrected(as_put);
}

void Publisher::send_corrected(Mark mark) {
  const auto pose = mark.image ? poses_.find(*mark.image) : poses_.end();
  if (pose != poses_.end()) {
    mark.position = corrections_.at(pose->second.submap, *mark.image) * mark.position;
  }
  send(serve::Lane::state, mark);
}

void Publisher::publish(const wire::Check& check) { send(serve::Lane::state, check); }

void Publisher::publish(const std::vector<StageStats>& stages) {
  send(serve::Lane::state, wire::Statistics{stages});
  send_overviews_in_time();
}

void Publisher::finish(std::uint64_t dropped_at_end) {
  state_.captured += dropped_at_end;
  state_.dropped += dropped_at_end;
  state_.finished = true;
  send(guide_.finish());
  send_overviews(std::numeric_limits<std::size_t>::max());
  send_state();
}

void Publisher::finish_recorded(std::uint64_t captured) {
  // A server short of memory lets go the oldest: of a long dive rather colours than its path.
  for (const auto& [image, pose] : poses_) send_corrected(pose);
  state_.images_total = captured;
  finish(captured - std::min(captured, state_.captured));
}

}  // namespace nadir::app

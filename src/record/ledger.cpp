// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "ledger.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "nadir/core/check.hpp"
#include "nadir/mosaic2d/corrected.hpp"

namespace nadir::record {
namespace {

void add_pose(const ImagePose& pose, Ledger& ledger) {
  ImageFacts& image = ledger.images[pose.image];
  if (!image.live) image.live = pose;
  image.final = pose;
}

void add_shot(const Facts& facts, Ledger& ledger) {
  ImageFacts& image = ledger.images[facts.image];
  image.recorded = true;
  image.rejected = facts.rejected;
  image.time = facts.time;
  image.name = facts.name;
  image.state = facts.state;
  image.submap = facts.submap;
  image.health = facts.health;
  image.dead_reckoned = facts.dead_reckoned;
  ledger.queue_full += facts.dropped_before;
  ledger.camera += facts.missed_before;
}

void add_orientation(const Facts& facts, Ledger& ledger) {
  for (const ImagePose& pose : facts.poses) add_pose(pose, ledger);
  for (const ImageHealth& later : facts.later_health) {
    ledger.images[later.image].health = later.health;
  }
  for (const std::uint64_t lost : facts.lost) ledger.images[lost].final.reset();
}

void add_window(const WindowFacts& window, std::uint64_t sequence, Ledger& ledger) {
  ++ledger.windows;
  if (ledger.axes == SurveyAxes::none) ledger.axes = window.axes;
  ledger.live_scales[window.submap] = window.scale;
  if (window.uncertain) ledger.uncertain.insert(window.submap);
  for (const TiePoint& point : window.tie_points) {
    ledger.tie_points[point.id] = sequence;
    ledger.farthest = std::max(ledger.farthest, point.x_in_survey.cwiseAbs().maxCoeff());
  }
  for (const std::uint64_t id : window.given_up) ledger.tie_points.erase(id);
}

void add_grid(const Grid& grid, Ledger& ledger) {
  ++ledger.planes;
  for (const CloudPoint& point : grid.points()) {
    ++ledger.grid_points;
    ledger.farthest = std::max(ledger.farthest, point.x_in_survey.cwiseAbs().maxCoeff());
  }
}

void add_revision(const Facts& facts, Ledger& ledger) {
  for (const Correction& correction : facts.corrections) ledger.corrections.add(correction);
  for (const Join& join : facts.joins) ledger.joined[join.submap] = join.to;
  for (const auto& [submap, scale] : facts.scales) ledger.corrected_scales[submap] = scale;
}

void add_facts(const Facts& facts, std::uint64_t sequence, Ledger& ledger) {
  if (facts.of_shot) add_shot(facts, ledger);
  add_orientation(facts, ledger);
  if (facts.window) add_window(*facts.window, sequence, ledger);
  if (facts.axes != SurveyAxes::none) ledger.axes = facts.axes;
  if (facts.grid) add_grid(*facts.grid, ledger);
  if (facts.mosaic) {
    ledger.mosaics.emplace(facts.mosaic->mosaic, *facts.mosaic);
    ledger.mosaic_seen_first.try_emplace(facts.mosaic->mosaic,
                                         facts.grid ? facts.grid->image : facts.image);
  }
  if (facts.projected && facts.mosaic && facts.plane) {
    ledger.projected.push_back({*facts.projected, facts.mosaic->submap, *facts.plane});
    ledger.mosaic_first_image.try_emplace(facts.mosaic->mosaic, facts.projected->image);
  }
  if (facts.mosaic && !facts.tiles.empty() && !facts.projected) {
    ++ledger.unsaved[facts.mosaic->mosaic];
  }
  ledger.tiles.insert(facts.tiles.begin(), facts.tiles.end());
  ledger.alerts.insert(ledger.alerts.end(), facts.alerts.begin(), facts.alerts.end());
  add_revision(facts, ledger);
}

// It was put where the ground was as corrected then; from there on it moves as its image does.
void add_mark(const Mark& mark, Ledger& ledger) {
  MarkFacts facts{mark, {}};
  const auto image = mark.image ? ledger.images.find(*mark.image) : ledger.images.end();
  if (image != ledger.images.end() && image->second.final) {
    facts.submap = image->second.final->submap;
    facts.mark.position =
        ledger.corrections.at(*facts.submap, *mark.image).inverse() * mark.position;
  }
  if (mark.removed) {
    ledger.marks.erase(mark.id);
  } else {
    ledger.marks[mark.id] = facts;
  }
}

std::optional<reference::Geodetic> origin_of(const nlohmann::json& about) {
  try {
    const nlohmann::json& origin = about.at("origin");
    return reference::Geodetic{origin.at("latitude_deg"), origin.at("longitude_deg"),
                               origin.at("height_m")};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

bool add_begin(const Bytes& payload, Ledger& ledger) {
  std::string about;
  Decoder decoder(payload);
  decoder(about);
  ledger.about = nlohmann::json::parse(about, nullptr, false);
  ledger.origin = origin_of(ledger.about);
  return decoder.ended() && ledger.about.is_object();
}

bool add_end(const Bytes& payload, Ledger& ledger) {
  std::uint64_t dropped_after = 0;
  Decoder decoder(payload);
  decoder(ledger.captured, dropped_after);
  ledger.queue_full += dropped_after;
  return ledger.ended = decoder.ended();
}

// False when the record does not hold what its type says.
bool add_record(const Record& record, Ledger& ledger) {
  switch (record.type) {
    case RecordType::begin:
      return add_begin(record.payload, ledger);
    case RecordType::end:
      return add_end(record.payload, ledger);
    case RecordType::shot: {
      const auto facts = decode_facts(record.payload, false);
      if (facts) add_facts(*facts, record.sequence, ledger);
      return facts.has_value();
    }
    case RecordType::alert: {
      const auto alert = decode_alert(record.payload);
      if (alert) ledger.alerts.push_back(*alert);
      return alert.has_value();
    }
    case RecordType::mark: {
      const auto mark = decode_mark(record.payload);
      if (mark) add_mark(*mark, ledger);
      return mark.has_value();
    }
  }
  return false;
}

// The one it was joined to at last.
std::uint32_t root_of(std::uint32_t submap, const Ledger& ledger) {
  while (ledger.joined.contains(submap)) submap = ledger.joined.at(submap);
  return submap;
}

bool is_less_certain(const Scale& a, const Scale& b) {
  const bool a_known = a.source != ScaleSource::none, b_known = b.source != ScaleSource::none;
  return a_known != b_known ? b_known : a.sigma > b.sigma;
}

// A sub-map is as certain as the one it was joined to, and both have one size: that of a pair among
// them, or of a measure that the map was made to fit. Any other of a member went when it joined.
void take_from_joined(Ledger& ledger) {
  const std::set<std::uint32_t> uncertain = ledger.uncertain;
  std::map<std::uint32_t, Scale> of_map;  // by root
  for (const auto& [submap, scale] : ledger.scales) {
    const bool is_kept = submap == root_of(submap, ledger) ||
                         ledger.corrected_scales.contains(submap) ||
                         scale.source == ScaleSource::stereo;
    if (!is_kept) continue;
    const auto [found, is_first] = of_map.try_emplace(root_of(submap, ledger), scale);
    if (!is_first && is_less_certain(found->second, scale)) found->second = scale;
  }
  const auto take = [&](std::uint32_t submap, std::uint32_t root) {
    const auto scale = of_map.find(root);
    if (scale == of_map.end()) return;
    Scale& own = ledger.scales[submap];
    if (own.source == ScaleSource::none) own = scale->second;
  };
  for (const auto& [submap, to] : ledger.joined) {
    const std::uint32_t root = root_of(to, ledger);
    if (!uncertain.contains(root)) ledger.uncertain.erase(submap);
    take(submap, root);
    take(root, root);
  }
}

void correct(Ledger& ledger) {
  ledger.scales = ledger.live_scales;
  for (const auto& [submap, scale] : ledger.corrected_scales) ledger.scales[submap] = scale;
  take_from_joined(ledger);
  if (ledger.corrections.empty()) return;
  double farthest = ledger.farthest;
  for (auto& [number, image] : ledger.images) {
    if (image.dead_reckoned) {
      DeadReckoned& place = *image.dead_reckoned;
      const Similarity3 correction = ledger.corrections.at(place.submap, number);
      place.survey_from_camera = correction * place.survey_from_camera;
      place.sigma_position *= correction.scale;
    }
    if (!image.final) continue;
    ImagePose& pose = *image.final;
    const Similarity3 correction = ledger.corrections.at(pose.submap, number);
    pose.survey_from_camera = correction * pose.survey_from_camera;
    pose.sigma_position *= correction.scale;
    farthest = std::max(farthest, correction.scale * std::numbers::sqrt3 * ledger.farthest +
                                      correction.rigid.translation.norm());
  }
  ledger.farthest = farthest;
  for (auto& [id, facts] : ledger.marks) {
    if (!facts.submap) continue;
    facts.mark.position =
        ledger.corrections.at(*facts.submap, *facts.mark.image) * facts.mark.position;
  }
  for (ProjectedFacts& projected : ledger.projected) {
    ProjectedFile& file = projected.file;
    file.world = mosaic2d::moved(file.world, projected.plane,
                                 ledger.corrections.at(projected.submap, file.image));
  }
  for (auto& [number, grid] : ledger.mosaics) {
    grid = mosaic2d::moved(grid,
                           ledger.corrections.at(grid.submap, ledger.mosaic_seen_first.at(number)));
  }
}

Scale least_certain(const std::map<std::uint32_t, Scale>& scales) {
  Scale least;
  bool first = true;
  for (const auto& [submap, scale] : scales) {
    if (std::exchange(first, false) || is_less_certain(scale, least)) least = scale;
  }
  return least;
}

}  // namespace

ImageCounts Ledger::counts() const {
  ImageCounts counts;
  for (const auto& [number, image] : images) {
    if (image.final) {
      ++counts.oriented;
    } else if (image.rejected) {
      ++counts.image_rejected;
    } else if (image.recorded) {
      ++counts.lost;
    }
  }
  const std::uint64_t told = counts.oriented + counts.lost + counts.image_rejected;
  const std::uint64_t last = images.empty() ? 0 : images.rbegin()->first + 1;
  counts.captured = std::max({captured, last, told});
  counts.queue_full = std::min(queue_full, counts.captured - told);
  counts.camera = std::min(camera, counts.captured - told - counts.queue_full);
  counts.storage = counts.captured - told - counts.queue_full - counts.camera;
  return counts;
}

Scale Ledger::scale() const { return least_certain(scales); }
Scale Ledger::live_scale() const { return least_certain(live_scales); }

Ledger read_ledger(const path& dive, const std::stop_token& stop) {
  JournalReader journal(dive);
  Ledger ledger;
  ledger.about = nlohmann::json::object();
  std::uint64_t records = 0, unreadable = 0;
  for (; !stop.stop_requested(); ++records) {
    const auto record = journal.next();
    if (!record) break;
    if (!add_record(*record, ledger)) ++unreadable;
  }
  if (records == unreadable && !stop.stop_requested()) {
    throw InputError(dive.string() +
                     ": no whole record in its journal: the recording was cut off as it began, or "
                     "the journal was damaged since; nothing can be made from it, and the files "
                     "that are there were left as they are");
  }
  ledger.missing_records = journal.missing() + unreadable;
  correct(ledger);
  const bool is_placed =
      ledger.axes == SurveyAxes::attitude && ledger.scale().source != ScaleSource::none;
  if (ledger.origin && is_placed) ledger.grid.emplace(*ledger.origin);
  return ledger;
}

nlohmann::json begin_facts(const DiveInfo& info) {
  nlohmann::json about = info.about;
  if (const auto& origin = info.origin) {
    about["origin"] = {{"latitude_deg", origin->latitude_deg},
                       {"longitude_deg", origin->longitude_deg},
                       {"height_m", origin->height}};
  }
  return about;
}

Bytes encode_begin(const nlohmann::json& about) {
  Encoder encoder;
  encoder(about.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  return encoder.take();
}

Bytes encode_end(std::uint64_t captured, std::uint64_t dropped_after) {
  Encoder encoder;
  encoder(captured, dropped_after);
  return encoder.take();
}

}  // namespace nadir::record

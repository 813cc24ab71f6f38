// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What is known better afterwards: corrections of what odometry said, without its pixels again.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "nadir/core/alert.hpp"
#include "nadir/core/key_frame.hpp"
#include "nadir/core/rigid3.hpp"

namespace nadir {

/// Moves all that was made of a key frame, and of the images after it up to the next.
struct Correction {
  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  Similarity3 corrected_from_live;  ///< survey frame as corrected, as odometry left it
};

/// Two sub-maps were found to show the same ground.
struct Join {
  std::uint32_t submap = 0, to = 0;      ///< the later one now lies in the frame of the earlier
  std::uint64_t image = 0, seen_by = 0;  ///< images that prove it, of `submap` and of `to`
};

/// What is known by now of a sub-map's size.
struct ScaleEstimate {
  std::uint32_t submap = 0;
  double ratio = 1;  ///< metres per survey unit as odometry left it
  Scale scale;       ///< of ratio
};

/// What odometry settled with one shot; without an image: after the last.
struct Settlement {
  std::optional<std::uint64_t> image;
  Time time = 0;
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  std::vector<ScaleEstimate> scales;  ///< that have become better
};

/// Exactly one per settlement, in order; mostly without content.
struct Revision {
  std::optional<std::uint64_t> image;
  std::vector<Correction> corrections;  ///< those that changed, by image
  std::vector<Join> joins;
  std::vector<std::pair<std::uint32_t, Scale>> scales;  ///< of sub-maps, as corrected
  std::vector<Alert> alerts;
};

/// The newest correction of every key frame.
class Corrections {
 public:
  void add(const Correction& correction) {
    by_submap_[correction.submap][correction.image] = correction.corrected_from_live;
  }
  bool empty() const { return by_submap_.empty(); }

  /// Of an image: its key frame's, which is the last one up to it; else the sub-map's first.
  Similarity3 at(std::uint32_t submap, std::uint64_t image) const {
    const auto* found = find(submap, image);
    return found ? found->second : Similarity3();
  }

  /// The key frame whose correction an image follows.
  std::optional<std::uint64_t> key_frame_of(std::uint32_t submap, std::uint64_t image) const {
    const auto* found = find(submap, image);
    return found ? std::optional(found->first) : std::nullopt;
  }

 private:
  const std::pair<const std::uint64_t, Similarity3>* find(std::uint32_t submap,
                                                          std::uint64_t image) const {
    const auto of_submap = by_submap_.find(submap);
    if (of_submap == by_submap_.end()) return nullptr;
    auto next = of_submap->second.upper_bound(image);
    if (next != of_submap->second.begin()) --next;
    return &*next;
  }

  std::map<std::uint32_t, std::map<std::uint64_t, Similarity3>> by_submap_;
};

}  // namespace nadir

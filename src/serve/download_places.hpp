// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How many downloads are served at a time: who takes many slowly leaves room for another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>

namespace nadir::serve {

class DownloadPlaces {
 public:
  static constexpr std::size_t kMost = 16, kMostOfOne = 8;
  /// What is no larger, a photograph, needs no place.
  static constexpr std::uint64_t kSmall = 1 << 20;

  /// A place while it lives, unless there was none.
  class Taken {
   public:
    Taken(DownloadPlaces& places, std::string caller, std::uint64_t size)
        : places_(places),
          needed_(size > kSmall),
          held_(needed_ && places.have_room_for(caller)),
          caller_(std::move(caller)) {
      if (held_) places_.callers_.insert(caller_);
    }
    Taken(const Taken&) = delete;
    Taken& operator=(const Taken&) = delete;
    ~Taken() {
      if (held_) places_.callers_.erase(places_.callers_.find(caller_));
    }
    bool granted() const { return held_ || !needed_; }

   private:
    DownloadPlaces& places_;
    const bool needed_, held_;
    const std::string caller_;
  };

 private:
  bool have_room_for(const std::string& caller) const {
    return callers_.size() < kMost && callers_.count(caller) < kMostOfOne;
  }

  std::multiset<std::string> callers_;
};

}  // namespace nadir::serve

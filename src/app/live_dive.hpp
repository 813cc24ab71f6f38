// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The dive that is recorded now, between the threads that record it and the pages that watch and
// command.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "nadir/core/mark.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::app {

/// Any thread.
class LiveDive {
 public:
  /// Tells the pages where the recording stands, whenever that changes; empty: nobody.
  using Tell = std::function<void(const wire::Recording&)>;
  void tell(Tell tell);

  /// Another dive will begin: what the last one was is of no interest any more.
  void prepare();
  /// A dive begins, by the survey's clock with its first image.
  void begin(const std::filesystem::path& folder);
  /// Images saved so far, of which this is the newest; paused: the disk takes none.
  void note(std::uint64_t saved, bool paused, Time newest);
  /// No image is recorded any more; its files are made.
  void close();
  void end();
  void set_controllable(bool controllable);
  void set_controller(const std::string& name);

  struct Now {
    bool is_recording = false;
    std::filesystem::path folder;  ///< of the dive, also when it has ended; absolute
    std::uint64_t saved = 0;
  };
  Now now() const;

  /// To where marks go, until another is set: false when they cannot be taken. Once this returns
  /// none is under way to the one before. Called by one thread at a time.
  using Record = std::function<bool(const Mark&)>;
  void record_marks(Record record);
  /// Its id, counted over the dives of the run. Time and id are given to it. None while no dive is
  /// recorded. It is kept once pages are sent it.
  std::optional<std::uint64_t> add(Mark mark);
  /// False when there is no such mark in the dive that is recorded.
  bool remove(std::uint64_t mark);
  /// The projected image that shows the mark, where it will be once it was projected.
  std::optional<std::filesystem::path> photograph(std::uint64_t mark) const;

 private:
  void tell_now();

  mutable std::mutex mutex_;
  Tell tell_;
  wire::Recording recording_;
  std::filesystem::path folder_;
  bool is_recording_ = false;
  Time newest_ = 0;
  Record record_;
  std::map<std::uint64_t, Mark> marks_;  ///< of the dive
  std::uint64_t next_mark_ = 0;
};

}  // namespace nadir::app

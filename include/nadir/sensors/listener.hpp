// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Hears what sensors send over serial lines, UDP and TCP, and reads those on the board (IIO).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "nadir/sensors/input.hpp"
#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

struct Heard {
  std::size_t input = 0;  ///< its place in the list
  Time time = 0;          ///< of arrival, CLOCK_MONOTONIC
  Reading reading;
};

/// An input that was opened (no fault), could not be, was closed by the other side, or lacks a part
/// of what it should tell; each once until it changes.
struct LinkChange {
  std::size_t input = 0;
  Time time = 0;
  std::string fault;
};

/// How many sentences or packets came over an input.
struct LinkCounts {
  std::uint64_t used = 0;
  std::uint64_t unused = 0;   ///< sentences of kinds that say nothing of use
  std::uint64_t damaged = 0;  ///< with a wrong checksum, or none, or a field that is no number
  std::uint64_t bytes = 0;    ///< whatever they were; none are counted of IIO devices
};

class Listener {
 public:
  struct Callbacks {
    std::function<void(const Heard&)> heard;
    std::function<void(const LinkChange&)> link;
  };

  /// Opens nothing yet.
  Listener(const std::vector<Input>& inputs, Callbacks callbacks);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// Listens until told to stop, and calls back meanwhile, on this thread. What cannot be opened or
  /// is lost is tried again every second; a peer that is gone without a word is noticed after 11 s.
  void run(const std::stop_token& stop);

  /// Of each input; from any thread.
  std::vector<LinkCounts> counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::sensors

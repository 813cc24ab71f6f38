// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How many pictures are missing before one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

namespace nadir::capture {

/// By the driver's number; and by the time, since a pipeline may number only what it passes on.
class Losses {
 public:
  /// frame_ns: how long the camera took for it; 0: it does not tell.
  std::uint32_t before(std::uint32_t sequence, std::int64_t time_ns, std::int64_t frame_ns) {
    constexpr std::uint32_t kBackwards = 1u << 31;
    const auto last = std::exchange(last_, Last{sequence, time_ns, frame_ns});
    if (!last) return 0;
    // The number wraps; one that goes back tells nothing.
    const std::uint32_t step = sequence - last->sequence;
    std::int64_t lost = step == 0 || step >= kBackwards ? 0 : step - 1;
    // A camera that changes its rate goes from one picture's to the other's.
    const std::int64_t longer_ns = std::max(frame_ns, last->frame_ns);
    // Nobody leaves a camera alone for so long: one of the two times is wrong.
    constexpr std::int64_t kLongest_ns = 60'000'000'000;
    const std::int64_t gap_ns = time_ns - last->time_ns;
    if (longer_ns > 0 && gap_ns < kLongest_ns)
      lost = std::max(lost, (gap_ns + longer_ns / 2) / longer_ns - 1);
    return static_cast<std::uint32_t>(std::min<std::int64_t>(lost, UINT32_MAX));
  }

 private:
  struct Last {
    std::uint32_t sequence;
    std::int64_t time_ns, frame_ns;
  };
  std::optional<Last> last_;
};

}  // namespace nadir::capture

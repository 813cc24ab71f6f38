// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Which pictures of two cameras were taken together.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "camera.hpp"

namespace nadir::capture {

struct PicturePair {
  Picture left, right;
};

class Pairing {
 public:
  enum class Side : std::uint8_t { left, right };

  /// Pictures of one camera come in the order of their times.
  void add(Side side, Picture picture);
  /// The next two less than half a period apart; none when it takes more pictures. period: of the
  /// cameras.
  std::optional<PicturePair> take(Time period);
  /// Left pictures that were given up since the last call, for want of a partner.
  std::uint32_t take_unpaired() { return std::exchange(unpaired_, 0); }
  /// Right minus left, the median of the last twenty; none before there are so many.
  std::optional<Time> skew() const;

 private:
  std::deque<Picture>& waiting(Side side) { return waiting_.at(static_cast<std::size_t>(side)); }
  void drop(Side side);

  std::array<std::deque<Picture>, 2> waiting_;
  std::deque<Time> skews_;
  std::uint32_t unpaired_ = 0;
};

}  // namespace nadir::capture

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The last good view after tracking is lost, and how to swim back to it.
#pragma once

#include <optional>

#include "nadir/core/revision.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::app {

class WayBack {
 public:
  /// enough_tie_points: an image with fewer is no good view.
  explicit WayBack(std::uint32_t enough_tie_points) : enough_tie_points_(enough_tie_points) {}

  /// live: the orientation's image as the page was shown it; null when it was not.
  void observe(const Orientation& orientation, const wire::LiveImage* live);

  bool is_lost() const { return lost_; }
  /// Once after each loss that there is a good view before.
  std::optional<wire::LastView> take_last_view();
  /// Known while dead reckoning is more certain than the way is long, or than near (survey units)
  /// is: a way that short leads to where the view is in sight.
  wire::WayBack way(const Corrections& corrections, double near) const;
  /// Survey x and y of the vehicle by dead reckoning, as corrected; none when it has a pose.
  std::optional<Eigen::Vector2d> reckoned(const Corrections& corrections) const;

 private:
  std::uint32_t enough_tie_points_;
  bool lost_ = false, untold_ = false;
  std::optional<wire::LastView> view_;
  std::optional<ImagePose> view_pose_;
  std::optional<DeadReckoned> reckoned_;
};

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A Beast rate policy: how much a viewer may say between two looks at it. Floods of pings or of
// empty fragments never become a message, so they are only seen here.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

namespace boost::beast {
class rate_policy_access;
}

namespace nadir::serve {

class InboundBudget {
 public:
  void limit(std::size_t bytes) { limit_ = left_ = bytes; }
  void renew() { left_ = limit_; }
  bool exceeded() const { return exceeded_; }

 private:
  friend class boost::beast::rate_policy_access;
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  std::size_t available_read_bytes() const { return left_; }
  std::size_t available_write_bytes() const { return kAll; }
  void transfer_read_bytes(std::size_t bytes) {
    if (limit_ == kAll) return;
    left_ -= std::min(left_, bytes);
    exceeded_ = exceeded_ || left_ == 0;
  }
  void transfer_write_bytes(std::size_t) const {}
  void on_timer() { renew(); }  // each second once there was nothing left

  std::size_t limit_ = kAll, left_ = kAll;
  bool exceeded_ = false;
};

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/check.hpp"
#include "nadir/revisit/revisit.hpp"

namespace nadir::revisit {

void Config::check() const {
  require_setting(gap >= 2 && gap <= 1000, "revisit.gap", "2 to 1000 key frames");
  require_setting(candidates >= 1 && candidates <= 50, "revisit.candidates", "1 to 50");
  require_setting(max_adjusted >= 2 && max_adjusted <= 100000, "revisit.max_adjusted",
                  "2 to 100000 key frames");
  require_setting(max_tilt_deg > 0 && max_tilt_deg <= 90, "revisit.max_tilt_deg",
                  "more than 0, at most 90 degrees");
}

}  // namespace nadir::revisit

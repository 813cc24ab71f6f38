// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Ground seen before: which earlier images show it, by the map's own geometry and by likeness.
#pragma once

#include "maps.hpp"
#include "nadir/revisit/revisit.hpp"

namespace nadir::revisit {

/// Links the newest key frame with earlier ones of its map.
void look_at_home(Maps& maps, int newest, const Config& config);

/// Compares it with those of other maps; where one shows the same ground, proven by many corners or
/// by a second pair of images, the later map is moved onto the earlier.
/// out: the join, and an alert with this time.
void look_abroad(Maps& maps, int newest, const Config& config, Time time, Revision& out);

/// At the end: compares key frames of maps that are still apart.
void look_all_over(Maps& maps, const Config& config, Time time, Revision& out);

}  // namespace nadir::revisit

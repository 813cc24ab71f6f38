// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of all key frames of a map that was seen again.
#pragma once

#include <vector>

#include "link.hpp"

namespace nadir::revisit {

/// members: nodes of one map, by image; links between them. Moves their corrected_from_camera; the
/// first stays. False, and nothing changed, when there is no solution.
bool adjust_map(std::vector<Node>& nodes, const std::vector<int>& members,
                const std::vector<Link>& links);

}  // namespace nadir::revisit

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Regions that are to be covered and were not seen.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace nadir::coverage {

struct GapInBlocks {
  cv::Point centre;  ///< a block well inside, next to the middle
  int cells = 0;
};

/// missing: CV_16UC1, cells to be covered and unseen in each block of so many cells a side.
std::vector<GapInBlocks> gaps_in(const cv::Mat1w& missing, int cells_a_side);

}  // namespace nadir::coverage

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// NumPy archives: .npy arrays (format 1.0) in a ZIP file, stored, as numpy.savez writes them.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

namespace nadir::simulate {

/// Named arrays, CV_16S or CV_64F, one channel. A 1 x 1 array becomes a scalar, one of a single
/// column a vector.
std::string npz(const std::vector<std::pair<std::string, cv::Mat>>& arrays);

}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Smaller images.
#pragma once

#include <opencv2/core/mat.hpp>

namespace nadir::image_io {

/// 1/divisor of each side: pixel areas are averaged, the result is ceil(size / divisor), as
/// CameraModel::reduced has it. With divisor 1 the image itself.
cv::Mat reduce(const cv::Mat& image, int divisor);

}  // namespace nadir::image_io

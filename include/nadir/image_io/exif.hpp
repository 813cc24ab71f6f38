// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The one thing nadir reads from EXIF: when the picture was taken.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "nadir/core/time.hpp"

namespace nadir::image_io {

/// DateTimeOriginal with SubSecTimeOriginal of a JPEG or TIFF file, as if it were UTC, since the
/// UNIX epoch. None when absent or malformed; never throws. EXIF 2.32, section 4.6.
std::optional<Time> read_exif_time(std::span<const std::uint8_t> file);

}  // namespace nadir::image_io

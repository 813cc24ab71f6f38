// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Numbers as text that does not depend on the locale.
#pragma once

#include <cstdint>
#include <string>

#include "nadir/core/time.hpp"

namespace nadir::record {

/// With this many decimals and '.'; never "-0.000".
std::string fixed(double value, int decimals);
/// Seconds with nine decimals.
std::string seconds_text(Time time);
/// At least this many digits, zeros in front.
std::string padded(std::uint64_t value, std::size_t digits);

}  // namespace nadir::record

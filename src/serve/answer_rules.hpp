// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How a download is cut and named in its answer. RFC 9110, 13.1.5 and 14; RFC 6266.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace nadir::serve {

/// Bytes [begin, end) of something.
struct Part {
  std::uint64_t begin = 0, end = 0;
  bool operator==(const Part&) const = default;
};

/// What a Range field asks for of so many bytes: the whole when it is absent, not of bytes, of
/// several ranges or malformed, as the standard allows. None when it lies beyond the end.
std::optional<Part> part_of(std::string_view range, std::uint64_t size);

/// Whether a range may be answered: an If-Range field, empty when absent, names what is there now.
bool is_unchanged(std::string_view if_range, std::string_view tag);

/// Content-Disposition for a file to be saved under a name like this.
std::string attachment(std::string_view name);

/// {"error": reason}; for reasons without quotes, backslashes and control characters.
std::string error_json(std::string_view reason);

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Text of strangers made fit for a screen, a log and a file.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nadir::app {

/// The characters of valid UTF-8 in it, at most so many; what steers a terminal or turns the
/// direction of writing is left out, line ends become spaces, and so do none at either end.
std::string plain_text(std::string_view text, std::size_t most_characters);

/// %41 to A (RFC 3986, 2.1); what is malformed stays as it is.
std::string percent_decoded(std::string_view text);

}  // namespace nadir::app

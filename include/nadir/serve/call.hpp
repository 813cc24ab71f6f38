// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a page asks of this device beside the feed, and what it is answered: paths under /api/.
// RFC 9110 (ranges: section 14), RFC 6266, RFC 6750.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace nadir::serve {

constexpr std::string_view kApiPath = "/api/";
constexpr std::size_t kMostBody = 64 << 10;

/// A request under kApiPath (README.md beside this file) that came from a page of this device or
/// from no page at all. Nothing in it was checked further, and nothing was decoded.
struct Call {
  std::string method;         ///< GET, POST or DELETE
  std::string path;           ///< without the query
  std::string query;          ///< without the question mark
  std::string token;          ///< of "Authorization: Bearer"; empty: none or more than one
  std::string session, name;  ///< of Nadir-Session and Nadir-Name, likewise
  std::string caller;         ///< the address it came from
  bool local = false;         ///< from this machine, under a name for itself
  std::string body;           ///< of a POST, at most kMostBody
};

/// Bytes to be saved by who asked for them.
struct Download {
  std::string name;  ///< other characters than A-Z a-z 0-9 . _ - become _
  std::uint64_t size = 0;
  std::string tag;  ///< another when the bytes are; letters, digits and -
  /// Fills `into`, which lies within size, from the byte `at` on and says how far, as pread does:
  /// 0 or less: not at all. By the thread that called the handler.
  std::function<std::ptrdiff_t(std::uint64_t at, std::span<char> into)> read;
};

struct Answer {
  unsigned status = 200;
  std::string content_type = "application/json";
  std::string text{};
  std::optional<Download> download{};  ///< with status 200, in place of the text
};

/// Called by one thread of the server's own, one call after the other: a slow disk holds up other
/// calls and downloads, never the feed. What it throws is answered with status 500.
using Handler = std::function<Answer(const Call&)>;

}  // namespace nadir::serve

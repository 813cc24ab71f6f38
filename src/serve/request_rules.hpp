// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Which requests are answered at all. Against DNS rebinding a request must name this device, and
// against pages from elsewhere an upgrade must come from the page this device served, as must a
// call that changes anything if it comes from a page.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nadir::serve {

struct Request {
  std::string_view method, target;
  std::vector<std::string_view> hosts, origins;  ///< every field of the name
  std::optional<std::string_view> accept_encoding;
  bool upgrade = false;  ///< to WebSocket
  bool body = false;
  bool tls = false;  ///< over which it came
};

struct Refusal {
  unsigned status;
  std::string_view reason;  ///< for the reader of the answer
};

/// local_address: of the connection, as in a URL: "192.168.2.2" or "[fe80::1]".
std::optional<Refusal> refusal_of(const Request& request, std::string_view local_address,
                                  const std::vector<std::string>& names);

/// Whether it is under kApiPath.
bool is_call(std::string_view target);

/// The path to look up, "/index.html" for "/". What follows a question mark is the page's own.
std::string_view path_of(std::string_view target);

/// host: the request's, which was not refused. Names the feed too: 'self' does not cover ws: in
/// older browsers.
std::string content_security_policy(std::string_view host, bool tls);

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "request_rules.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "nadir/serve/web_server.hpp"

namespace nadir::serve {
namespace {

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port > 0 && port < 65536;
}

/// "host" or "host:port" to host in lower case; none when malformed.
std::optional<std::string> host_of(std::string_view authority) {
  const std::size_t bracket = authority.starts_with('[') ? authority.find(']') : 0;
  if (bracket == std::string_view::npos) return std::nullopt;
  const std::size_t colon = authority.find(':', bracket);
  if (colon != std::string_view::npos && !is_port(authority.substr(colon + 1))) return std::nullopt;
  std::string host(authority.substr(0, colon));
  const bool plain = std::ranges::all_of(host, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("-._[]:").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (host.empty() || !plain) return std::nullopt;
  std::ranges::transform(host, host.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return host;
}

/// RFC 9110, 12.5.3: without the field any coding will do.
bool accepts_gzip(const std::optional<std::string_view>& accept_encoding) {
  if (!accept_encoding) return true;
  const std::size_t at = accept_encoding->find("gzip");
  if (at == std::string_view::npos) return accept_encoding->find('*') != std::string_view::npos;
  const std::string_view coding = accept_encoding->substr(at, accept_encoding->find(',', at) - at);
  return !coding.ends_with(";q=0") && !coding.ends_with("; q=0");
}

}  // namespace

std::optional<Refusal> refusal_of(const Request& request, std::string_view local_address,
                                  const std::vector<std::string>& names) {
  if (request.method != "GET") return Refusal{405, "only GET is understood"};
  if (request.body) return Refusal{400, "a GET has no body"};
  if (!request.target.starts_with('/')) return Refusal{400, "not a path"};
  if (request.hosts.size() != 1) return Refusal{400, "one Host is needed"};
  const auto host = host_of(request.hosts[0]);
  if (!host) return Refusal{400, "malformed Host"};
  if (*host != "localhost" && *host != local_address && std::ranges::count(names, *host) == 0) {
    return Refusal{421, "this device does not go by that name (serve.names)"};
  }
  if (request.upgrade) {
    const std::string own = "http://" + std::string(request.hosts[0]);
    if (request.origins.size() != 1 || request.origins[0] != own) {
      return Refusal{403, "the feed is for the page of this device only"};
    }
  } else if (!accepts_gzip(request.accept_encoding)) {
    return Refusal{406, "the page is only had compressed with gzip"};
  }
  return std::nullopt;
}

std::string_view path_of(std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  return path == "/" ? "/index.html" : path;
}

std::string content_security_policy(std::string_view host) {
  return "default-src 'self'; connect-src 'self' ws://" + std::string(host) +
         "; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
         "frame-ancestors 'none'";
}

}  // namespace nadir::serve

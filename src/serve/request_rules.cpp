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

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
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
  return lower_case(std::move(host));
}

/// RFC 9110, 12.5.3: without the field any coding will do.
bool accepts_gzip(const std::optional<std::string_view>& accept_encoding) {
  if (!accept_encoding) return true;
  const std::size_t at = accept_encoding->find("gzip");
  if (at == std::string_view::npos) return accept_encoding->find('*') != std::string_view::npos;
  const std::string_view coding = accept_encoding->substr(at, accept_encoding->find(',', at) - at);
  return !coding.ends_with(";q=0") && !coding.ends_with("; q=0");
}

std::optional<Refusal> refusal_of_method(const Request& request, bool call) {
  const bool post = call && request.method == "POST";
  const bool known = request.method == "GET" || post || (call && request.method == "DELETE");
  if (!known && call) return Refusal{405, "only GET, POST and DELETE are understood"};
  if (!known) return Refusal{405, "only GET is understood"};
  if (request.body && !post) return Refusal{400, "only a POST has a body"};
  return std::nullopt;
}

}  // namespace

std::optional<Refusal> refusal_of(const Request& request, std::string_view local_address,
                                  const std::vector<std::string>& names) {
  const bool call = is_call(request.target) && !request.upgrade;
  if (const auto refusal = refusal_of_method(request, call)) return refusal;
  if (!request.target.starts_with('/')) return Refusal{400, "not a path"};
  if (request.hosts.size() != 1) return Refusal{400, "one Host is needed"};
  const auto host = host_of(request.hosts[0]);
  if (!host) return Refusal{400, "malformed Host"};
  const bool named = std::ranges::count(names, *host, lower_case) > 0;
  if (*host != "localhost" && *host != local_address && !named) {
    return Refusal{421, "this device does not go by that name (serve.names)"};
  }
  const std::string own = (request.tls ? "https://" : "http://") + std::string(request.hosts[0]);
  const bool from_own_page = request.origins.size() == 1 && request.origins[0] == own;
  if (request.upgrade) {
    if (!from_own_page) return Refusal{403, "the feed is for the page of this device only"};
  } else if (call) {
    const bool changes = request.method != "GET";
    if (changes && !request.origins.empty() && !from_own_page) {
      return Refusal{403, "the page of this device only may ask for that"};
    }
  } else if (!accepts_gzip(request.accept_encoding)) {
    return Refusal{406, "the page is only had compressed with gzip"};
  }
  return std::nullopt;
}

bool is_call(std::string_view target) { return target.starts_with(kApiPath); }

std::string_view path_of(std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  return path == "/" ? "/index.html" : path;
}

std::string content_security_policy(std::string_view host, bool tls) {
  return "default-src 'self'; connect-src 'self' " + std::string(tls ? "wss://" : "ws://") +
         std::string(host) +
         "; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
         "frame-ancestors 'none'";
}

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A request as Beast has it, told in the room's own words. Included by front.cpp alone.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/address_v6.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "nadir/serve/call.hpp"
#include "request_rules.hpp"
#include "stream.hpp"

namespace nadir::serve {

inline std::string to_text(const asio::ip::address& address) {
  if (address.is_v4()) return address.to_string();
  if (address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  return asio::ip::address_v6(address.to_v6().to_bytes()).to_string();
}

/// As it stands in a URL.
inline std::string local_address(const Stream& stream) {
  error_code error;
  const std::string text = to_text(stream.socket().local_endpoint(error).address());
  return text.find(':') == std::string::npos ? text : '[' + text + ']';
}

/// The address it comes from; empty when the connection is gone.
inline std::string caller_of(const Stream& stream) {
  error_code error;
  const auto from = stream.socket().remote_endpoint(error);
  return error ? std::string() : to_text(from.address());
}

/// An address, or a name with or without a port.
inline bool is_loopback(std::string_view host) {
  const std::string_view name = host.substr(0, host.rfind(':'));
  return host == "::1" || host.starts_with("127.") || name == "localhost" ||
         host.starts_with("[::1]");
}

template <class Name>
std::vector<std::string_view> values(const HttpRequest& request, Name field) {
  std::vector<std::string_view> all;
  const auto range = request.equal_range(field);
  for (auto it = range.first; it != range.second; ++it) {
    all.emplace_back(it->value().data(), it->value().size());
  }
  return all;
}

template <class Name>
std::string_view only_value(const HttpRequest& request, Name field) {
  const auto all = values(request, field);
  return all.size() == 1 ? all[0] : std::string_view();
}

inline Request plain(const HttpRequest& request, bool body) {
  Request plain;
  plain.method = {request.method_string().data(), request.method_string().size()};
  plain.target = {request.target().data(), request.target().size()};
  plain.hosts = values(request, http::field::host);
  plain.origins = values(request, http::field::origin);
  const auto codings = values(request, http::field::accept_encoding);
  if (!codings.empty()) plain.accept_encoding = codings[0];
  plain.upgrade = beast::websocket::is_upgrade(request);
  plain.body = body;
  return plain;
}

inline Call call_of(const Stream& stream, const HttpRequest& request) {
  constexpr std::string_view kBearer = "Bearer ";
  Call call;
  const std::string_view target(request.target().data(), request.target().size());
  const std::size_t mark = std::min(target.find('?'), target.size());
  call.method = std::string(request.method_string());
  call.path = target.substr(0, mark);
  call.query = target.substr(std::min(mark + 1, target.size()));
  const auto authorization = only_value(request, http::field::authorization);
  if (authorization.starts_with(kBearer)) call.token = authorization.substr(kBearer.size());
  call.session = only_value(request, "Nadir-Session");
  call.name = only_value(request, "Nadir-Name");
  call.caller = caller_of(stream);
  // Whoever comes through a proxy on this machine calls it by another name.
  const std::string_view host = only_value(request, http::field::host);
  call.local = is_loopback(call.caller) && is_loopback(host);
  call.body = request.body();
  return call;
}

}  // namespace nadir::serve

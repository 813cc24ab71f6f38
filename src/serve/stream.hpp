// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the few files that see Asio and Beast share.
#pragma once

#include <chrono>
#include <exception>
#include <utility>

// Asio 1.18 leaves out standard headers that must come before it.
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

#include "inbound_budget.hpp"

namespace nadir::serve {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using Stream = beast::basic_stream<tcp, asio::any_io_executor, InboundBudget>;
using HttpRequest = http::request<http::string_body>;

/// The outcome of what is awaited goes to error, never into an exception.
inline auto noting(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

/// A fault in one connection ends that connection only.
template <class Executor>
void spawn(Executor&& executor, asio::awaitable<void> work) {
  asio::co_spawn(executor, std::move(work), [](const std::exception_ptr&) {});
}

}  // namespace nadir::serve

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the few files that see Asio and Beast share.
#pragma once

#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <type_traits>
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
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include "inbound_budget.hpp"

namespace nadir::serve {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using HttpRequest = http::request<http::string_body>;

/// The outcome of what is awaited goes to error, never into an exception.
inline auto noting(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

/// A connection: plain, then perhaps under TLS. Timeouts and the budget are of what lies beneath.
class Stream {
 public:
  using Plain = beast::basic_stream<tcp, asio::any_io_executor, InboundBudget>;
  using executor_type = asio::any_io_executor;
  template <class Token>
  using Outcome =
      typename asio::async_result<std::decay_t<Token>, void(error_code, std::size_t)>::return_type;

  explicit Stream(tcp::socket socket) : plain_(std::make_unique<Plain>(std::move(socket))) {}

  /// From now on what is read and written goes through TLS. begun: what was read of the client's
  /// first record.
  asio::awaitable<error_code> begin_tls(asio::ssl::context& context, asio::const_buffer begun);
  bool is_tls() const { return tls_.has_value(); }
  /// Says that nothing follows. What is still read through plain() serves only to let that arrive.
  asio::awaitable<void> end_output();

  executor_type get_executor() noexcept { return plain_->get_executor(); }
  Plain& plain() { return *plain_; }
  tcp::socket& socket() { return plain_->socket(); }
  const tcp::socket& socket() const { return plain_->socket(); }
  InboundBudget& rate_policy() { return plain_->rate_policy(); }
  void expires_after(Clock::duration patience) { plain_->expires_after(patience); }
  void expires_never() { plain_->expires_never(); }

  template <class Buffers, class Token>
  Outcome<Token> async_read_some(const Buffers& buffers, Token&& token) {
    if (tls_) return tls_->async_read_some(buffers, std::forward<Token>(token));
    return plain_->async_read_some(buffers, std::forward<Token>(token));
  }
  template <class Buffers, class Token>
  Outcome<Token> async_write_some(const Buffers& buffers, Token&& token) {
    if (tls_) return tls_->async_write_some(buffers, std::forward<Token>(token));
    return plain_->async_write_some(buffers, std::forward<Token>(token));
  }

  // What Beast's WebSocket calls after its farewell, and when its time is up.
  template <class Handler>
  friend void async_teardown(beast::role_type role, Stream& stream, Handler&& handler) {
    if (stream.tls_) {
      stream.tls_->async_shutdown(std::forward<Handler>(handler));
    } else {
      using beast::async_teardown;
      async_teardown(role, *stream.plain_, std::forward<Handler>(handler));
    }
  }
  friend void beast_close_socket(Stream& stream) { beast::close_socket(*stream.plain_); }

 private:
  std::unique_ptr<Plain> plain_;  // where TLS refers to it
  std::optional<beast::ssl_stream<Plain&>> tls_;
};

/// A fault in one connection ends that connection only.
template <class Executor>
void spawn(Executor&& executor, asio::awaitable<void> work) {
  asio::co_spawn(executor, std::move(work), [](const std::exception_ptr&) {});
}

}  // namespace nadir::serve

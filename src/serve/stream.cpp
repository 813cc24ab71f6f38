// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "stream.hpp"

namespace nadir::serve {

asio::awaitable<error_code> Stream::begin_tls(asio::ssl::context& context,
                                              asio::const_buffer begun) {
  error_code error;
  tls_.emplace(*plain_, context);
  co_await tls_->async_handshake(asio::ssl::stream_base::server, begun, noting(error));
  co_return error;
}

asio::awaitable<void> Stream::end_output() {
  error_code ignored;
  if (tls_) {
    // As if the client had taken its leave: else that would be waited for.
    ::SSL_set_shutdown(tls_->native_handle(), SSL_RECEIVED_SHUTDOWN);
    co_await tls_->async_shutdown(noting(ignored));
  }
  socket().shutdown(tcp::socket::shutdown_send, ignored);
}

}  // namespace nadir::serve

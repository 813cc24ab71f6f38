// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The client of raw_client.hpp under TLS; it trusts one certificate.
#pragma once

#include <openssl/ssl.h>
#include <sys/time.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <string>

#include "certificate_files.hpp"
#include "raw_client.hpp"

namespace nadir::serve {

class TlsClient : public RawClient {
 public:
  TlsClient(std::uint16_t port, const std::string& certificate, int receive_buffer = 0,
            int version = 0)
      : RawClient(port, receive_buffer), context_(SSL_CTX_new(TLS_client_method())) {
    std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes without MSG_NOSIGNAL
    const timeval patience{kPatience / 1000, 0};
    ::setsockopt(socket(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    SSL_CTX_load_verify_file(context_.get(), certificate.c_str());
    SSL_CTX_set_verify(context_.get(), SSL_VERIFY_PEER, nullptr);
    SSL_CTX_set_security_level(context_.get(), 0);  // so that it may offer what is refused
    SSL_CTX_set_min_proto_version(context_.get(), version);
    SSL_CTX_set_max_proto_version(context_.get(), version);
    ssl_.reset(SSL_new(context_.get()));
    SSL_set_fd(ssl_.get(), socket());
    X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl_.get()), "127.0.0.1");
    secure_ = SSL_connect(ssl_.get()) == 1;
  }
  TlsClient(TlsClient&&) = default;

  bool secure() const { return secure_; }
  std::string version() const { return SSL_get_version(ssl_.get()); }
  SSL* ssl() const { return ssl_.get(); }
  /// Whether the server took its leave before it closed: nothing was cut off.
  bool was_told() const { return (SSL_get_shutdown(ssl_.get()) & SSL_RECEIVED_SHUTDOWN) != 0; }
  std::string origin() const override { return "https://" + host(); }

 protected:
  ssize_t write(std::string_view text) override {
    return SSL_write(ssl_.get(), text.data(), static_cast<int>(text.size()));
  }
  ssize_t read(char* into, std::size_t size) override {
    return SSL_read(ssl_.get(), into, static_cast<int>(size));
  }
  bool pending() const override { return SSL_pending(ssl_.get()) > 0; }

 private:
  std::unique_ptr<SSL_CTX, Freed<SSL_CTX_free>> context_;
  std::unique_ptr<SSL, Freed<SSL_free>> ssl_;
  bool secure_ = false;
};

}  // namespace nadir::serve

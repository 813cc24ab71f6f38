// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "certificate.hpp"

#include <openssl/ssl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "nadir/core/check.hpp"

namespace nadir::serve {

namespace ssl = boost::asio::ssl;

namespace {

void require_readable(const char* setting, const std::string& file) {
  if (::access(file.c_str(), R_OK) == 0) return;
  throw InputError(std::string(setting) + ": " + file +
                   " cannot be read: " + std::generic_category().message(errno) +
                   "; name a PEM file that the user nadir runs as may read");
}

ssl::context with_options() {
  ssl::context context(ssl::context::tls_server);
  SSL_CTX* const native = context.native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION);
  // Of TLS 1.2 what has forward secrecy and authenticates what it encrypts, as all of 1.3 does.
  SSL_CTX_set_cipher_list(native, "ECDHE+AESGCM:ECDHE+CHACHA20");
  SSL_CTX_set_options(native, SSL_OP_NO_RENEGOTIATION);
  // Clients keep their sessions themselves, in tickets.
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  // OpenSSL would ask at the terminal.
  context.set_password_callback(
      [](std::size_t, ssl::context::password_purpose) { return std::string(); });
  return context;
}

/// A certificate that is not valid yet is none of our business: a board's clock may not be set.
bool has_expired(SSL_CTX* context) {
  return X509_cmp_current_time(X509_get0_notAfter(SSL_CTX_get0_certificate(context))) < 0;
}

}  // namespace

std::optional<ssl::context> tls_context(const Config& config) {
  if (config.certificate.empty()) return std::nullopt;
  require_readable("serve.certificate", config.certificate);
  require_readable("serve.key", config.key);
  ssl::context context = with_options();
  boost::system::error_code error;
  context.use_certificate_chain_file(config.certificate, error);
  if (error) {
    throw InputError("serve.certificate: " + config.certificate + " is no usable certificate (" +
                     error.message() + "); give one in PEM, its chain behind it");
  }
  context.use_private_key_file(config.key, ssl::context::pem, error);
  const bool other =
      ERR_GET_REASON(static_cast<unsigned>(error.value())) == X509_R_KEY_VALUES_MISMATCH;
  if (other || (!error && SSL_CTX_check_private_key(context.native_handle()) != 1)) {
    throw InputError("serve.key: " + config.key + " does not fit the certificate " +
                     config.certificate + "; give the key that it was made with");
  }
  if (error) {
    throw InputError("serve.key: " + config.key + " is no usable key (" + error.message() +
                     "); give one in PEM, without a passphrase");
  }
  if (has_expired(context.native_handle())) {
    throw InputError("serve.certificate: " + config.certificate +
                     " has expired; make a new one, or correct this computer's clock");
  }
  return context;
}

std::string certificate_fault(const Config& config) {
  try {
    (void)tls_context(config);
    return {};
  } catch (const InputError& fault) {
    return fault.what();
  }
}

}  // namespace nadir::serve

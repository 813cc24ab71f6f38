// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The configured certificate and what TLS is spoken with it.
#pragma once

#include <optional>

#include <boost/asio/ssl/context.hpp>

#include "nadir/serve/web_server.hpp"

namespace nadir::serve {

/// None when no certificate is configured. Throws InputError naming the setting, the fault and the
/// remedy.
std::optional<boost::asio::ssl::context> tls_context(const Config& config);

}  // namespace nadir::serve

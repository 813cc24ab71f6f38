// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The configured certificate and what TLS is spoken with it.
#pragma once

#include <optional>

#include "nadir/serve/web_server.hpp"
#include "stream.hpp"

namespace nadir::serve {

/// None when no certificate is configured. Throws InputError naming the setting, the fault and the
/// remedy.
std::optional<asio::ssl::context> tls_context(const Config& config);

}  // namespace nadir::serve

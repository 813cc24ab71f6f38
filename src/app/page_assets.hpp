// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The tablet page as compiled into the binary.
#pragma once

#include <vector>

#include "nadir/serve/web_server.hpp"

namespace nadir::app {

std::vector<serve::Asset> page_assets();

}  // namespace nadir::app

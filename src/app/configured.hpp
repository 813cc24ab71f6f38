// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The configuration a verb runs with: the defaults, then what the file says, then the command line.
#pragma once

#include "config.hpp"
#include "options.hpp"

namespace nadir::app {

/// Throws InputError naming the file when that is wrong, UsageError when the command line is.
Config configured(const Settings& settings, const std::optional<Address>& address = {});

/// The service's own file, unless another is named.
Settings settings_of_service(Settings settings);

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A simulated survey as a folder: what `nadir replay` reads, and the truth beside it (gt_*).
#pragma once

#include <filesystem>
#include <functional>

#include "nadir/simulate/options.hpp"

namespace nadir::simulate {

/// Writes a survey folder as in machine.md with its truth. progress(done, total) may be empty.
/// Throws InputError when the folder is not empty or cannot be written, or the options are wrong.
void write_survey(const std::filesystem::path& folder, const Options& options,
                  const std::function<void(int, int)>& progress);

}  // namespace nadir::simulate

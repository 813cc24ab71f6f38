// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How a stage of the pipeline is doing.
#pragma once

#include <cstdint>
#include <string>

namespace nadir {

struct StageStats {
  std::string stage;
  double rate_in_hz = 0, rate_out_hz = 0;
  std::uint64_t processed = 0;
  std::uint32_t depth = 0;    ///< items waiting at its input
  std::uint64_t dropped = 0;  ///< at its input
  double last_ms = 0, p95_ms = 0;
  double cpu_s = 0;  ///< of its thread since the start
};

}  // namespace nadir

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The dive.json that is there, for those who read a dive again.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "ledger.hpp"
#include "products.hpp"

namespace nadir::record {

// NOLINTNEXTLINE(bugprone-exception-escape): moving a map throws nothing here
struct EarlierSummary {
  bool exists = false;  ///< and can be read
  bool cut_off = true;
  std::uint64_t captured = 0;
  Stamps files;
  double area = 0;
  nlohmann::json rates;

  /// Whether the journal has lost the end that it had when this was written.
  bool outlives(const Ledger& ledger) const { return exists && !cut_off && !ledger.ended; }
};

EarlierSummary read_summary(const path& dive);

}  // namespace nadir::record

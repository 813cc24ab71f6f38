// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A dive from its beginning to its end, whatever its images come from: what dive.json says of how
// it was made, and how it is concluded.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "config.hpp"
#include "graph.hpp"

namespace nadir::app {

/// input: where the images come from; engine: what oriented them.
record::DiveInfo dive_info(nlohmann::json input, const std::string& engine, const Config& config);

struct EndOfDive {
  Graph& graph;
  record::Dive& dive;
  Publisher* page;  ///< may be null
  Progress& progress;
  std::chrono::steady_clock::time_point begun;
  LiveDive* live = nullptr;  ///< may be null
};

/// Waits until everything captured is mapped and the dive's files are made. The exit status: 0 when
/// all were. Throws what a stage threw, after that.
int finish_dive(const EndOfDive& end);

/// Where a browser finds the page: by https where a certificate is configured and the address is
/// not this machine's alone.
std::string page_url(const serve::Config& config, std::uint16_t port);

}  // namespace nadir::app

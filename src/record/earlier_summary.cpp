// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "earlier_summary.hpp"

#include "loose_file.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

EarlierSummary parse(const json& summary) {
  EarlierSummary earlier;
  for (const auto& [name, entry] : summary.at("files").items()) {
    earlier.files[name] = {entry.at("bytes"), entry.at("crc32")};
  }
  earlier.cut_off = summary.at("cut_off");
  earlier.captured = summary.at("counts").at("captured");
  earlier.area = summary.at("area_survey_units");
  earlier.rates = summary.at("rates");
  earlier.exists = true;
  return earlier;
}

}  // namespace

EarlierSummary read_summary(const path& dive) {
  std::ifstream in = open_to_read(dive / "dive.json");
  try {
    return in ? parse(json::parse(in)) : EarlierSummary();
  } catch (const json::exception&) {
    return {};
  }
}

}  // namespace nadir::record

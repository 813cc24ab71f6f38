// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "page_assets.hpp"

#include "nadir_web_assets.hpp"

namespace nadir::app {

std::vector<serve::Asset> page_assets() {
  std::vector<serve::Asset> assets;
  for (const auto& file : web_assets()) {
    assets.push_back({file.path, file.content_type, {file.begin, file.end}});
  }
  return assets;
}

}  // namespace nadir::app

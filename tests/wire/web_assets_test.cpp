// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir_web_assets.hpp"

#include <gmock/gmock.h>

#include <set>
#include <string>

namespace nadir {
namespace {

TEST(WebAssets, HoldThePageItself) {
  std::set<std::string> paths;
  for (const WebAsset& asset : web_assets()) {
    paths.insert(asset.path);
  }
  EXPECT_THAT(paths, testing::Contains("/index.html"));
}

// A tablet on a thin line waits for all of it.
TEST(WebAssets, TakeAtMost400kB) {
  std::ptrdiff_t size = 0;
  for (const WebAsset& asset : web_assets()) size += asset.end - asset.begin;
  EXPECT_LE(size, 400'000);
}

TEST(WebAssets, AreGzipStreamsOfAKnownType) {
  for (const WebAsset& asset : web_assets()) {
    ASSERT_GT(asset.end - asset.begin, 18) << asset.path;  // RFC 1952: header and trailer
    EXPECT_EQ(asset.begin[0], 0x1F) << asset.path;
    EXPECT_EQ(asset.begin[1], 0x8B) << asset.path;
    EXPECT_THAT(asset.content_type, testing::HasSubstr("/")) << asset.path;
  }
}

}  // namespace
}  // namespace nadir

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "app/notify_socket.hpp"
#include "nadir/core/check.hpp"
#include "support/dive_folder.hpp"
#include "verbs.hpp"

namespace nadir::app {
namespace {

using namespace support;

class RunTest : public testing::Test {
 protected:
  RunTest() {
    fs::create_directories(folder);
    write("captur.rate_hz = 3\n");
    live.settings.file = folder / "nadir.toml";
    live.serve = Address{"127.0.0.1", 0};
  }
  void write(const std::string& text) const { std::ofstream(folder / "nadir.toml") << text; }

  const fs::path folder = fresh_folder("run");
  app::Run live;
};

TEST_F(RunTest, AtAShellEndsWithWhatIsWrongWithTheSettings) {
  ::unsetenv("NOTIFY_SOCKET");
  try {
    run(live);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("nadir.toml"));
  }
}

TEST_F(RunTest, AsAServiceWaitsForTheSettings) {
  const NotifySocket systemd;
  ASSERT_TRUE(systemd.bound());
  int status = -1;
  std::jthread service([&] { status = run(live); });
  EXPECT_TRUE(systemd.hears("STATUS=waiting for its settings"));
  write("capture.rate_hz = 3\n");
  service.join();
  EXPECT_EQ(status, 1);  // to be started again
}

}  // namespace
}  // namespace nadir::app

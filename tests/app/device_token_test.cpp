// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "device_token.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <set>

#include "nadir/core/check.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using record::read_text;
using record::ScratchFolder;
using testing::HasSubstr;

class TheToken : public testing::Test {
 protected:
  void put(const std::string& text, mode_t mode = 0600) const {
    std::ofstream(file) << text;
    ::chmod(file.c_str(), mode);
  }
  ScratchFolder scratch;
  fs::path file = scratch / "state/token";
  record::Disk& disk = record::system_disk();
};

TEST_F(TheToken, IsMadeOnceAndForItsOwnerOnly) {
  const DeviceToken made = device_token(file, disk);
  EXPECT_EQ(made.token.size(), 43u);
  EXPECT_EQ(made.token.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                         "0123456789-_"),
            std::string::npos);
  EXPECT_EQ(read_text(file), made.token + '\n');
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777u, 0600u);
  const DeviceToken again = device_token(file, disk);
  EXPECT_EQ(again.token, made.token);
  EXPECT_EQ(again.message, "");
  EXPECT_EQ(read_token(file), made.token);
}

TEST_F(TheToken, IsAnotherEachTime) {
  std::set<std::string> tokens;
  std::set<char> last;
  for (int i = 0; i < 200; ++i) {
    tokens.insert(new_token());
    last.insert(tokens.rbegin()->back());
  }
  EXPECT_EQ(tokens.size(), 200u);
  EXPECT_LE(last.size(), 16u);  // of 256 bits the last character has four
}

TEST_F(TheToken, IsMadeAnewWhenItCannotBeReadOrOthersCould) {
  const std::string good = device_token(file, disk).token;
  const auto remade = [&] {
    const DeviceToken token = device_token(file, disk);
    EXPECT_THAT(token.message, HasSubstr("a new token was made"));
    EXPECT_EQ(read_token(file), token.token);
    return token.token;
  };
  for (const std::string& content : {std::string(), std::string("short"), good + "x",
                                     good.substr(1) + '\x01', std::string(1 << 20, 'a')}) {
    put(content);
    EXPECT_NE(remade(), good) << content.size();
  }
  put(good, 0644);
  EXPECT_NE(remade(), good);
  fs::remove(file);
  fs::create_symlink(scratch / "elsewhere", file);
  remade();
  EXPECT_FALSE(fs::is_symlink(file));
}

TEST_F(TheToken, IsDurableBeforeItIsUsed) {
  fs::create_directories(file.parent_path());
  record::RecordingDisk recording;
  device_token(file, recording);
  std::vector<record::Operation::Kind> kinds;
  for (const auto& operation : recording.operations) kinds.push_back(operation.kind);
  using Op = record::Operation;
  EXPECT_THAT(kinds, testing::ElementsAre(Op::create, Op::write, Op::sync_file, Op::rename,
                                          Op::sync_folder));
}

TEST_F(TheToken, IsGoodForThisRunOnADiskThatTakesNothing) {
  using Call = record::FailingDisk::Call;
  for (const Call failing : {Call::open, Call::write, Call::sync, Call::rename}) {
    fs::remove(file);
    record::FailingDisk broken;
    broken.verdict = [failing](Call call) { return call == failing ? -EIO : 0; };
    const DeviceToken token = device_token(file, broken);
    EXPECT_EQ(token.token.size(), 43u);
    EXPECT_THAT(token.message, HasSubstr("cannot be kept"));
  }
  EXPECT_EQ(device_token("/proc/no/token", disk).token.size(), 43u);
}

TEST_F(TheToken, ThatIsNotThereIsToldWithTheRemedy) {
  try {
    read_token(file);
    FAIL() << "there is none";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("systemctl start nadir"));
  }
}

TEST(TokenFile, LiesBesideTheDives) {
  EXPECT_EQ(token_file("/var/lib/nadir/dives"), "/var/lib/nadir/token");
  EXPECT_EQ(token_file("/var/lib/nadir/dives/"), "/var/lib/nadir/token");
  EXPECT_EQ(token_file("dives", "no such folder"), fs::current_path() / "token");
  EXPECT_EQ(token_file("/media/card/dives", fs::current_path()), fs::current_path() / "token")
      << "a card that is taken out does not take it along";
}

TEST(IsSameToken, IsForEqualOnesOnly) {
  EXPECT_TRUE(is_same_token("abc", "abc"));
  EXPECT_FALSE(is_same_token("abc", "abd"));
  EXPECT_FALSE(is_same_token("abc", "ab"));
  EXPECT_FALSE(is_same_token("", "a"));
}

}  // namespace
}  // namespace nadir::app

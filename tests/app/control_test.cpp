// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "control.hpp"

#include <gtest/gtest.h>

#include <mutex>
#include <vector>

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

class WhoControls : public testing::Test {
 protected:
  std::vector<std::string> heard() {
    const std::scoped_lock lock(mutex);
    return told;
  }
  Control::Tell tell = [this](const std::string& controller) {
    const std::scoped_lock lock(mutex);
    told.push_back(controller);
  };
  std::mutex mutex;
  std::vector<std::string> told;
};

TEST_F(WhoControls, IsOneAtATime) {
  Control control("t", tell);
  EXPECT_EQ(control.controller(), std::nullopt);
  EXPECT_FALSE(control.renew("a"));
  EXPECT_EQ(control.take("a", "Ann", false), "Ann");
  EXPECT_EQ(control.take("b", "Bob", false), "Ann");
  EXPECT_FALSE(control.renew("b"));
  EXPECT_FALSE(control.release("b"));
  EXPECT_TRUE(control.renew("a"));
  EXPECT_EQ(control.take("b", "Bob", true), "Bob");
  EXPECT_FALSE(control.renew("a"));
  EXPECT_TRUE(control.release("b"));
  EXPECT_EQ(control.controller(), std::nullopt);
  EXPECT_EQ(heard(), (std::vector<std::string>{"Ann", "Bob", ""}));
}

TEST_F(WhoControls, LapsesWithoutAWord) {
  Control control("t", tell, 50ms);
  control.take("a", "Ann", false);
  while (control.controller()) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(heard(), (std::vector<std::string>{"Ann", ""}));
  EXPECT_FALSE(control.renew("a"));
  control.take("b", "Bob", false);
  while (heard().size() < 4) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(heard().back(), "");
}

TEST_F(WhoControls, HasTheToken) {
  Control control("secret", tell);
  const auto now = Control::Clock::now();
  EXPECT_EQ(control.admit("secret", "10.0.0.1", now), Control::Admission::granted);
  EXPECT_EQ(control.admit("secreT", "10.0.0.1", now), Control::Admission::wrong);
  EXPECT_EQ(control.admit("", "10.0.0.1", now), Control::Admission::wrong);
}

TEST_F(WhoControls, GuessesAFewTimesAMinuteOnly) {
  Control control("secret", tell);
  const auto now = Control::Clock::now();
  int wrong = 0, barred = 0;
  for (int i = 0; i < 10'000; ++i) {
    const auto admission = control.admit("guess " + std::to_string(i), "10.0.0.1", now);
    wrong += admission == Control::Admission::wrong;
    barred += admission == Control::Admission::barred;
  }
  EXPECT_EQ(wrong, 10);
  EXPECT_EQ(barred, 9990);
  EXPECT_EQ(control.admit("secret", "10.0.0.1", now), Control::Admission::barred);
  EXPECT_EQ(control.admit("secret", "10.0.0.2", now), Control::Admission::granted);
  EXPECT_EQ(control.admit("secret", "10.0.0.1", now + 61s), Control::Admission::granted);
}

TEST_F(WhoControls, IsNotBarredForAskingWithoutAToken) {
  Control control("secret", tell);
  const auto now = Control::Clock::now();
  for (int i = 0; i < 100; ++i) control.admit("", "10.0.0.1", now);
  EXPECT_EQ(control.admit("secret", "10.0.0.1", now), Control::Admission::granted);
}

}  // namespace
}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/stage.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <ctime>
#include <stdexcept>

#include "nadir/core/check.hpp"

namespace nadir::pipeline {
namespace {

using namespace std::chrono_literals;

std::function<bool()> count_into(Channel<int>& channel, int items) {
  return [&channel, items, next = 0]() mutable { return next < items && channel.push(next++); };
}

std::string message(const std::exception_ptr& fault) {
  try {
    if (fault) std::rethrow_exception(fault);
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

TEST(Stage, PassesTheEndDownTheFlow) {
  Channel<int> numbers(2, WhenFull::wait), squares(2, WhenFull::wait);
  Stage source("source", count_into(numbers, 1000), [&] { numbers.close(); });
  Stage square("square", {from(numbers, [&](int n) { squares.push(n * n); })},
               [&] { squares.close(); });
  int next = 0;
  while (const auto item = squares.pop()) {
    ASSERT_EQ(*item, next * next);
    ++next;
  }
  EXPECT_EQ(next, 1000);
  EXPECT_FALSE(source.join());
  EXPECT_FALSE(square.join());
  EXPECT_EQ(square.stats().processed, 1000u);
  EXPECT_EQ(square.stats().dropped, 0u);
  EXPECT_GT(square.stats().rate_out_hz, 0);
}

TEST(Stage, TellsHowLongItsItemTakes) {
  Channel<int> numbers(2, WhenFull::wait);
  std::atomic<bool> released = false;
  Stage stage("stage", {from(numbers, [&](int) { released.wait(false); })}, [] {});
  EXPECT_FALSE(stage.activity().busy);
  numbers.push(1);
  while (!stage.activity().busy || *stage.activity().busy < 30ms) std::this_thread::yield();
  const double cpu_s = stage.activity().cpu_s;
  std::this_thread::sleep_for(30ms);
  EXPECT_LT(stage.activity().cpu_s - cpu_s, 0.025);  // it sleeps; the clock ticks each 10 ms
  EXPECT_EQ(stage.activity().stage, "stage");
  released = true;
  released.notify_all();
  while (stage.activity().busy) std::this_thread::yield();
  numbers.close();
  stage.join();
  EXPECT_FALSE(stage.activity().busy);
}

TEST(Stage, BlamesTheOneThatIsWaitedFor) {
  Channel<int> numbers(4, WhenFull::wait), products(1, WhenFull::wait);
  std::atomic<bool> released = false;
  Stage slow("slow", {from(products, [&](int) { released.wait(false); })}, [] {});
  Stage quick("quick", {from(numbers, [&](int n) { products.push(n); })},
              [&] { products.close(); });
  for (int n = 0; n < 4; ++n) numbers.push(n);  // one is in hand, one waits, one finds no room
  const auto waits = [&] {
    const StageActivity at = quick.activity();
    return !at.busy && !at.neglects_input && numbers.depth() == 1;
  };
  while (!waits() || slow.activity().busy.value_or(0ns) < 30ms) std::this_thread::yield();
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(waits());
  released = true;
  released.notify_all();
  numbers.close();
}

TEST(Stage, TellsOfLongWorkThatItGoesOn) {
  Channel<int> numbers(1, WhenFull::wait);
  std::atomic<int> step = 0;
  Stage stage("stage",
              {from(numbers,
                    [&](int) {
                      step.wait(0);
                      note_progress();
                      step = 2;
                      step.notify_all();
                      step.wait(2);
                    })},
              [] {});
  numbers.push(1);
  while (stage.activity().busy.value_or(0ns) < 100ms) std::this_thread::yield();
  const auto resumed = std::chrono::steady_clock::now();
  step = 1;
  step.notify_all();
  step.wait(1);
  EXPECT_LE(stage.activity().busy.value_or(1h), std::chrono::steady_clock::now() - resumed);
  step = 3;
  step.notify_all();
  numbers.close();
}

TEST(Stage, CountsTheCpuTimeOfItsThread) {
  Channel<int> numbers(2, WhenFull::wait);
  const auto work_until_20_ms_are_used = [](int) {
    const std::clock_t begin = std::clock();
    while (std::clock() - begin < CLOCKS_PER_SEC / 50) {
    }
  };
  Stage worker("worker", {from(numbers, work_until_20_ms_are_used)}, [] {});
  EXPECT_LT(worker.stats().cpu_s, 0.01);
  numbers.push(1);
  numbers.close();
  worker.join();
  EXPECT_GT(worker.stats().cpu_s, 0.015);
}

TEST(Stage, FlushesWhatTheAlgorithmHeldBack) {
  Channel<int> numbers(2, WhenFull::wait), sums(1, WhenFull::wait);
  Stage source("source", count_into(numbers, 11), [&] { numbers.close(); });
  int sum = 0;
  Stage adder(
      "adder", {from(numbers, [&](int n) { sum += n; })}, [&] { sums.close(); },
      [&] { sums.push(sum); });
  EXPECT_EQ(sums.pop(), 55);
  EXPECT_EQ(sums.pop(), std::nullopt);
}

TEST(Stage, TakesFromSeveralInputsUntilAllHaveEnded) {
  const auto bell = std::make_shared<Bell>();
  Channel<int> small(1, WhenFull::wait, bell), large(16, WhenFull::wait, bell);
  int from_small = 0, from_large = 0;
  Stage sink("sink",
             {from(small, [&](int) { ++from_small; }), from(large, [&](int) { ++from_large; })},
             [] {});
  Stage one("one", count_into(small, 20'000), [&] { small.close(); });
  Stage other("other", count_into(large, 30'000), [&] { large.close(); });
  EXPECT_FALSE(sink.join());
  EXPECT_EQ(from_small, 20'000);
  EXPECT_EQ(from_large, 30'000);
}

TEST(Stage, TakesFirstFromTheInputListedFirst) {
  const auto bell = std::make_shared<Bell>();
  Channel<int> clouds(4, WhenFull::wait, bell), alerts(4, WhenFull::wait, bell);
  for (int i = 0; i < 4; ++i) clouds.push(i);
  alerts.push(100);
  clouds.close();
  alerts.close();
  std::vector<int> order;
  const auto note = [&](int n) { order.push_back(n); };
  Stage("sink", {from(alerts, note), from(clouds, note)}, [] {}).join();
  EXPECT_EQ(order, (std::vector<int>{100, 0, 1, 2, 3}));
}

TEST(Stage, RefusesInputsThatShareNoBell) {
  Channel<int> a(1, WhenFull::wait), b(1, WhenFull::wait);
  EXPECT_THROW(Stage("sink", {from(a, [](int) {}), from(b, [](int) {})}, [] {}), ContractError);
}

TEST(Stage, KeepsAnExceptionForItsOwnerWhileTheRestDrains) {
  Channel<int> numbers(1, WhenFull::wait), out(1, WhenFull::wait);
  bool flushed = false;
  Stage source(
      "source",
      [&, next = 0]() mutable {
        numbers.push(next++);
        return next < 100;
      },
      [&] { numbers.close(); });
  Stage broken(
      "broken",
      {from(numbers,
            [&](int n) {
              if (n == 3) throw std::runtime_error("no such plane");
              out.push(n);
            })},
      [&] { out.close(); }, [&] { flushed = true; });
  int received = 0;
  while (out.pop()) ++received;
  EXPECT_EQ(received, 3);
  EXPECT_EQ(message(broken.join()), "no such plane");
  EXPECT_FALSE(source.join());
  EXPECT_FALSE(flushed);
}

TEST(Stage, StopsNowThoughItsInputNeverEnds) {
  Channel<int> numbers(1, WhenFull::wait), out(1, WhenFull::wait);
  bool flushed = false, closed = false;
  Stage source(
      "source", [&] { return numbers.push(1); }, [&] { numbers.close(); });
  Stage middle(
      "middle", {from(numbers, [&](int n) { out.push(n); })}, [&] { closed = true; },
      [&] { flushed = true; });
  std::this_thread::sleep_for(10ms);  // both wait: nobody takes from out
  out.abandon();
  middle.stop();
  EXPECT_FALSE(middle.join());
  EXPECT_FALSE(source.join());
  EXPECT_TRUE(closed);
  EXPECT_FALSE(flushed);
}

TEST(Stage, StopsWhenDestroyedWhileItWaits) {
  Channel<int> numbers(1, WhenFull::wait);
  const Stage idle("idle", {from(numbers, [](int) {})}, [] {});
}

TEST(Stage, NamesItsThread) {
  Channel<int> numbers(1, WhenFull::wait);
  char name[16] = {};
  Stage stage("a-name-of-20-letters",
              {from(numbers, [&](int) { pthread_getname_np(pthread_self(), name, sizeof name); })},
              [] {});
  numbers.push(1);
  numbers.close();
  stage.join();
  EXPECT_STREQ(name, "a-name-of-20-le");
}

TEST(Stage, ReportsDepthAndDropsWhileItRuns) {
  Channel<int> numbers(2, WhenFull::drop), go(1, WhenFull::wait);
  Stage slow("slow", {from(numbers, [&](int) { go.pop(); })}, [] {});
  numbers.push(0);
  while (slow.stats().depth != 0) std::this_thread::yield();
  int refused = 0;
  for (int i = 0; i < 5; ++i) refused += numbers.push(i) ? 0 : 1;
  EXPECT_EQ(slow.stats().depth, 2u);
  EXPECT_EQ(slow.stats().dropped, static_cast<std::uint64_t>(refused));
  EXPECT_EQ(refused, 3);
  go.abandon();
  numbers.close();
  slow.join();
}

}  // namespace
}  // namespace nadir::pipeline

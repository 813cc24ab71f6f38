// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/stage.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <iterator>
#include <sstream>

#include "nadir/core/check.hpp"

namespace nadir::pipeline {
namespace {

constexpr std::size_t kThreadNameLength = 15;  // pthread_setname_np(3)

bool share_one_bell(const std::vector<Input>& inputs) {
  return std::ranges::all_of(
      inputs, [&](const Input& input) { return input.edge->bell() == inputs[0].edge->bell(); });
}

double thread_cpu_s() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

struct ThreadStatus {
  double cpu_s = 0;
  bool runnable = false;
};

// Of any thread of this process: its clock may be asked only while it is sure to run. proc(5): the
// name, in brackets, is the second field, then comes the state; user and system time are the 14th
// and 15th.
ThreadStatus status_of(int thread) {
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::size_t name_end = text.rfind(')');
  if (name_end == text.npos) return {};
  std::istringstream fields(text.substr(name_end + 1));
  std::string state, passed_over;
  fields >> state;
  for (int field = 4; field < 14; ++field) fields >> passed_over;
  double user = 0, system = 0;
  fields >> user >> system;
  return {(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK)), state == "R"};
}

}  // namespace

Stage::Stage(std::string name, std::vector<Input> inputs, std::function<void()> close,
             std::function<void()> flush)
    : name_(std::move(name)),
      inputs_(std::move(inputs)),
      close_(std::move(close)),
      flush_(std::move(flush)) {
  NADIR_CHECK(!inputs_.empty() && share_one_bell(inputs_), name_);
  thread_ = std::jthread([this] { run([this] { consume(); }); });
}

Stage::Stage(std::string name, std::function<bool()> produce_one, std::function<void()> close)
    : name_(std::move(name)), close_(std::move(close)) {
  thread_ = std::jthread([this, produce_one = std::move(produce_one)] {
    run([this, &produce_one] { produce(produce_one); });
  });
}

Stage::~Stage() { stop(); }

void Stage::stop() {
  stopped_ = true;
  for (const Input& input : inputs_) input.edge->abandon();
}

std::exception_ptr Stage::join() {
  if (thread_.joinable()) thread_.join();
  return fault_;
}

StageStats Stage::stats() const {
  const Meter::Reading reading = meter_.read(Meter::Clock::now(), arrived());
  StageStats stats;
  stats.stage = name_;
  stats.rate_in_hz = reading.rate_in_hz;
  stats.rate_out_hz = reading.rate_out_hz;
  stats.processed = reading.count;
  for (const Input& input : inputs_) {
    stats.depth += static_cast<std::uint32_t>(input.edge->depth());
    stats.dropped += input.edge->dropped();
  }
  stats.last_ms = reading.last_ms;
  stats.p95_ms = reading.p95_ms;
  stats.cpu_s = cpu_s_;
  return stats;
}

StageActivity Stage::activity() const {
  StageActivity activity;
  activity.stage = name_;
  const bool waits = progress_.waits_for_another();
  activity.busy = progress_.busy(Progress::Clock::now());
  const int thread = thread_id_;
  if (thread == 0) return activity;
  const ThreadStatus status = status_of(thread);
  activity.cpu_s = status.cpu_s;
  activity.wants_to_run = status.runnable;
  activity.neglects_input =
      !waits && !activity.busy &&
      std::ranges::any_of(inputs_, [](const Input& input) { return input.edge->depth() > 0; });
  activity.processed = meter_.read(Meter::Clock::now(), 0).count;
  return activity;
}

void Stage::run(const std::function<void()>& work) {
  pthread_setname_np(pthread_self(), name_.substr(0, kThreadNameLength).c_str());
  thread_id_ = gettid();
  Progress::of_this_thread() = &progress_;
  try {
    work();
    if (flush_ && !stopped_) flush_();
  } catch (...) {
    fault_ = std::current_exception();
  }
  for (const Input& input : inputs_) input.edge->abandon();
  close_();
  cpu_s_ = thread_cpu_s();
  progress_.end();
  thread_id_ = 0;
}

void Stage::measure(Meter::Clock::time_point begin) {
  progress_.end();
  meter_.add(begin, Meter::Clock::now(), arrived());
  cpu_s_ = thread_cpu_s();
}

void Stage::consume() {
  Bell& bell = *inputs_[0].edge->bell();
  while (!std::ranges::all_of(inputs_, [](const Input& input) { return input.edge->ended(); })) {
    bell.wait();
    const auto begun = progress_.begin();
    if (take_one()) measure(begun);
    progress_.end();
  }
}

bool Stage::take_one() {
  return std::ranges::any_of(inputs_, [](const Input& input) { return input.step(); });
}

void Stage::produce(const std::function<bool()>& produce_one) {
  while (!stopped_) {
    const auto begun = progress_.begin();
    if (!produce_one()) return;
    measure(begun);
  }
}

std::uint64_t Stage::arrived() const {
  if (inputs_.empty()) return 0;
  std::uint64_t sum = 0;
  for (const Input& input : inputs_) sum += input.edge->accepted() + input.edge->dropped();
  return sum;
}

}  // namespace nadir::pipeline

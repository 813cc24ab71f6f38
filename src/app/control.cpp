// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "control.hpp"

#include <pthread.h>

#include <utility>

#include "device_token.hpp"

namespace nadir::app {
namespace {

// A person mistypes a few times; a token has 2^256 values.
constexpr int kMostGuesses = 10;
constexpr auto kGuessPeriod = std::chrono::minutes(1);
constexpr std::size_t kMostCallers = 1000;  // remembered; who has more addresses is let forget

}  // namespace

Control::Control(std::string token, Tell tell, Clock::duration lapse)
    : token_(std::move(token)),
      tell_(std::move(tell)),
      lapse_(lapse),
      watch_([this](const std::stop_token& stop) { watch(stop); }) {}

Control::Admission Control::admit(std::string_view token, const std::string& caller,
                                  Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(guesses_,
                [&](const auto& guesses) { return now - guesses.second.since > kGuessPeriod; });
  const auto guesses = guesses_.find(caller);
  if (guesses != guesses_.end() && guesses->second.wrong >= kMostGuesses) return Admission::barred;
  if (is_same_token(token, token_)) return Admission::granted;
  // Without any it is no guess.
  if (!token.empty() && (guesses != guesses_.end() || guesses_.size() < kMostCallers)) {
    Guesses& of_caller = guesses_.try_emplace(caller, Guesses{0, now}).first->second;
    ++of_caller.wrong;
  }
  return Admission::wrong;
}

std::string Control::take(const std::string& session, const std::string& name, bool force) {
  const std::scoped_lock lock(mutex_);
  if (controller_ && controller_->session != session && !force) return controller_->name;
  set(Controller{session, name, Clock::now() + lapse_});
  return name;
}

bool Control::renew(const std::string& session) {
  const std::scoped_lock lock(mutex_);
  if (!controller_ || controller_->session != session) return false;
  controller_->until = Clock::now() + lapse_;
  return true;
}

bool Control::release(const std::string& session) {
  const std::scoped_lock lock(mutex_);
  if (!controller_ || controller_->session != session) return false;
  set(std::nullopt);
  return true;
}

std::optional<std::string> Control::controller() const {
  const std::scoped_lock lock(mutex_);
  return controller_ ? std::optional(controller_->name) : std::nullopt;
}

// The mutex is held, so that what is told keeps its order.
void Control::set(std::optional<Controller> controller) {
  const std::string before = controller_ ? controller_->name : "";
  controller_ = std::move(controller);
  changed_.notify_one();
  const std::string now = controller_ ? controller_->name : "";
  if (now != before) tell_(now);
}

void Control::watch(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "control");
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (!controller_) {
      changed_.wait(lock, stop, [this] { return controller_.has_value(); });
    } else if (controller_->until <= Clock::now()) {
      set(std::nullopt);
    } else {
      const auto until = controller_->until;
      changed_.wait_until(lock, stop, until, [this] { return !controller_; });
    }
  }
}

}  // namespace nadir::app

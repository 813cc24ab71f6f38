// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <pthread.h>

#include <chrono>
#include <csignal>

namespace nadir::app {
namespace {

sigset_t ending_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGHUP);
  return set;
}

}  // namespace

Interrupt::Interrupt() {
  const sigset_t set = ending_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  // A closed socket or pipe and a file grown too large are error codes, not the end.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  thread_ = std::jthread([this] { listen(); });
}

Interrupt::~Interrupt() {
  ending_ = true;
  pthread_kill(thread_.native_handle(), SIGINT);
}

void Interrupt::on_interrupt(std::function<void()> action) {
  action_ = std::make_shared<const std::function<void()>>(std::move(action));
  if (!received_) return;
  if (const auto now = action_.exchange(nullptr)) (*now)();
}

void Interrupt::listen() {
  pthread_setname_np(pthread_self(), "interrupt");
  const sigset_t set = ending_signals();
  int signal = 0;
  sigwait(&set, &signal);
  if (ending_) return;
  received_ = true;
  received_.notify_all();
  if (const auto action = action_.exchange(nullptr)) (*action)();
  // A second signal ends the process at once, as if it had never been caught; not one that comes
  // with the first, as when a shell signals a process and then its group.
  constexpr auto kEcho = std::chrono::seconds(1);
  const auto first = std::chrono::steady_clock::now();
  while (sigwait(&set, &signal) == 0 && !ending_) {
    if (std::chrono::steady_clock::now() - first < kEcho) continue;
    std::signal(signal, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
    raise(signal);
  }
}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Who may command this device, and which of them does: one page at a time. RFC 6750.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

namespace nadir::app {

class Control {
 public:
  using Clock = std::chrono::steady_clock;
  using Tell = std::function<void(const std::string& controller)>;

  /// tell: whenever who controls changes, their name, empty for nobody; by the thread that changed
  /// it or by one of its own, never by two at once. Without a word, control ends after `lapse`.
  Control(std::string token, Tell tell, Clock::duration lapse = std::chrono::seconds(60));

  const std::string& token() const { return token_; }

  enum class Admission {
    granted,
    wrong,   ///< not the token
    barred,  ///< wrong too often of late, from that address; the right one would not help either
  };
  Admission admit(std::string_view token, const std::string& caller, Clock::time_point now);

  /// Makes the session the one that controls, under this name; another's control only by force. Who
  /// then controls.
  std::string take(const std::string& session, const std::string& name, bool force);
  /// Whether the session controls, which it then goes on to do.
  bool renew(const std::string& session);
  /// Whether it did.
  bool release(const std::string& session);
  /// The name of who controls; none: nobody.
  std::optional<std::string> controller() const;

 private:
  struct Controller {
    std::string session, name;
    Clock::time_point until;
  };
  struct Guesses {
    int wrong = 0;
    Clock::time_point since;
  };
  void set(std::optional<Controller> controller);
  void watch(const std::stop_token& stop);

  const std::string token_;
  const Tell tell_;
  const Clock::duration lapse_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Controller> controller_;
  std::map<std::string, Guesses> guesses_;  ///< by address
  std::jthread watch_;                      ///< ends control that has lapsed
};

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// NADIR_CHECK: a broken contract is our bug and says where, with the values given.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace nadir {

/// Thrown by NADIR_CHECK only.
class ContractError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Bad input, configuration or environment. The message names what, where and the remedy.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// For Config::check(): what a setting's value must be, when it is not.
inline void require_setting(bool good, const char* setting, const char* range) {
  if (!good) throw InputError(std::string(setting) + " must be " + range + "; correct the setting");
}

template <class... Values>
[[noreturn]] void fail_contract(const char* condition, const char* file, int line,
                                const Values&... values) {
  std::ostringstream message;
  message << file << ':' << line << ": contract broken: " << condition;
  ((message << ' ' << values), ...);
  throw ContractError(message.str());
}

}  // namespace nadir

#define NADIR_CHECK(condition, ...)                                                      \
  do {                                                                                   \
    if (!(condition)) {                                                                  \
      ::nadir::fail_contract(#condition, __FILE__, __LINE__ __VA_OPT__(, ) __VA_ARGS__); \
    }                                                                                    \
  } while (false)

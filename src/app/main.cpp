// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>

#include "verbs.hpp"

namespace {

constexpr int kCouldNot = 1, kWrongCommandLine = 2;

}  // namespace

int main(int argc, char** argv) {
  try {
    const int status = std::visit([](const auto& command) { return nadir::app::run(command); },
                                  nadir::app::parse_command_line(argc, argv));
    return std::fflush(stdout) == 0 ? status : kCouldNot;
  } catch (const nadir::app::UsageError& error) {
    std::fprintf(stderr, "nadir: %s\n", error.what());
    return kWrongCommandLine;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "nadir: %s\n", error.what());
    return kCouldNot;
  }
}

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <malloc.h>

#include <cstdio>
#include <exception>

#include "verbs.hpp"

namespace {

constexpr int kCouldNot = 1, kWrongCommandLine = 2;

// Buffers of some megabytes come and go with every image. Were they given back to the system each
// time, a fifth of all CPU time would go into page faults. Larger ones would leave holes that
// nothing fills. What one thread frees another may take: with a heap for each they would keep half
// as much again.
void keep_freed_memory() {
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_THRESHOLD, 8 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
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

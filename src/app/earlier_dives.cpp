// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "earlier_dives.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/timex.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <optional>

#include "nadir/core/entries.hpp"
#include "nadir/record/recover.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX leaves it to the program

namespace nadir::app {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kBegin = "dive-";

std::optional<std::uint32_t> number_of(const fs::path& dive) {
  const std::string name = dive.filename().string();
  if (!name.starts_with(kBegin)) return std::nullopt;
  std::uint32_t number = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + kBegin.size(), end, number);
  const bool whole = error == std::errc() && (stop == end || *stop == '-');
  return whole ? std::optional(number) : std::nullopt;
}

std::vector<fs::path> folders_in(const fs::path& dives) {
  std::vector<fs::path> folders = entries_of(dives);
  std::error_code error;
  std::erase_if(folders, [&](const fs::path& entry) {
    const bool is_hidden = entry.filename().string().starts_with('.');  // being removed
    return is_hidden || !fs::is_directory(entry, error);
  });
  return folders;
}

bool has_journal(const fs::path& dive) {
  return std::ranges::any_of(entries_of(dive), [](const fs::path& entry) {
    const std::string name = entry.filename().string();
    return name.starts_with("journal-") && name.ends_with(".nadir");
  });
}

std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm broken_down{};
  gmtime_r(&now, &broken_down);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "-%Y%m%d-%H%M%S", &broken_down);
  return text.data();
}

// Runs `nadir recover DIVE`; none when it could not be started.
std::optional<pid_t> start_recovery(const fs::path& dive) {
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);  // a Ctrl-C is for us
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::string program = "nadir", verb = "recover", folder = dive.string();
  std::array<char*, 4> arguments{program.data(), verb.data(), folder.data(), nullptr};
  pid_t process = 0;
  const int error =
      posix_spawn(&process, "/proc/self/exe", nullptr, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    std::fprintf(stderr, "%s: recovery could not be started: %s\n", folder.c_str(),
                 std::strerror(error));
    return std::nullopt;
  }
  constexpr int kLowest = 19;
  setpriority(PRIO_PROCESS, static_cast<id_t>(process), kLowest);
  // Of both it is the one to go when memory is short: it is done again.
  std::ofstream("/proc/" + std::to_string(process) + "/oom_score_adj") << 1000;
  return process;
}

void recover_all(const std::stop_token& stop, const std::vector<fs::path>& dives) {
  pthread_setname_np(pthread_self(), "recover");
  for (const fs::path& dive : dives) {
    if (stop.stop_requested()) return;
    const std::optional<pid_t> process = start_recovery(dive);
    if (!process) continue;
    const std::stop_callback end(stop, [&] { ::kill(*process, SIGTERM); });
    int status = 0;
    while (::waitpid(*process, &status, 0) < 0 && errno == EINTR) {
    }
  }
}

}  // namespace

bool clock_is_set() {
  std::error_code none;
  if (fs::exists("/run/systemd/timesync/synchronized", none)) return true;
  timex state{};
  const int known = adjtimex(&state);  // may not be asked from within the service
  return known >= 0 && known != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
}

fs::path new_dive(const fs::path& dives) {
  std::uint32_t highest = 0;
  for (const fs::path& folder : folders_in(dives))
    highest = std::max(highest, number_of(folder).value_or(0));
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "%s%04u", kBegin.data(), highest + 1);
  return dives / (name.data() + (clock_is_set() ? time_of_day() : ""));
}

std::vector<fs::path> unfinished_dives(const fs::path& dives) {
  std::vector<fs::path> folders = folders_in(dives);
  std::erase_if(folders, [](const fs::path& folder) {
    return record::is_complete(folder) || !has_journal(folder);
  });
  std::ranges::sort(folders);
  return folders;
}

Recoveries::Recoveries(std::vector<fs::path> dives)
    : thread_(
          [dives = std::move(dives)](const std::stop_token& stop) { recover_all(stop, dives); }) {}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "nadir/core/check.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX leaves it to the program

namespace nadir::capture {
namespace {

struct Pipe {
  int from = -1, to = -1;
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0)
      throw InputError(std::string("no pipe to another program: ") + std::strerror(errno));
    from = ends[0];
    to = ends[1];
  }
};

/// What a new process begins with: nothing to read, and its outputs in pipes.
class Start {
 public:
  Start(const Pipe& output, const Pipe& errors) {
    posix_spawn_file_actions_init(&files_);
    posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files_, output.to, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files_, errors.to, STDERR_FILENO);
    // Of ours it shall inherit neither blocked signals nor ignored ones.
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    // A Ctrl-C is for us, who end it in our own time.
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~Start() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  Start(const Start&) = delete;
  Start& operator=(const Start&) = delete;

  int spawn(pid_t& process, std::vector<char*>& arguments) const {
    return posix_spawnp(&process, arguments.front(), &files_, &attributes_, arguments.data(),
                        environ);
  }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  std::vector<std::string> words = command;
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const Pipe output, errors;
  const int error = Start(output, errors).spawn(process_, arguments);
  close(output.to);
  close(errors.to);
  output_ = output.from;
  errors_ = errors.from;
  if (error != 0) {
    process_ = -1;
    end();
    throw InputError(command.front() + ": " + std::strerror(error));
  }
  fcntl(errors_, F_SETFL, O_NONBLOCK);
}

ChildProcess::~ChildProcess() { end(); }

// False when there will be no more.
bool ChildProcess::fill_lines() {
  constexpr std::size_t kMostLines = 1000, kLongest = 4096;
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t size = ::read(errors_, buffer.data(), buffer.size());
    if (size == 0) return false;
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    for (const char c : std::string_view(buffer.data(), static_cast<std::size_t>(size))) {
      if (c != '\n' && c != '\r') {
        if (partial_line_.size() < kLongest) partial_line_ += c;
        continue;
      }
      if (!partial_line_.empty()) lines_.push_back(std::exchange(partial_line_, {}));
      if (lines_.size() > kMostLines) lines_.pop_front();
    }
  }
}

bool ChildProcess::read(std::span<std::uint8_t> bytes, std::chrono::milliseconds patience) {
  bool more_errors = true;
  while (!bytes.empty()) {
    std::array<pollfd, 2> ready{{{output_, POLLIN, 0}, {more_errors ? errors_ : -1, POLLIN, 0}}};
    const int count = poll(ready.data(), ready.size(), static_cast<int>(patience.count()));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    if (ready[1].revents != 0) more_errors = fill_lines();
    if (ready[0].revents == 0) continue;
    const ssize_t size = ::read(output_, bytes.data(), bytes.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
  return true;
}

std::optional<std::string> ChildProcess::next_line() {
  if (errors_ >= 0) fill_lines();
  if (lines_.empty()) return std::nullopt;
  std::string line = std::move(lines_.front());
  lines_.pop_front();
  return line;
}

std::optional<int> ChildProcess::end() {
  std::optional<int> result;
  if (output_ >= 0) close(std::exchange(output_, -1));
  if (process_ >= 0) {
    // One that has ended its output ends by itself, most likely; it is not waited for long.
    int status = 0;
    constexpr int kTries = 100;
    constexpr useconds_t kPause = 10'000;
    pid_t ended = waitpid(process_, &status, WNOHANG);
    for (int i = 0; i < kTries && ended == 0; ++i) {
      usleep(kPause);
      ended = waitpid(process_, &status, WNOHANG);
    }
    if (ended == 0) {
      kill(process_, SIGKILL);
      waitpid(process_, &status, 0);
    }
    if (ended > 0 && WIFEXITED(status)) result = WEXITSTATUS(status);
    process_ = -1;
  }
  if (errors_ >= 0) {
    fill_lines();
    close(std::exchange(errors_, -1));
  }
  return result;
}

}  // namespace nadir::capture

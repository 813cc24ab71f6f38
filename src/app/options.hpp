// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The command line, read and checked; no verb is run here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace nadir::app {

/// How fast images come: a replay's by choice, those of a camera as it takes them.
struct Rate {
  enum class Kind { max, recorded, fixed, live };
  Kind kind = Kind::max;
  double hz = 0;  ///< of Kind::fixed
};

/// host empty: the configured one.
struct Address {
  std::string host;
  std::uint16_t port = 0;
};

struct Settings {
  std::optional<std::filesystem::path> file;
  std::vector<std::string> assignments;  ///< room.key=value, applied after the file
};

struct Replay {
  std::filesystem::path folder, dive;
  std::optional<std::filesystem::path> calibration;
  std::optional<std::filesystem::path> poses, colmap;  ///< in place of odometry; one at most
  Settings settings;
  std::optional<Address> serve;
  bool keep_serving = false;
  Rate rate;
};

struct Run {
  Settings settings;
  std::optional<Address> serve;
};

struct Doctor {
  Settings settings;
};

struct ShowToken {
  Settings settings;
};

struct Simulate {
  std::filesystem::path folder;
  std::string scene = "pool";
  std::optional<int> images;
  bool stereo = false;
  std::uint64_t seed = 1;
};

struct Recover {
  std::filesystem::path dive;
};

struct CheckCalibration {
  std::filesystem::path folder;
  std::optional<std::filesystem::path> calibration;
  Settings settings;
};

struct DumpConfig {
  Settings settings;
};

/// The line was answered already (help, version) or was wrong: print nothing more, exit with this
/// status.
struct Answered {
  int status = 0;
};

/// What only shows itself wrong when a verb looks closer is a wrong command line all the same: exit
/// status 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using Command = std::variant<Answered, DumpConfig, Run, Doctor, ShowToken, Replay, Simulate,
                             Recover, CheckCalibration>;

/// Exit status 2 for a wrong command line, with what is wrong on standard error.
Command parse_command_line(int argc, const char* const* argv);

}  // namespace nadir::app

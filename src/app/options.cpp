// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <iostream>

#include "version.hpp"

namespace nadir::app {
namespace {

constexpr int kWrongCommandLine = 2;

std::optional<Rate> parse_rate(const std::string& text) {
  if (text == "max") return Rate{};
  if (text == "recorded") return Rate{Rate::Kind::recorded, 0};
  Rate rate{Rate::Kind::fixed, 0};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate.hz);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && rate.hz > 0 && rate.hz <= 1000 ? std::optional(rate) : std::nullopt;
}

// host:port, [IPv6]:port or :port
std::optional<Address> parse_address(const std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  Address address{text.substr(0, colon), 0};
  const char* const end_of_text = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data() + colon + 1, end_of_text, address.port);
  if (error != std::errc() || end != end_of_text) return std::nullopt;
  std::string& host = address.host;
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  return address;
}

std::string not_empty(const std::string& text) { return text.empty() ? "is empty" : ""; }

void add_settings(CLI::App& app, Settings& settings) {
  app.add_option("--config", settings.file, "TOML file of settings; see --dump-config")
      ->type_name("FILE");
  app.add_option("--set", settings.assignments, "one setting, over the file's; may be repeated")
      ->type_name("ROOM.KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
}

void add_address(CLI::Option& option) {
  option.type_name("ADDRESS")->check([](const std::string& text) {
    return parse_address(text) ? std::string()
                               : "'" + text + "' is not host:port, as 0.0.0.0:8765 is";
  });
}

void describe_run(CLI::App& verb, Run& run, std::string& address) {
  add_settings(verb, run.settings);
  add_address(*verb.add_option("--serve", address,
                               "the page's address, host:port; default: serve.address and port"));
  verb.footer(
      "Waits for the cameras of capture.camera, maps into a new folder of record.dives, and makes\n"
      "the files of dives that were cut off. As nadir.service it starts with the computer.");
}

void describe_replay(CLI::App& verb, Replay& replay, std::string& address, std::string& rate) {
  verb.add_option("FOLDER", replay.folder,
                  "survey folder, a bare folder of images, or a video file")
      ->required();
  verb.add_option("--out", replay.dive, "dive folder to make; must not exist or be empty")
      ->type_name("DIVE")
      ->required()
      ->check(not_empty);
  verb.add_option("--calib", replay.calibration, "camera file, over the folder's calib.yml")
      ->type_name("FILE");
  auto* poses =
      verb.add_option("--poses", replay.poses,
                      "camera poses in place of odometry: a TUM trajectory in metres, matched to "
                      "the images by time; its frame is the survey's if cameras look down in it")
          ->type_name("FILE")
          ->check(not_empty);
  verb.add_option("--colmap", replay.colmap,
                  "the same from the images.txt of a COLMAP text model, matched by file name; "
                  "metres only with a pair. The lens is not read: --calib FOLDER/cameras.txt does")
      ->type_name("FOLDER")
      ->check(not_empty)
      ->excludes(poses);
  add_settings(verb, replay.settings);
  auto* serve = verb.add_option("--serve", address, "show the map at http://ADDRESS, host:port");
  add_address(*serve);
  verb.add_flag("--no-serve")->description("no page (the default)")->excludes(serve);
  verb.add_flag("--keep-serving", replay.keep_serving,
                "go on serving after the last image, until interrupted")
      ->needs(serve);
  verb.add_option("--rate", rate,
                  "images per second, 'recorded' or 'max'; max waits and loses nothing")
      ->type_name("HZ|recorded|max")
      ->default_str("max")
      ->check([](const std::string& text) {
        return parse_rate(text)
                   ? std::string()
                   : "'" + text + "' is none of: a rate in Hz up to 1000, recorded, max";
      });
}

void describe_simulate(CLI::App& verb, Simulate& simulate) {
  verb.add_option("--out", simulate.folder, "survey folder to make; must not exist or be empty")
      ->type_name("FOLDER")
      ->required()
      ->check(not_empty);
  verb.add_option("--scene", simulate.scene)
      ->check(CLI::IsMember({"pool", "transect", "reef", "wreck"}))
      ->capture_default_str();
  verb.add_option("--images", simulate.images, "how many; default by scene")
      ->check(CLI::Range(1, 10000));
  verb.add_flag("--stereo", simulate.stereo, "pairs instead of single images");
  verb.add_option("--seed", simulate.seed, "the same seed makes the same bytes")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

void describe_check(CLI::App& verb, CheckCalibration& check) {
  verb.add_option("FOLDER", check.folder, "survey folder, a bare folder of images, or a video file")
      ->required();
  verb.add_option("--calib", check.calibration, "camera file, over the folder's calib.yml")
      ->type_name("FILE");
  add_settings(verb, check.settings);
  verb.footer("Exit status 0 when the calibration fits, 1 when it does not or cannot be checked.");
}

}  // namespace

Command parse_command_line(int argc, const char* const* argv) {
  CLI::App app("nadir: a live seabed map from underwater images", "nadir");
  Run live;
  Doctor doctor;
  ShowToken show_token;
  Replay replay;
  Simulate simulate;
  Recover recover;
  CheckCalibration check;
  DumpConfig dump;
  std::string rate = "max", address;

  app.set_version_flag("--version", std::string("nadir ") + kVersion);
  bool dump_config = false;
  app.add_flag("--dump-config", dump_config, "print every setting with its value and unit as TOML");
  add_settings(app, dump.settings);
  auto* run_verb = app.add_subcommand("run", "map what the cameras see, until told to stop");
  describe_run(*run_verb, live, address);
  auto* doctor_verb =
      app.add_subcommand("doctor", "test cameras, sensors, disk, clock and page before a dive");
  add_settings(*doctor_verb, doctor.settings);
  doctor_verb->footer(
      "Without --config it takes the settings of the service, /etc/nadir/nadir.toml.\n"
      "Exit status 0 when a dive can be mapped, 1 when something is bad.");
  auto* token_verb = app.add_subcommand(
      "token", "show the token with which a page may command this device, and how it gets it");
  add_settings(*token_verb, show_token.settings);
  token_verb->footer(
      "Without --config it takes the settings of the service, /etc/nadir/nadir.toml.");
  auto* replay_verb =
      app.add_subcommand("replay", "map a folder of images or a video into a dive folder");
  describe_replay(*replay_verb, replay, address, rate);
  auto* simulate_verb =
      app.add_subcommand("simulate", "make a survey folder of a synthetic seabed with exact truth");
  describe_simulate(*simulate_verb, simulate);
  auto* recover_verb =
      app.add_subcommand("recover", "make the files of an interrupted dive from its journal");
  recover_verb->add_option("DIVE", recover.dive, "dive folder")->required();
  auto* check_verb = app.add_subcommand("check-calibration",
                                        "tell whether a calibration fits the images taken with it");
  describe_check(*check_verb, check);
  std::string topic;
  auto* help_verb = app.add_subcommand("help", "explain a verb");
  help_verb->add_option("VERB", topic)
      ->check(CLI::IsMember({"run", "doctor", "token", "replay", "simulate", "recover",
                             "check-calibration", "help"}));
  app.require_subcommand(0, 1);

  try {
    app.parse(argc, argv);
    if (!dump_config && app.get_subcommands().empty()) {
      throw CLI::RequiredError(
          "a verb: run, doctor, token, replay, simulate, recover, check-calibration or help");
    }
    if (!dump_config && (dump.settings.file || !dump.settings.assignments.empty())) {
      throw CLI::ValidationError("--config and --set stand behind the verb");
    }
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);
    return Answered{status == 0 ? 0 : kWrongCommandLine};
  }
  if (dump_config) return dump;
  if (*help_verb) {
    std::cout << (topic.empty() ? app.help() : app.get_subcommand(topic)->help());
    return Answered{0};
  }
  if (*run_verb) {
    if (!address.empty()) live.serve = parse_address(address);
    return live;
  }
  if (*doctor_verb) return doctor;
  if (*token_verb) return show_token;
  if (*simulate_verb) return simulate;
  if (*recover_verb) return recover;
  if (*check_verb) return check;
  replay.rate = *parse_rate(rate);
  if (!address.empty()) replay.serve = parse_address(address);
  return replay;
}

}  // namespace nadir::app

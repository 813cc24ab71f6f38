// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "config_file.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <sstream>

#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

std::string place(const std::string& name, const toml::source_region& region) {
  return name + ':' + std::to_string(region.begin.line) + ':' + std::to_string(region.begin.column);
}

Value value_of(const toml::node& node, const std::string& where) {
  if (const auto* value = node.as_boolean()) return value->get();
  if (const auto* value = node.as_integer()) return value->get();
  if (const auto* value = node.as_floating_point()) return value->get();
  if (const auto* value = node.as_string()) return value->get();
  throw InputError(where + ": a setting is a number, true, false or a text in quotes");
}

void read_table(const toml::table& table, const std::string& name, Config& config) {
  for (const auto& [room, node] : table) {
    const toml::table* keys = node.as_table();
    if (!keys) {
      throw InputError(place(name, node.source()) + ": '" + std::string(room.str()) +
                       "' stands alone; settings belong below a [room]");
    }
    for (const auto& [key, setting] : *keys) {
      const std::string where = place(name, setting.source());
      assign(config, std::string(room.str()) + '.' + std::string(key.str()),
             value_of(setting, where), where);
    }
  }
}

toml::table parse(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw InputError(place(name, error.source()) + ": " + std::string(error.description()));
  }
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& fault) {
  throw InputError(file.string() + ": " + fault + "; check the name given to --config");
}

std::string contents_of(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMostBytes = 1 << 20;
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(file, error);
  if (error) refuse(file, error.message());
  if (!is_file) refuse(file, "is not a file");
  if (std::filesystem::file_size(file, error) > kMostBytes)
    refuse(file, "has more than 1 MB and is no file of settings");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse(file, std::string("cannot be read: ") + std::strerror(errno));
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// The parser goes one step deeper with every dot of a key.
void check_lines(std::string_view text, const std::string& name) {
  constexpr std::size_t kLongest = 4096;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > kLongest) {
      throw InputError(name + ':' + std::to_string(line) +
                       ": the line has more than 4096 characters and is no setting");
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

// The shortest digits that read back as the same number; a float in TOML has a point or an
// exponent.
std::string as_toml(double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.begin(), digits.end(), value).ptr;
  std::string text(digits.begin(), end);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string as_toml(const Value& value) {
  if (const double* number = std::get_if<double>(&value)) return as_toml(*number);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  std::visit([&](const auto& v) { text << toml::value(v); }, value);
  return text.str();
}

}  // namespace

void read_config_file(const std::filesystem::path& file, Config& config) {
  const std::string text = contents_of(file);
  check_lines(text, file.string());
  read_table(parse(text, file.string()), file.string(), config);
}

void read_assignment(const std::string& assignment, Config& config) {
  const std::string where = "--set " + assignment;
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || assignment.find('\n') != std::string::npos) {
    throw InputError(where + ": the form is room.key=value");
  }
  const std::string text = assignment.substr(equals + 1);
  Value value = text;
  try {
    const toml::table table = toml::parse("value = " + text);
    value = value_of(*table.get("value"), where);
  } catch (const toml::parse_error&) {
    // a bare word, such as an address or a choice
  }
  assign(config, assignment.substr(0, equals), value, where);
}

std::string dump(const Config& config) {
  std::ostringstream text;
  std::string room;
  for (const Setting& setting : settings()) {
    const auto dot = setting.key.find('.');
    if (setting.key.substr(0, dot) != room) {
      text << (room.empty() ? "" : "\n");
      room = setting.key.substr(0, dot);
      text << '[' << room << "]\n";
    }
    text << setting.key.substr(dot + 1) << " = " << as_toml(setting.get(config)) << "  # "
         << setting.meaning << '\n';
  }
  return text.str();
}

}  // namespace nadir::app

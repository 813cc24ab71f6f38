// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "config.hpp"

#include <algorithm>
#include <numeric>

#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

// Levenshtein distance, for the nearest neighbour of a misspelt key.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

template <class T>
T converted(const Value& value) {
  if constexpr (std::is_same_v<T, bool>) {
    if (const bool* v = std::get_if<bool>(&value)) return *v;
    throw InputError("wants true or false");
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (const auto* v = std::get_if<std::string>(&value)) return *v;
    throw InputError("wants a text in quotes");
  } else if constexpr (std::is_integral_v<T>) {
    const auto* v = std::get_if<std::int64_t>(&value);
    if (!v) throw InputError("wants a whole number");
    if (!std::in_range<T>(*v)) throw InputError("wants a smaller number");
    return static_cast<T>(*v);
  } else {
    if (const auto* v = std::get_if<double>(&value)) return static_cast<T>(*v);
    if (const auto* v = std::get_if<std::int64_t>(&value)) return static_cast<T>(*v);
    throw InputError("wants a number");
  }
}

template <class T>
Value shown(const T& field) {
  if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, std::string>) {
    return field;
  } else if constexpr (std::is_integral_v<T>) {
    return static_cast<std::int64_t>(field);
  } else {
    return static_cast<double>(field);
  }
}

// room: the member of Config; field: the member of the room's Config.
template <class Room, class T>
Setting setting(std::string key, Room Config::*room, T Room::*field, std::string meaning) {
  return {std::move(key), std::move(meaning),
          [=](const Config& config) { return shown(config.*room.*field); },
          [=](Config& config, const Value& value) { config.*room.*field = converted<T>(value); }};
}

template <class Room, class T>
Setting choice(std::string key, Room Config::*room, T Room::*field,
               std::vector<std::pair<std::string, T>> choices, std::string meaning) {
  const auto get = [=](const Config& config) -> Value {
    for (const auto& [name, value] : choices) {
      if (value == config.*room.*field) return name;
    }
    return std::string("?");
  };
  const auto set = [=](Config& config, const Value& given) {
    std::string names;
    for (const auto& [name, value] : choices) {
      if (given == Value(name)) {
        config.*room.*field = value;
        return;
      }
      names += (names.empty() ? "" : ", ") + name;
    }
    throw InputError("wants one of: " + names);
  };
  return {std::move(key), std::move(meaning), get, set};
}

std::vector<Setting> make_settings() { return {SETTINGS_GO_HERE}; }

}  // namespace

void Config::check() const {
  capture.check();
  odometry.check();
  reference.check();
  plane.check();
  mosaic2d.check();
  projection3d.check();
  record.check();
  serve.check();
}

const std::vector<Setting>& settings() {
  static const std::vector<Setting> table = make_settings();
  return table;
}

void assign(Config& config, const std::string& key, const Value& value, const std::string& where) {
  const std::vector<Setting>& table = settings();
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Setting& s) { return s.key == key; });
  if (found == table.end()) {
    const auto nearest =
        std::min_element(table.begin(), table.end(), [&](const Setting& a, const Setting& b) {
          return edit_distance(a.key, key) < edit_distance(b.key, key);
        });
    throw InputError(where + ": there is no setting '" + key + "'; did you mean '" + nearest->key +
                     "'?");
  }
  try {
    found->set(config, value);
  } catch (const InputError& error) {
    throw InputError(where + ": " + key + ' ' + error.what());
  }
}

}  // namespace nadir::app

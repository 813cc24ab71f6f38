// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Why a camera cannot be opened, and how the program is told.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <string>

#include "libcamera_plugin.h"

namespace nadir::capture::plugin {

/// Why a camera cannot be opened.
struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline std::string failure(const std::string& what, int error) {
  return what + ": " + std::strerror(std::abs(error));
}

inline void write_text(NadirText& to, const std::string& text) {
  const std::size_t size = std::min(text.size(), sizeof to.text - 1);
  std::copy_n(text.data(), size, std::begin(to.text));
  to.text[size] = 0;
}

}  // namespace nadir::capture::plugin

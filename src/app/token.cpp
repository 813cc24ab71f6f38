// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <qrencode.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>

#include "configured.hpp"
#include "desk.hpp"
#include "device_token.hpp"
#include "dive_course.hpp"
#include "verbs.hpp"

namespace nadir::app {
namespace {

constexpr int kQuiet = 2;  // modules of margin; the standard has four, readers do with two

// Two modules a character, the light ones drawn on black.
std::string as_qr_code(const std::string& text) {
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_L), &QRcode_free);
  if (!code) return {};
  const auto is_light = [&](int row, int column) {
    const bool inside = row >= 0 && row < code->width && column >= 0 && column < code->width;
    return !inside || (code->data[row * code->width + column] & 1) == 0;
  };
  std::string lines;
  for (int row = -kQuiet; row < code->width + kQuiet; row += 2) {
    lines += "\x1b[97;40m";
    for (int column = -kQuiet; column < code->width + kQuiet; ++column) {
      const bool upper = is_light(row, column), lower = is_light(row + 1, column);
      lines += upper && lower ? "\u2588" : upper ? "\u2580" : lower ? "\u2584" : " ";
    }
    lines += "\x1b[0m\n";
  }
  return lines;
}

}  // namespace

int run(const ShowToken& verb) {
  const Config config = configured(settings_of_service(verb.settings));
  const std::string token = read_token(token_file(config.record.dives));
  const serve::Config serving = with_usable_certificate(config.serve);
  const std::string here = page_url(serving, serving.port) + '/';
  const std::string url = url_for_others(serving).value_or(here) + "#token=" + token;
  std::printf("%s\n%s\n", token.c_str(), url.c_str());
  if (::isatty(STDOUT_FILENO) == 1) std::fputs(as_qr_code(url).c_str(), stdout);
  return 0;
}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <opencv2/core/utility.hpp>

#include "board_check.hpp"
#include "configured.hpp"
#include "self_test.hpp"
#include "verbs.hpp"

namespace nadir::app {
namespace {

const char* in_words(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "good";
    case Verdict::doubtful:
      return "DOUBTFUL";
    case Verdict::bad:
      return "BAD";
    case Verdict::absent:
      return "-";
  }
  return "?";
}

}  // namespace

int run(const Doctor& verb) {
  using namespace std::chrono_literals;
  const Settings settings = settings_of_service(verb.settings);
  const Config config = configured(settings);
  std::printf("settings: %s\n", settings.file ? settings.file->c_str() : "none, as nadir has them");
  cv::setNumThreads(1);
  bool bad = false;
  const auto print = [&](const std::vector<Finding>& findings) {
    for (const Finding& finding : findings) {
      bad = bad || finding.verdict == Verdict::bad;
      std::printf("%-9s %s: %s%s%s\n", in_words(finding.verdict), finding.item.c_str(),
                  finding.found.c_str(), finding.remedy.empty() ? "" : "; ",
                  finding.remedy.c_str());
    }
    std::fflush(stdout);
  };
  print(check_cameras(config, 8s));
  print(check_sensors(config.sensors, 6s));
  print({check_disk_speed(config.record.dives)});
  print(check_board(board_load("/sys", config.record.dives)));
  print({check_clock()});
  print(check_https(config.serve));
  print({check_page(config.serve)});
  return bad ? 1 : 0;
}

}  // namespace nadir::app

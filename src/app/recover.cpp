// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/recover.hpp"

#include <cstdio>

#include "verbs.hpp"

namespace nadir::app {

int run(const Recover& verb) {
  const record::Recovery found = record::recover(verb.dive);
  std::printf("%s: %llu images recorded, %llu oriented, %llu lost, %llu dropped%s\n",
              verb.dive.c_str(), static_cast<unsigned long long>(found.captured),
              static_cast<unsigned long long>(found.oriented),
              static_cast<unsigned long long>(found.lost),
              static_cast<unsigned long long>(found.dropped),
              found.cut_off ? "; the recording was cut off" : "");
  if (found.made.empty()) std::puts("nothing to make: every file that can be made is there");
  for (const std::string& file : found.made) std::printf("made %s\n", file.c_str());
  for (const std::string& file : found.damaged) std::printf("damaged: %s\n", file.c_str());
  if (found.missing_records > 0) {
    std::printf("damaged: %llu records of the journal\n",
                static_cast<unsigned long long>(found.missing_records));
  }
  return found.whole() ? 0 : 1;
}

}  // namespace nadir::app

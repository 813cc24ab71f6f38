// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>
#include <cstdio>

#include "nadir/simulate/write_survey.hpp"
#include "verbs.hpp"

namespace nadir::app {
int run(const Simulate& simulate) {
  simulate::Options options;
  options.scene = *simulate::scene_from(simulate.scene);  // the command line knows its scenes
  if (simulate.images) options.images = *simulate.images;
  options.stereo = simulate.stereo;
  options.seed = simulate.seed;
  options.check();
  const bool terminal = isatty(fileno(stderr)) == 1;
  simulate::write_survey(simulate.folder, options, [&](int done, int total) {
    if (terminal)
      std::fprintf(stderr, "\r\033[K%d of %d images%s", done, total, done == total ? "\n" : "");
  });
  std::fprintf(stderr, "%s: simulated %s\n", simulate.folder.c_str(), simulate.scene.c_str());
  return 0;
}

}  // namespace nadir::app

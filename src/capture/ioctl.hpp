// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// ioctl(2), begun again when a signal comes between. A driver in trouble lets call by call wait.
#pragma once

#include <sys/ioctl.h>

#include <cerrno>

#include "nadir/pipeline/progress.hpp"

namespace nadir::capture {

/// As ioctl: 0, or -1 with errno.
template <class Argument>
int control(int file, unsigned long request, Argument& argument) {
  int result = 0;
  do {
    result = ::ioctl(file, request, &argument);
  } while (result < 0 && errno == EINTR);
  pipeline::note_progress();
  return result;
}

}  // namespace nadir::capture

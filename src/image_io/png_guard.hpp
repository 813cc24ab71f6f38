// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// libpng reports errors by longjmp: only plain data may live in the frames it leaves.
#pragma once

#include <png.h>

#include <csetjmp>

namespace nadir::image_io {

/// Runs the step; false when libpng left it by an error. The step owns nothing with a destructor.
template <class Step>
[[nodiscard]] bool png_guarded(png_structp png, const Step& step) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  step();
  return true;
}

/// An error message kept for the caller; the first one wins.
struct PngFault {
  char text[96] = "";
};

/// For png_create_*_struct with a PngFault as its error pointer.
[[noreturn]] inline void png_on_error(png_structp png, png_const_charp message) {
  auto* fault = static_cast<PngFault*>(png_get_error_ptr(png));
  for (std::size_t i = 0; i + 1 < sizeof fault->text && message[i] != '\0'; ++i) {
    fault->text[i] = message[i];
    fault->text[i + 1] = '\0';
  }
  png_longjmp(png, 1);
}

inline void png_on_warning(png_structp, png_const_charp) {}

}  // namespace nadir::image_io

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the program and a plugin that is linked to libcamera say to each other. In C, because each
// may be built by another compiler: libcamera changes its soname with every release, the program
// does not.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Raised with every change of this file; a plugin of another number is not used.
#define NADIR_LIBCAMERA_ABI 2u

/// Ended by a zero.
struct NadirText {
  char text[1024];
};

struct NadirCameraWanted {
  const char* id;  ///< libcamera's, or the end of just one; "auto": the only camera
  int32_t width, height;
  double rate_hz;           ///< at least; 0: the fastest
  double exposure_ms;       ///< 0: steered by expose(), or by the camera itself if it cannot be
  double gain;              ///< of the sensor, 1 and more; -1: likewise
  double focus;             ///< in dioptres; -1: as it stands
  const uint32_t* formats;  ///< that can be read, by V4L2's codes, the best first
  size_t format_count;
};

/// What a camera can be set to, how soon, and how it is set now.
struct NadirExposing {
  int steered;  ///< by expose(); 0: by the camera itself or fixed, and the rest is 0
  int delay;    ///< pictures from expose() to its effect, at most
  double shortest_ms, longest_ms;
  double least_gain, most_gain;  ///< equal: fixed
  double ms, gain;
};

struct NadirCameraOpened {
  void* camera;  ///< null: see fault
  struct NadirText fault;
  struct NadirText remarks;  ///< what it would not be set to, a line each
  int descriptor;            ///< for poll(2): readable when there is something to take
  uint32_t format;           ///< one of those wanted
  size_t stride;             ///< bytes from row to row
  double rate_hz;            ///< 0: unknown
  struct NadirExposing exposing;
};

struct NadirCameraPicture {
  int64_t time_ns;       ///< CLOCK_MONOTONIC
  uint32_t lost_before;  ///< by libcamera's count
  const char* fault;     ///< why it cannot be used; null when whole
  const uint8_t* bytes;  ///< planes one after the other
  size_t size;
  void* buffer;  ///< to be given back
};

enum NadirCameraTaken { NADIR_TAKEN_NOTHING, NADIR_TAKEN_PICTURE, NADIR_TAKEN_GONE };

/// Calls for one camera come one at a time. None waits for pictures, none throws.
struct NadirLibcameraPlugin {
  uint32_t abi;         ///< NADIR_LIBCAMERA_ABI
  const char* version;  ///< libcamera's
  /// Begins to stream.
  void (*open)(const struct NadirCameraWanted* wanted, struct NadirCameraOpened* opened);
  /// The next picture, or that the camera has ended and why, or nothing yet.
  enum NadirCameraTaken (*take)(void* camera, struct NadirCameraPicture* picture,
                                struct NadirText* gone);
  /// The camera fills it again; also after stop().
  void (*give_back)(void* camera, void* buffer);
  /// From one of the next pictures on, within what it can be set to. Of a steered camera only.
  void (*expose)(void* camera, double ms, double gain);
  /// Ends the stream and leaves the camera to others, within seconds even when it hangs. The bytes
  /// of pictures not given back yet stay.
  void (*stop)(void* camera);
  /// After stop(), with all pictures given back.
  void (*close)(void* camera);
};

/// The one function of a plugin, and its name for dlsym(3).
__attribute__((visibility("default"))) const struct NadirLibcameraPlugin* nadir_libcamera_plugin(
    void);
#define NADIR_LIBCAMERA_ENTRY "nadir_libcamera_plugin"

#ifdef __cplusplus
}
#endif

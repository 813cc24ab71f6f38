// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A plugin without libcamera: two grey cameras that do what their test says, the second of them by
// the name "right".
#include "fake_libcamera_plugin.hpp"

#include <linux/videodev2.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cstring>

namespace {

using nadir::capture::FakePlugin;

std::array<FakePlugin, 2> fakes;

FakePlugin& fake_of(void* camera) { return *static_cast<FakePlugin*>(camera); }

void write_text(NadirText& to, const char* text) {
  std::strncpy(static_cast<char*>(to.text), text, sizeof to.text - 1);
}

void open_camera(const NadirCameraWanted* wanted, NadirCameraOpened* opened) {
  FakePlugin& fake = fakes[std::strcmp(wanted->id, "right") == 0 ? 1 : 0];
  fake.wanted = *wanted;
  if (fake.opening != nullptr) fake.opening();
  if (std::strcmp(wanted->id, "none") == 0) {
    write_text(opened->fault, "libcamera has no camera");
    return;
  }
  fake.open = true;
  fake.descriptor = ::eventfd(1, EFD_CLOEXEC);
  opened->camera = &fake;
  opened->descriptor = fake.descriptor;
  opened->format = V4L2_PIX_FMT_GREY;
  opened->stride = static_cast<std::size_t>(wanted->width) + FakePlugin::kPadding;
  opened->rate_hz = wanted->rate_hz;
  opened->exposing = fake.exposing;
  write_text(opened->remarks, "its gain cannot be set\nits focus cannot be set\n");
}

NadirCameraTaken take(void* camera, NadirCameraPicture* picture, NadirText* gone) {
  FakePlugin& fake = fake_of(camera);
  if (fake.next == NADIR_TAKEN_GONE) write_text(*gone, "is not there any more");
  if (fake.next == NADIR_TAKEN_PICTURE) {
    *picture = fake.picture;
    ++fake.out;
  }
  return fake.next;
}

void give_back(void* camera, void* buffer) {
  FakePlugin& fake = fake_of(camera);
  --fake.out;
  fake.given_back = buffer;
}

void expose(void* camera, double ms, double gain) {
  FakePlugin& fake = fake_of(camera);
  fake.ms = ms;
  fake.gain = gain;
}

void stop(void* camera) { fake_of(camera).stopped = true; }

void close_camera(void* camera) {
  FakePlugin& fake = fake_of(camera);
  fake.open = false;
  ::close(fake.descriptor);
}

constexpr NadirLibcameraPlugin kPlugin{FAKE_ABI,  "0",    open_camera, take,
                                       give_back, expose, stop,        close_camera};

}  // namespace

const NadirLibcameraPlugin* nadir_libcamera_plugin() { return &kPlugin; }
void* fake_plugin() { return fakes.data(); }

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A request's memory.
#pragma once

#include <libcamera/libcamera.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nadir::capture::plugin {

/// Mapped as long as this is there.
class Mapped {
 public:
  struct Plane {
    const std::uint8_t* bytes;
    std::size_t size;
  };

  explicit Mapped(const libcamera::FrameBuffer& buffer);
  ~Mapped();
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;

  const std::vector<Plane>& planes() const { return planes_; }

  /// Before and after reading, for processors whose caches do not see what a camera writes.
  void begin_reading() const;
  void end_reading() const;

 private:
  struct Area {
    libcamera::SharedFD file;
    void* memory;
    std::size_t size;
  };

  const std::uint8_t* area_of(const libcamera::FrameBuffer& buffer,
                              const libcamera::SharedFD& file);
  void sync(std::uint64_t flags) const;

  std::vector<Area> areas_;
  std::vector<Plane> planes_;
};

}  // namespace nadir::capture::plugin

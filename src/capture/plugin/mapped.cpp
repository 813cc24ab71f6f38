// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "mapped.hpp"

#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

#include "fault.hpp"

namespace nadir::capture::plugin {

Mapped::Mapped(const libcamera::FrameBuffer& buffer) {
  for (const auto& plane : buffer.planes()) {
    const bool placed = plane.offset != libcamera::FrameBuffer::Plane::kInvalidOffset;
    const std::size_t offset = placed ? plane.offset : 0;
    planes_.push_back({area_of(buffer, plane.fd) + offset, plane.length});
  }
}

Mapped::~Mapped() {
  for (const Area& area : areas_) ::munmap(area.memory, area.size);
}

void Mapped::begin_reading() const { sync(DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ); }
void Mapped::end_reading() const { sync(DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ); }

// Planes may share a file.
const std::uint8_t* Mapped::area_of(const libcamera::FrameBuffer& buffer,
                                    const libcamera::SharedFD& file) {
  for (const Area& area : areas_) {
    if (area.file.get() == file.get()) return static_cast<const std::uint8_t*>(area.memory);
  }
  std::size_t size = 0;
  for (const auto& plane : buffer.planes()) {
    const bool placed = plane.offset != libcamera::FrameBuffer::Plane::kInvalidOffset;
    if (plane.fd.get() == file.get())
      size = std::max<std::size_t>(size, (placed ? plane.offset : 0) + std::size_t{plane.length});
  }
  void* const memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (memory == MAP_FAILED) throw Fault(failure("its memory cannot be mapped", errno));
  areas_.push_back({file, memory, size});
  return static_cast<const std::uint8_t*>(memory);
}

void Mapped::sync(std::uint64_t flags) const {
  dma_buf_sync request{flags};
  for (const Area& area : areas_) ::ioctl(area.file.get(), DMA_BUF_IOCTL_SYNC, &request);
}

}  // namespace nadir::capture::plugin

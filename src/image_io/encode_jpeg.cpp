// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <turbojpeg.h>

#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"

namespace nadir::image_io {

std::vector<std::uint8_t> encode_jpeg(const cv::Mat& image, int quality, Chroma chroma) {
  NADIR_CHECK(image.type() == CV_8UC1 || image.type() == CV_8UC3, image.type());
  NADIR_CHECK(!image.empty() && quality >= 1 && quality <= 100, image.cols, image.rows, quality);
  const bool grey = image.channels() == 1;
  const int subsampling = grey ? TJSAMP_GRAY : chroma == Chroma::full ? TJSAMP_444 : TJSAMP_420;
  std::vector<std::uint8_t> file(tjBufSize(image.cols, image.rows, subsampling));
  unsigned char* data = file.data();
  unsigned long size = file.size();
  const std::unique_ptr<void, int (*)(tjhandle)> handle(tjInitCompress(), tjDestroy);
  const int status = tjCompress2(handle.get(), image.data, image.cols, static_cast<int>(image.step),
                                 image.rows, grey ? TJPF_GRAY : TJPF_BGR, &data, &size, subsampling,
                                 quality, TJFLAG_NOREALLOC);
  NADIR_CHECK(status == 0, tjGetErrorStr2(handle.get()));
  file.resize(size);
  return file;
}

}  // namespace nadir::image_io

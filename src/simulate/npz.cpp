// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "npz.hpp"

#include <array>
#include <bit>
#include <cstdint>

#include "nadir/core/check.hpp"

namespace nadir::simulate {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they lie");

std::uint32_t crc32(const std::string& bytes) {  // ISO 3309, reflected
  std::uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

template <class... Numbers>
std::string little_endian(Numbers... numbers) {
  std::string bytes;
  const auto append = [&](auto number) {
    for (std::size_t i = 0; i < sizeof number; ++i) {
      bytes.push_back(static_cast<char>((number >> (8 * i)) & 0xff));
    }
  };
  (append(numbers), ...);
  return bytes;
}

std::string shape_of(const cv::Mat& array) {
  if (array.total() == 1) return "()";
  std::string shape = "(";
  shape += std::to_string(array.rows);
  shape += ',';
  if (array.cols > 1) (shape += ' ') += std::to_string(array.cols);
  return shape + ")";
}

std::string npy(const cv::Mat& array) {
  NADIR_CHECK(array.type() == CV_16S || array.type() == CV_64F, array.type());
  constexpr std::size_t kBlock = 64, kPreamble = 10;
  std::string header = std::string("{'descr': '") + (array.depth() == CV_16S ? "<i2" : "<f8") +
                       "', 'fortran_order': False, 'shape': " + shape_of(array) + ", }";
  header.append(kBlock - 1 - (kPreamble + header.size()) % kBlock, ' ');
  header += '\n';
  std::string file = "\x93NUMPY\x01";
  file.push_back('\0');
  file += little_endian(static_cast<std::uint16_t>(header.size())) + header;
  const cv::Mat packed = array.isContinuous() ? array : array.clone();
  return file.append(reinterpret_cast<const char*>(packed.data),
                     packed.total() * packed.elemSize());
}

}  // namespace

// APPNOTE 6.3: local headers with data, then the central directory, then its end record.
std::string npz(const std::vector<std::pair<std::string, cv::Mat>>& arrays) {
  using u16 = std::uint16_t;
  using u32 = std::uint32_t;
  constexpr u16 kVersion = 20, kFlags = 0, kStored = 0, kTime = 0, kDate = 0x21;  // 1 January 1980
  const std::string kLocalHeader = "PK\x03\x04", kCentralHeader = "PK\x01\x02", kEnd = "PK\x05\x06";
  std::string file, directory;
  for (const auto& [name, array] : arrays) {
    const std::string data = npy(array), entry = name + ".npy";
    const u32 size = static_cast<u32>(data.size()), offset = static_cast<u32>(file.size());
    const std::string common = little_endian(kVersion, kFlags, kStored, kTime, kDate, crc32(data),
                                             size, size, static_cast<u16>(entry.size()), u16{0});
    for (const std::string& part : {kLocalHeader, common, entry, data}) file += part;
    const std::string rest = little_endian(u16{0}, u16{0}, u16{0}, u32{0}, offset);
    for (const std::string& part : {kCentralHeader, little_endian(kVersion), common, rest, entry}) {
      directory += part;
    }
  }
  const u16 count = static_cast<u16>(arrays.size());
  const u32 start = static_cast<u32>(file.size()), length = static_cast<u32>(directory.size());
  return file + directory + kEnd +
         little_endian(u16{0}, u16{0}, count, count, length, start, u16{0});
}

}  // namespace nadir::simulate

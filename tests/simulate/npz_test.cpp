// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "npz.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

namespace nadir::simulate {
namespace {

template <class Number>
Number number_at(const std::string& bytes, std::size_t offset) {
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

TEST(Npz, IsAStoredZipOfNumpyArrays) {
  const cv::Mat heights = (cv::Mat_<std::int16_t>(2, 3) << 1, -2, 3, 4, 5, -32000);
  const std::string file =
      npz({{"z_mm", heights}, {"res", cv::Mat(1, 1, CV_64F, cv::Scalar(0.5))}});
  EXPECT_EQ(file.substr(0, 4), "PK\x03\x04");
  const auto size = number_at<std::uint32_t>(file, 18),
             name = number_at<std::uint16_t>(file, 26) + 0u;
  EXPECT_EQ(file.substr(30, name), "z_mm.npy");
  const std::string array = file.substr(30 + name, size);
  EXPECT_EQ(array.substr(0, 6), "\x93NUMPY");
  const auto header = number_at<std::uint16_t>(array, 8);
  EXPECT_EQ((10 + header) % 64, 0);
  EXPECT_NE(array.find("'descr': '<i2', 'fortran_order': False, 'shape': (2, 3)"),
            std::string::npos);
  ASSERT_EQ(array.size(), 10u + header + 12);
  EXPECT_EQ(number_at<std::int16_t>(array, 10u + header + 10), -32000);
  EXPECT_NE(file.find("'shape': ()"), std::string::npos);
  const std::size_t end = file.size() - 22;
  EXPECT_EQ(file.substr(end, 4), "PK\x05\x06");
  EXPECT_EQ(number_at<std::uint16_t>(file, end + 10), 2);  // entries
  const auto directory = number_at<std::uint32_t>(file, end + 16);
  EXPECT_EQ(file.substr(directory, 4), "PK\x01\x02");
}

// The expected value is zlib's for the same array as numpy.save writes it.
TEST(Npz, ChecksItsArraysWithCrc32) {
  const std::string file = npz({{"t", cv::Mat(3, 1, CV_64F, cv::Scalar(1.0))}});
  EXPECT_EQ(number_at<std::uint32_t>(file, 14), 0x679446afu);
}

}  // namespace
}  // namespace nadir::simulate

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/exif.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cstring>

#include "jpeg_markers.hpp"
#include "tiff_directory.hpp"

namespace nadir::image_io {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::optional<int> digits(std::string_view text) {
  int value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + (c - '0');
  }
  return value;
}

// "YYYY:MM:DD HH:MM:SS"
std::optional<Time> parse_date_time(std::string_view text) {
  if (text.size() != 19) return std::nullopt;
  if (text[4] != ':' || text[7] != ':' || text[10] != ' ' || text[13] != ':' || text[16] != ':') {
    return std::nullopt;
  }
  const auto year = digits(text.substr(0, 4)), month = digits(text.substr(5, 2)),
             day = digits(text.substr(8, 2)), hour = digits(text.substr(11, 2)),
             minute = digits(text.substr(14, 2)), second = digits(text.substr(17, 2));
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{*year},
                                         std::chrono::month{static_cast<unsigned>(*month)},
                                         std::chrono::day{static_cast<unsigned>(*day)}};
  constexpr int kFirstYear = 1971, kLastYear = 2200;  // within 64 bits of nanoseconds
  if (!date.ok() || *year < kFirstYear || *year > kLastYear || *hour > 23 || *minute > 59 ||
      *second > 60) {
    return std::nullopt;
  }
  const auto days = std::chrono::sys_days(date).time_since_epoch();
  const std::chrono::seconds since_epoch = days + std::chrono::hours(*hour) +
                                           std::chrono::minutes(*minute) +
                                           std::chrono::seconds(*second);
  return std::chrono::nanoseconds(since_epoch).count();
}

// SubSecTimeOriginal holds the decimals of the second: "5" is half a second.
Time parse_fraction(std::string_view decimals) {
  Time value = 0;
  Time unit = 100'000'000;
  for (const char c : decimals.substr(0, 9)) {
    if (c < '0' || c > '9') break;
    value += (c - '0') * unit;
    unit /= 10;
  }
  return value;
}

Bytes exif_of(Bytes file) {
  if (file.size() < 2 || file[0] != 0xff || file[1] != 0xd8) return file;
  constexpr int kApp1 = 0xe1;
  constexpr std::size_t kNameSize = 6;
  JpegMarkers markers(file);
  while (const auto segment = markers.next()) {
    if (segment->marker == kJpegStartOfScan) break;
    if (segment->marker == kApp1 && segment->payload.size() > kNameSize &&
        std::memcmp(segment->payload.data(), "Exif\0\0", kNameSize) == 0) {
      return segment->payload.subspan(kNameSize);
    }
  }
  return {};
}

}  // namespace

std::optional<Time> read_exif_time(Bytes file) {
  constexpr std::uint16_t kExifDirectory = 0x8769, kDateTimeOriginal = 0x9003,
                          kSubSecTimeOriginal = 0x9291;
  const auto main = TiffDirectory::first(exif_of(file));
  const auto exif = main ? main->sub_directory(kExifDirectory) : std::nullopt;
  if (!exif) return std::nullopt;
  const auto time = parse_date_time(exif->text(kDateTimeOriginal));
  if (!time) return std::nullopt;
  return *time + parse_fraction(exif->text(kSubSecTimeOriginal));
}

}  // namespace nadir::image_io

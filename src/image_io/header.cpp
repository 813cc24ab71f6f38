// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/header.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "jpeg_markers.hpp"
#include "tiff_directory.hpp"

namespace nadir::image_io {
namespace {

using Bytes = std::span<const std::uint8_t>;

Inspection fault(std::string why) { return {std::nullopt, std::move(why)}; }

bool starts_with(Bytes file, std::size_t offset, std::string_view magic) {
  return file.size() >= offset + magic.size() &&
         std::memcmp(file.data() + offset, magic.data(), magic.size()) == 0;
}

Inspection checked(const Header& header) {
  constexpr int kLargest = 65535;  // JPEG's own limit, and far beyond any camera
  const auto in_range = [](int side) { return side >= 1 && side <= kLargest; };
  if (!in_range(header.width) || !in_range(header.height)) {
    return fault("declares an impossible image size");
  }
  return {header, {}};
}

Inspection jpeg_frame(int marker, Bytes frame) {
  if (marker > 0xc2) return fault("lossless, hierarchical or arithmetic JPEG is not supported");
  if (frame.size() < 6) return fault("damaged JPEG header");
  const int bits = frame[0], channels = frame[5];
  if (bits != 8) return fault(std::to_string(bits) + "-bit JPEG is not supported");
  if (channels == 4) return fault("CMYK JPEG is not supported");
  if (channels != 1 && channels != 3) {
    return fault("JPEG with " + std::to_string(channels) + " channels is not supported");
  }
  return checked(
      {Format::jpeg, frame[3] << 8 | frame[4], frame[1] << 8 | frame[2], channels, bits});
}

// SOF0 to SOF15, of which C4, C8 and CC are other markers.
bool starts_frame(int marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

Inspection jpeg(Bytes file) {
  JpegMarkers markers(file);
  while (const auto segment = markers.next()) {
    if (starts_frame(segment->marker)) return jpeg_frame(segment->marker, segment->payload);
    if (segment->marker == kJpegStartOfScan) break;
  }
  return fault("truncated or damaged JPEG header");
}

Inspection png(Bytes file) {
  constexpr std::size_t kHeaderEnd = 33;  // signature 8, IHDR 25
  if (file.size() < kHeaderEnd || !starts_with(file, 8, std::string_view("\0\0\0\rIHDR", 8))) {
    return fault("truncated or damaged PNG header");
  }
  const auto side = [&](std::size_t offset) {
    return static_cast<int>(std::min(*read_uint(file, offset, 4, ByteOrder::big), 0x7fffffffu));
  };
  constexpr std::array<int, 7> kChannels{1, 0, 3, 3, 2, 0, 4};  // by colour type; 3 is a palette
  const int bits = file[24], type = file[25];
  if (type > 6 || kChannels[static_cast<std::size_t>(type)] == 0) {
    return fault("damaged PNG header");
  }
  return checked({Format::png, side(16), side(20), kChannels[static_cast<std::size_t>(type)],
                  type == 3 ? 8 : bits});
}

constexpr std::uint16_t kWidth = 256, kHeight = 257, kBits = 258, kPhotometric = 262,
                        kSamples = 277, kPlanar = 284, kSampleFormat = 339;

std::string unsupported_tiff(const TiffDirectory& tags, std::uint32_t bits, std::uint32_t samples) {
  constexpr std::uint32_t kMinIsWhite = 0, kMinIsBlack = 1, kRgb = 2, kYcbcr = 6, kSeparated = 5;
  const std::uint32_t photometric = tags.number(kPhotometric).value_or(kMinIsBlack);
  if (photometric == kSeparated) return "CMYK TIFF is not supported";
  const bool grey = photometric == kMinIsWhite || photometric == kMinIsBlack;
  if (!grey && photometric != kRgb && photometric != kYcbcr) {
    return "TIFF with this colour space is not supported: only grey and RGB are";
  }
  if (bits != 8 && bits != 16) return std::to_string(bits) + "-bit TIFF is not supported";
  if (grey ? samples < 1 || samples > 2 : samples < 3 || samples > 4) {
    return "TIFF with " + std::to_string(samples) + " channels is not supported";
  }
  if (tags.number(kPlanar).value_or(1) != 1 && samples > 1) {
    return "TIFF with separate colour planes is not supported";
  }
  if (tags.number(kSampleFormat).value_or(1) != 1) {
    return "TIFF with signed or floating-point samples is not supported";
  }
  return {};
}

Inspection tiff(Bytes file) {
  const auto tags = TiffDirectory::first(file);
  if (!tags) return fault("truncated or damaged TIFF header");
  const auto width = tags->number(kWidth), height = tags->number(kHeight);
  if (!width || !height) return fault("truncated or damaged TIFF header");
  const std::uint32_t bits = tags->number(kBits).value_or(1);
  const std::uint32_t samples = tags->number(kSamples).value_or(1);
  if (std::string why = unsupported_tiff(*tags, bits, samples); !why.empty()) {
    return fault(std::move(why));
  }
  const auto side = [](std::uint32_t value) {
    return static_cast<int>(std::min(value, 0x7fffffffu));
  };
  return checked({Format::tiff, side(*width), side(*height), static_cast<int>(samples),
                  static_cast<int>(bits)});
}

struct Signature {
  std::size_t offset;
  std::string_view magic;
  const char* name;
};

// Named so that the message helps; none of these ever reaches a decoder.
constexpr std::array kOthers{
    Signature{128, "DICM", "DICOM"},
    Signature{0, "\x76\x2f\x31\x01", "OpenEXR"},
    Signature{0, "#?R", "Radiance HDR"},
    Signature{4, "jP  ", "JPEG 2000"},
    Signature{0, "\xff\x4f\xff\x51", "JPEG 2000"},
    Signature{0, "GIF8", "GIF"},
    Signature{0, "\x59\xa6\x6a\x95", "Sun raster"},
    Signature{0, "BM", "BMP"},
    Signature{8, "WEBP", "WebP"},
    Signature{4, "ftyp", "HEIF, AVIF or video"},
    Signature{0, "%PDF", "PDF"},
};

std::string unsupported_format(Bytes file) {
  if (file.empty()) return "empty file";
  for (const Signature& other : kOthers) {
    if (starts_with(file, other.offset, other.magic)) {
      return std::string(other.name) + " is not supported: only JPEG, PNG and TIFF are";
    }
  }
  if (file.size() > 1 && file[0] == 'P' && std::strchr("1234567Ff", file[1]) != nullptr) {
    return "PNM is not supported: only JPEG, PNG and TIFF are";
  }
  return "not a JPEG, PNG or TIFF file";
}

}  // namespace

Inspection read_header(Bytes file) {
  if (starts_with(file, 0, "\xff\xd8\xff")) return jpeg(file);
  if (starts_with(file, 0, "\x89PNG\r\n\x1a\n")) return png(file);
  if (starts_with(file, 0, std::string_view("II*\0", 4)) ||
      starts_with(file, 0, std::string_view("MM\0*", 4))) {
    return tiff(file);
  }
  if (starts_with(file, 0, "II+") || starts_with(file, 0, std::string_view("MM\0+", 4))) {
    return fault("BigTIFF is not supported");
  }
  return fault(unsupported_format(file));
}

}  // namespace nadir::image_io

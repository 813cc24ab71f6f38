// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "tar.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <utility>

#include "opaque_id.hpp"

namespace nadir::app {
namespace {

constexpr std::uint64_t kBlock = 512;
constexpr std::size_t kNameRoom = 100, kPrefixRoom = 155;
constexpr std::uint64_t kOctalSizes = std::uint64_t{1} << 33;

std::uint64_t blocks(std::uint64_t size) { return (size + kBlock - 1) / kBlock * kBlock; }

// Where the prefix ends, a slash; 0: there is none and need not be.
std::optional<std::size_t> split(const std::string& name) {
  if (name.size() <= kNameRoom) return 0;
  const std::size_t slash = name.find('/', name.size() - kNameRoom - 1);
  return slash <= kPrefixRoom ? std::optional(slash) : std::nullopt;
}

struct Header {
  std::array<char, kBlock> bytes{};

  void text(std::size_t at, std::string_view value) {
    std::copy(value.begin(), value.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }
  void octal(std::size_t at, int digits, std::uint64_t value) {
    std::array<char, 24> text_of{};
    std::snprintf(text_of.data(), text_of.size(), "%0*llo", digits,
                  static_cast<unsigned long long>(value));
    text(at, text_of.data());
  }
};

std::array<char, kBlock> header_of(const std::string& name, const Item& item) {
  constexpr int kMode = 0644;
  const std::size_t slash = split(name).value_or(0);
  Header header;
  header.text(0, slash > 0 ? name.substr(slash + 1) : name);
  header.octal(100, 7, kMode);
  header.octal(108, 7, 0);  // owner
  header.octal(116, 7, 0);  // group
  if (item.size < kOctalSizes) {
    header.octal(124, 11, item.size);
  } else {
    header.bytes[124] = static_cast<char>(0x80);
    for (int i = 0; i < 8; ++i) {
      header.bytes[static_cast<std::size_t>(135 - i)] = static_cast<char>(item.size >> (8 * i));
    }
  }
  header.octal(
      136, 11,
      static_cast<std::uint64_t>(std::max<std::int64_t>(item.changed_ns, 0)) / 1'000'000'000);
  header.text(148, "        ");  // what the sum takes itself for
  header.text(156, "0");         // a file
  header.text(257, std::string_view("ustar\00000", 8));
  if (slash > 0) header.text(345, name.substr(0, slash));
  const unsigned sum =
      std::accumulate(header.bytes.begin(), header.bytes.end(), 0u,
                      [](unsigned all, char c) { return all + static_cast<unsigned char>(c); });
  header.octal(148, 6, sum);
  header.bytes[154] = '\0';
  return header.bytes;
}

std::string joined(const std::string& name, const std::vector<std::string>& way) {
  return std::accumulate(
      way.begin(), way.end(), name,
      [](std::string all, const std::string& step) { return std::move(all) + '/' + step; });
}

}  // namespace

Tar::Tar(Folder folder, const std::string& name, std::vector<TarMember> members)
    : folder_(std::move(folder)) {
  for (TarMember& member : members) {
    std::string full = joined(name, member.way);
    if (!split(full)) continue;
    const std::uint64_t begin = std::exchange(size_, size_ + kBlock + blocks(member.item.size));
    places_.push_back({begin, std::move(member), std::move(full)});
  }
  size_ += 2 * kBlock;  // the end
}

std::string Tar::tag() const {
  std::string all;
  for (const Place& place : places_) {
    all += place.name + ' ' + std::to_string(place.member.item.size) + ' ' +
           std::to_string(place.member.item.changed_ns) + '\n';
  }
  return opaque_id(all);
}

std::ptrdiff_t Tar::read(std::uint64_t at, std::span<char> into) {
  std::size_t filled = 0;
  while (filled < into.size()) {
    const std::ptrdiff_t size = read_piece(at + filled, into.subspan(filled));
    if (size <= 0) return filled > 0 ? static_cast<std::ptrdiff_t>(filled) : -1;
    filled += static_cast<std::size_t>(size);
  }
  return static_cast<std::ptrdiff_t>(filled);
}

std::ptrdiff_t Tar::read_piece(std::uint64_t at, std::span<char> into) {
  const std::uint64_t end = size_ - 2 * kBlock;
  if (at >= end) {
    std::ranges::fill(into, '\0');
    return static_cast<std::ptrdiff_t>(into.size());
  }
  const auto after = std::ranges::upper_bound(places_, at, {}, &Place::begin);
  const Place& place = *std::prev(after);
  const std::uint64_t place_end = after == places_.end() ? end : after->begin;
  return read_in(place, at - place.begin,
                 into.first(std::min<std::uint64_t>(into.size(), place_end - at)));
}

// at: from the header's begin. As much as lies in one of header, content and padding.
std::ptrdiff_t Tar::read_in(const Place& place, std::uint64_t at, std::span<char> into) {
  const std::uint64_t content_end = kBlock + place.member.item.size;
  if (at < kBlock) {
    const auto header = header_of(place.name, place.member.item);
    const std::size_t size = std::min<std::uint64_t>(into.size(), kBlock - at);
    std::copy_n(header.begin() + static_cast<std::ptrdiff_t>(at), size, into.begin());
    return static_cast<std::ptrdiff_t>(size);
  }
  if (at >= content_end) {
    std::ranges::fill(into, '\0');
    return static_cast<std::ptrdiff_t>(into.size());
  }
  const File* const file = open(place);
  if (file == nullptr) return -1;
  const std::ptrdiff_t size =
      file->read(at - kBlock, into.first(std::min<std::uint64_t>(into.size(), content_end - at)));
  return size == 0 ? -1 : size;
}

const File* Tar::open(const Place& place) {
  if (file_ && file_begin_ == place.begin) return &*file_;
  std::optional<Folder> folder = folder_;
  const std::vector<std::string>& way = place.member.way;
  for (std::size_t i = 0; folder && i + 1 < way.size(); ++i) folder = folder->folder(way[i]);
  file_ = folder ? folder->file(way.back()) : std::nullopt;
  file_begin_ = place.begin;
  return file_ ? &*file_ : nullptr;
}

}  // namespace nadir::app

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace nadir::capture {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

FileBytes fault(std::string why) { return {{}, std::move(why)}; }

FileBytes system_fault(const char* what) {
  return fault(std::string(what) + ": " + std::strerror(errno));
}

FileBytes read_all(int descriptor, std::size_t size) {
  FileBytes file;
  file.bytes.resize(size);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::read(descriptor, file.bytes.data() + done, size - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_fault("cannot be read");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  file.bytes.resize(done);
  return file;
}

enum class Overlong { refuse, cut };

FileBytes read_regular(const std::filesystem::path& path, std::uint64_t most_bytes, Links links,
                       Overlong overlong) {
  const int no_follow = links == Links::refuse ? O_NOFOLLOW : 0;
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | no_follow));
  if (file.get() < 0 && errno == ELOOP) return fault("is a symbolic link");
  if (file.get() < 0) return system_fault("cannot be opened");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return system_fault("cannot be read");
  if (!S_ISREG(status.st_mode)) return fault("is not a regular file");
  std::uint64_t size = static_cast<std::uint64_t>(status.st_size);
  if (size > most_bytes && overlong == Overlong::refuse) {
    return fault("is too large, " + std::to_string(size) + " bytes");
  }
  return read_all(file.get(), static_cast<std::size_t>(std::min(size, most_bytes)));
}

// Length of the UTF-8 sequence at the start (RFC 3629, without overlong forms and surrogates);
// 0 when there is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const auto tail = [&](std::size_t i) { return (byte(i) & 0xc0u) == 0x80u; };
  const unsigned first = byte(0), second = byte(1);
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf && tail(1)) return 2;
  const bool three = (first & 0xf0u) == 0xe0 && tail(1) && tail(2);
  if (three && !(first == 0xe0 && second < 0xa0) && !(first == 0xed && second > 0x9f)) return 3;
  const bool four = first >= 0xf0 && first <= 0xf4 && tail(1) && tail(2) && tail(3);
  if (four && !(first == 0xf0 && second < 0x90) && !(first == 0xf4 && second > 0x8f)) return 4;
  return 0;
}

}  // namespace

FileBytes read_file(const std::filesystem::path& file, std::uint64_t most_bytes, Links links) {
  return read_regular(file, most_bytes, links, Overlong::refuse);
}

FileBytes read_head(const std::filesystem::path& file, std::size_t bytes) {
  return read_regular(file, bytes, Links::refuse, Overlong::cut);
}

std::string printable(const std::string& name) {
  std::string result;
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t length = utf8_length(std::string_view(name).substr(at));
    const auto first = static_cast<unsigned char>(name[at]);
    if (length == 0 || first < 0x20 || first == 0x7f) {
      result += '?';
    } else {
      result.append(name, at, length);
    }
    at += std::max<std::size_t>(length, 1);
  }
  return result;
}

}  // namespace nadir::capture

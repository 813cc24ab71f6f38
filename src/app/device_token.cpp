// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "device_token.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytes = 32, kCharacters = 43;
constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

struct Found {
  std::string token;
  std::string fault;  ///< why there is none
  bool denied = false;
};

std::string content_of(int file) {
  std::array<char, 2 * kCharacters> text{};
  const ssize_t size = ::read(file, text.data(), text.size());
  std::string content(text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  while (content.ends_with('\n')) content.pop_back();
  return content;
}

Found find(const fs::path& name) {
  const int file = ::open(name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return {{}, std::strerror(errno), errno == EACCES};
  struct stat status {};
  const bool regular = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode);
  const std::string token = regular ? content_of(file) : "";
  ::close(file);
  if (!regular) return {{}, "is no file"};
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) return {{}, "others may read it"};
  const bool whole =
      token.size() == kCharacters && token.find_first_not_of(kAlphabet) == std::string::npos;
  return whole ? Found{token, {}} : Found{{}, "holds no token"};
}

int write(const fs::path& name, const std::string& token, record::Disk& disk) {
  using record::Disk;
  const fs::path temporary = name.parent_path() / ('.' + name.filename().string() + ".tmp");
  disk.remove(temporary);  // who may read it is settled as it is made
  const int file = record::open_file(disk, temporary, Disk::Open::secret);
  if (file < 0) return file;
  int error = record::write_all(disk, file, record::as_bytes(token + '\n'));
  if (error == 0) error = record::sync_file(disk, file);
  disk.close(file);
  if (error == 0) error = record::rename_file(disk, temporary, name);
  if (error != 0) disk.remove(temporary);
  return error != 0 ? error : record::sync_directory(disk, name.parent_path());
}

}  // namespace

fs::path token_file(const fs::path& dives, const fs::path& state) {
  std::error_code none;
  if (fs::is_directory(state, none)) return state / "token";
  fs::path folder = fs::absolute(dives).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();  // "dives/"
  return folder.parent_path() / "token";
}

std::string new_token() {
  std::array<std::uint8_t, kBytes + 1> bytes{};  // and a zero that fills up the last character
  NADIR_CHECK(::getentropy(bytes.data(), kBytes) == 0, errno);
  std::string token;
  for (std::size_t bit = 0; token.size() < kCharacters; bit += 6) {
    const unsigned two = bytes[bit / 8] * 256u + bytes[bit / 8 + 1];
    token += kAlphabet[two >> (10 - bit % 8) & 63u];
  }
  return token;
}

DeviceToken device_token(const fs::path& file, record::Disk& disk) {
  const Found found = find(file);
  if (!found.token.empty()) return {found.token, {}};
  std::error_code none;
  const bool is_first = !fs::exists(fs::symlink_status(file, none));
  fs::create_directories(file.parent_path(), none);
  DeviceToken made{new_token(), {}};
  if (const int error = write(file, made.token, disk); error != 0) {
    made.message = file.string() +
                   ": the token cannot be kept: " + std::string(record::describe(error)) +
                   "; pages that have it may command until the next start";
  } else if (!is_first) {
    made.message = file.string() + ": " + found.fault +
                   "; a new token was made, and pages with the old one may not command any more";
  } else {
    made.message = "the token of this device was made: nadir token shows it";
  }
  return made;
}

std::string read_token(const fs::path& file) {
  const Found found = find(file);
  if (!found.token.empty()) return found.token;
  throw InputError(file.string() + ": " + found.fault + "; " +
                   (found.denied ? "ask as its owner does: sudo nadir token"
                                 : "nadir makes it as it starts: nadir run, or sudo systemctl "
                                   "start nadir"));
}

bool is_same_token(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  }
  return difference == 0;
}

}  // namespace nadir::app

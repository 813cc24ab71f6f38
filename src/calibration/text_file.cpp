// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>

#include "nadir/core/check.hpp"

namespace nadir::calibration {

std::string read_text(const std::filesystem::path& file) {
  constexpr off_t kMostBytes = 1 << 20;  // a calibration has about 1 kB
  const auto fail = [&](const std::string& fault) {
    throw InputError(file.string() + ": " + fault);
  };
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) fail(std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  const bool regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  std::string content;
  if (regular && status.st_size <= kMostBytes) {
    content.resize(static_cast<std::size_t>(status.st_size));
    std::size_t done = 0;
    while (done < content.size()) {
      const ssize_t count = ::read(descriptor, content.data() + done, content.size() - done);
      if (count <= 0) break;
      done += static_cast<std::size_t>(count);
    }
    content.resize(done);
  }
  ::close(descriptor);
  if (!regular) fail("is not a regular file");
  if (status.st_size > kMostBytes) fail("is larger than 1 MB; this is not a calibration file");
  if (content.starts_with("\xef\xbb\xbf")) content.erase(0, 3);
  if (content.find('\0') != content.npos) {
    fail("is not a text file; export the calibration as text");
  }
  if (content.find_first_not_of(" \t\r\n") == content.npos) fail("is empty");
  return content;
}

}  // namespace nadir::calibration

// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/config/data_files.h"
#include "core/config/inputs.h"
#include "core/io/descriptor.h"

namespace panoptes {
namespace {

constexpr std::size_t kBuffer_bytes = 1U << 18;

[[noreturn]] void refuse(const std::filesystem::path& path, const char* doing,
                         const std::string& why) {
  const std::string what = path.string() + ": cannot be " + doing + ": " + why;
  if (is_shipped(path.string())) {
    throw IoError(what);
  }
  throw ConfigError(what);
}

std::string reason() { return std::error_code(errno, std::generic_category()).message(); }

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), part_(path_) {
  part_ += ".part";
  descriptor_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) {
    throw IoError(path_.string() + ": cannot be created: " + reason());
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
    ::unlink(part_.c_str());
  }
}

void AtomicFile::append(std::string_view bytes) {
  if (descriptor_ < 0) {
    throw IoError(buffer_);
  }
  buffer_.append(bytes);
  if (buffer_.size() >= kBuffer_bytes) {
    flush();
  }
}

void AtomicFile::flush() {
  if (descriptor_ < 0) {
    throw IoError(buffer_);
  }
  if (write_all(descriptor_, buffer_) < buffer_.size()) {
    fail("written");
  }
  buffer_.clear();
}

void AtomicFile::commit() {
  flush();
  if (::fsync(descriptor_) != 0 && errno != EINVAL &&
      errno != EROFS) {  // EINVAL: not a disk's file
    fail("brought to the disk");
  }
  const int descriptor = std::exchange(descriptor_, -1);
  if (::close(descriptor) != 0 || ::rename(part_.c_str(), path_.c_str()) != 0) {
    fail("finished");
  }
}

void AtomicFile::fail(const char* doing) {
  const std::string why = reason();
  if (descriptor_ >= 0) {
    ::close(std::exchange(descriptor_, -1));
  }
  ::unlink(part_.c_str());
  buffer_ = path_.string() + ": cannot be " + doing + ": " + why;  // for the next time
  throw IoError(buffer_);
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.append(bytes);
  file.commit();
}

std::string read_file(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    refuse(path, "opened", reason());
  }
  std::string all;
  std::array<char, 1U << 16> block{};
  while (true) {
    const ssize_t n = ::read(descriptor, block.data(), block.size());
    if (n < 0 && errno == EINTR) {
      continue;
    }
    if (n < 0) {
      const std::string why = reason();
      ::close(descriptor);
      refuse(path, "read", why);
    }
    if (n == 0) {
      break;
    }
    all.append(block.data(), static_cast<std::size_t>(n));
  }
  ::close(descriptor);
  note_input(path, all);
  return all;
}

}  // namespace panoptes

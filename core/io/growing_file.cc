// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/growing_file.h"

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/io/descriptor.h"

namespace panoptes {
namespace {

IoError fault(const std::filesystem::path& path, const char* doing) {
  return IoError(path.string() + ": cannot be " + doing + ": " +
                 std::error_code(errno, std::generic_category()).message());
}

}  // namespace

GrowingFile::GrowingFile(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor_ < 0) {
    throw fault(path_, "created");
  }
}

GrowingFile::GrowingFile(GrowingFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

GrowingFile::~GrowingFile() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

void GrowingFile::append(std::string_view bytes) {
  const std::size_t done = write_all(descriptor_, bytes);
  if (done < bytes.size()) {
    const IoError error = fault(path_, "written");
    if (done > 0) {
      std::error_code ignored;  // a torn row is still read
      std::filesystem::resize_file(path_, size_, ignored);
    }
    throw error;
  }
  size_ += done;
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/descriptor.h"

#include <cerrno>

#include <unistd.h>

namespace panoptes {

std::size_t write_all(int descriptor, std::string_view bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(descriptor, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno != EINTR) {
      break;
    }
    done += n > 0 ? static_cast<std::size_t>(n) : 0;
  }
  return done;
}

}  // namespace panoptes

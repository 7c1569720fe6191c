// SPDX-License-Identifier: BSD-3-Clause
#include "apps/command/process_name.h"

#include <array>

#include <unistd.h>

namespace panoptes {

std::string process_name() {
  constexpr std::size_t kLongest = 256;
  std::array<char, kLongest> host{};
  ::gethostname(host.data(), host.size() - 1);
  return std::string(host.data()) + "-" + std::to_string(::getpid());
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/emergency_stop.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <sys/ioctl.h>
#include <unistd.h>

namespace panoptes::hw {
namespace {

// STOP, three times: whoever was cut short in the middle of a frame may cost the first.
constexpr std::array<std::uint8_t, 18> kStop = {0xFA, 0xFB, 3,  29,   0,    29, 0xFA, 0xFB, 3,
                                                29,   0,    29, 0xFA, 0xFB, 3,  29,   0,    29};

constexpr int kFree = 0;    // what a slot holds: nothing,
constexpr int kTcp = 1;     // or twice a descriptor that is open, and this more than
constexpr int kSerial = 2;  // one of these
std::array<std::atomic<int>, 8> g_lines{};
static_assert(std::atomic<int>::is_always_lock_free);

}  // namespace

EmergencyStopRegistration::EmergencyStopRegistration(int fd, bool serial) {
  for (std::size_t i = 0; i < g_lines.size() && slot_ < 0; ++i) {
    int free = kFree;
    if (g_lines[i].compare_exchange_strong(free, 2 * fd + (serial ? kSerial : kTcp))) {
      slot_ = static_cast<int>(i);
    }
  }
}

EmergencyStopRegistration::~EmergencyStopRegistration() {
  if (slot_ >= 0) {
    g_lines[static_cast<std::size_t>(slot_)] = kFree;
  }
}

void stop_registered_robots() noexcept {
  for (const std::atomic<int>& line : g_lines) {
    const int held = line;
    if (held == kFree) {
      continue;
    }
    const int fd = (held - 1) / 2;
    [[maybe_unused]] const ssize_t written = ::write(fd, kStop.data(), kStop.size());
    if (held % 2 == 0) {
      ::ioctl(fd, TIOCNXCL);
    }
  }
}

}  // namespace panoptes::hw

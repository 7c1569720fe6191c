// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace panoptes::hw {

/// Registers a line with a robot at its end that may be driven. While it lives,
/// stop_registered_robots() reaches that robot.
class EmergencyStopRegistration {
 public:
  EmergencyStopRegistration(int fd, bool serial);
  ~EmergencyStopRegistration();
  EmergencyStopRegistration(const EmergencyStopRegistration&) = delete;
  EmergencyStopRegistration& operator=(const EmergencyStopRegistration&) = delete;

 private:
  int slot_ = -1;  // none is free: that robot is left to its watchdog
};

/// Sends STOP to every registered robot and lets go of its port. For where the program ends and
/// nothing is done in order any more: it takes no memory and no lock, and a signal's handler may
/// call it.
void stop_registered_robots() noexcept;

}  // namespace panoptes::hw

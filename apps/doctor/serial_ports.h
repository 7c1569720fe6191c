// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "hw/pioneer/probe.h"

namespace panoptes {

/// A serial port of this machine.
struct ListedPort {
  std::string node;                ///< /dev/ttyUSB0
  std::vector<std::string> by_id;  ///< its lasting names in /dev/serial/by-id
  std::string fault;               ///< why it cannot be used; empty when it can
  std::string cure;                ///< what to do then
};

/// The serial ports with a device behind them, by name; whether each can be opened and is free.
/// Looks into `root`/sys, /dev and /proc, which are a test's own where it gives another root.
std::vector<ListedPort> serial_ports(const std::filesystem::path& root = "/");

/// Asks at `serial:/dev/ttyUSB0` or `tcp:host:8101`; throws DeviceError where nobody answers.
using ProbePort = std::function<hw::PioneerIdentity(const std::string& address)>;

/// `Pioneer p3dx-sh "Carrera_0123", firmware 2.9, battery 12.6 V, 9600 baud`
std::string answer_line(const hw::PioneerIdentity& answer);

}  // namespace panoptes

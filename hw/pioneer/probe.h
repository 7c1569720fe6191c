// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/time.h"

namespace panoptes::hw {

/// What a robot says of itself.
struct PioneerIdentity {
  std::string name;
  std::string class_name;
  std::string subclass;
  std::string firmware;  ///< empty where it does not tell
  double battery_v = 0;
  int baud = 0;  ///< 0 over TCP
};

/// Asks whoever is at an address (see Line), and moves nothing. Throws DeviceError with the address
/// and the cure.
PioneerIdentity probe_pioneer(const std::string& address);

}  // namespace panoptes::hw

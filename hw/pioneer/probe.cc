// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/probe.h"

#include "hw/pioneer/base.h"

namespace panoptes::hw {

PioneerIdentity probe_pioneer(const std::string& address) {
  PioneerBase base(address, Body());
  connect(base);
  PioneerIdentity identity;
  base.with([&](const PioneerClient& client) {
    identity.name = client.names().name;
    identity.class_name = client.names().class_name;
    identity.subclass = client.names().subclass;
    identity.firmware = client.config() ? client.config()->firmware : "";
    identity.battery_v = client.report()->battery_v();
    identity.baud = client.baud();
  });
  return identity;
}

}  // namespace panoptes::hw

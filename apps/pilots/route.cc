// SPDX-License-Identifier: BSD-3-Clause
#include "apps/pilots/other_pilot.h"

namespace panoptes {

std::unique_ptr<Pilot> make_route_pilot(PilotParts& parts) {
  return std::make_unique<OtherPilot>(parts.slam, "along the route", parts.open.route_done);
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/pilots/other_pilot.h"

namespace panoptes {

std::unique_ptr<Pilot> make_none_pilot(PilotParts& parts) {
  return std::make_unique<OtherPilot>(parts.slam, "nobody drives", parts.open.route_done);
}

}  // namespace panoptes

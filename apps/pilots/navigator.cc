// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/navigator.h"

#include "apps/pilots/navigator_pilot.h"

namespace panoptes {
namespace {

class ExploringPilot : public NavigatorPilot {
 public:
  explicit ExploringPilot(PilotParts& parts) : NavigatorPilot(parts, {}) {}
  bool explored() const override { return done(); }
};

}  // namespace

std::unique_ptr<Pilot> make_navigator_pilot(PilotParts& parts) {
  return std::make_unique<ExploringPilot>(parts);
}

}  // namespace panoptes

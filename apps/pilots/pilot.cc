// SPDX-License-Identifier: BSD-3-Clause
#include "apps/pilots/pilot.h"

#include <map>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "apps/teleop/teleop_console.h"

namespace panoptes {

#define PANOPTES_PILOT(name, ...) std::unique_ptr<Pilot> make_##name##_pilot(PilotParts& parts);
#include "apps/mission/pilots.inc"
#undef PANOPTES_PILOT

void Pilot::handle_hold(const Health& health, const PilotStep& /*step*/, hw::Robot& /*robot*/,
                        StopCondition& stop_condition) {
  if (!health.held_by.empty()) {
    stop_condition.hold(health);
  }
}

bool takes_terminal(const ExploreMission& mission) {
  return needs_of(mission.drive).terminal &&
         !std::holds_alternative<hw::RecordedOptions>(mission.platform);
}

std::unique_ptr<Pilot> make_pilot(const ExploreMission& mission, const OpenRobot& open, Slam* slam,
                                  std::unique_ptr<TeleopConsole> console, const Rng& rng,
                                  StageListener listener) {
  using Make = std::unique_ptr<Pilot> (*)(PilotParts&);
  const std::map<std::string_view, Make> pilots = {
#define PANOPTES_PILOT(name, ...) {#name, make_##name##_pilot},
#include "apps/mission/pilots.inc"
#undef PANOPTES_PILOT
  };
  PilotParts parts{mission, open, slam, console, rng, listener};
  return pilots.at(name_of(mission.drive))(parts);
}

std::string doing(const Slam* slam, const PilotStep& step) {
  if (slam == nullptr) {
    return step.reason;
  }
  return fmt::format("{:.1f} m2 mapped, {} keyframes, {}", step.mapped_free_m2,
                     slam->keyframes().size(), step.reason);
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include <utility>
#include <variant>
#include <vector>

#include "apps/pilots/navigator_pilot.h"

namespace panoptes {
namespace {

std::vector<Vec2> goals_of(const Drive<"goals">& drive) {
  std::vector<Vec2> goals_map;
  for (const DriveGoalPoint& point : drive.points) {
    goals_map.emplace_back(point.x_m, point.y_m);
  }
  return goals_map;
}

class GoalsPilot : public NavigatorPilot {
 public:
  explicit GoalsPilot(PilotParts& parts)
      : NavigatorPilot(parts, goals_of(std::get<Drive<"goals">>(parts.mission.drive))) {}

  std::vector<GoalProgress> goals() const override { return navigator().goals(); }
};

}  // namespace

std::unique_ptr<Pilot> make_goals_pilot(PilotParts& parts) {
  return std::make_unique<GoalsPilot>(parts);
}

}  // namespace panoptes

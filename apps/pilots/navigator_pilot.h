// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "apps/pilots/pilot.h"
#include "core/base/error.h"
#include "core/nav/navigator.h"

namespace panoptes {

/// Those whom the navigator drives.
class NavigatorPilot : public Pilot {
 public:
  NavigatorPilot(PilotParts& parts, const std::vector<Vec2>& goals_map)
      : navigator_(parts.mission.navigator, parts.mission.robot, parts.open.robot->timing(),
                   *parts.slam, parts.rng, std::move(parts.listener), goals_map) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    return navigator_.step(seen, at);
  }
  bool done() const override { return navigator_.done(); }
  std::vector<std::string> warnings() const override { return navigator_.warnings(); }

  // A robot that cannot see where it goes does not wait for ever.
  void handle_hold(const Health& health, const PilotStep& step, hw::Robot& robot,
                   StopCondition& stop_condition) override {
    Pilot::handle_hold(health, step, robot, stop_condition);
    if (step.camera_lost && !navigator_.lost_cameras().empty()) {
      stop_condition.lose_device(DeviceError(navigator_.lost_cameras()));
    }
  }

 protected:
  const Navigator& navigator() const { return navigator_; }

 private:
  Navigator navigator_;
};

}  // namespace panoptes

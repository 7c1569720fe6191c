// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/navigator.h"

#include <utility>

#include "apps/pilots/pilot.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

class NavigatorPilot : public Pilot {
 public:
  NavigatorPilot(const ExploreMission& mission, const Timing& timing, Slam& slam, const Rng& rng,
                 StageListener listener)
      : navigator_(mission.navigator, mission.robot, timing, slam, rng, std::move(listener)) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    return navigator_.step(seen, at);
  }
  bool done() const override { return navigator_.done(); }
  bool explored() const override { return navigator_.done(); }
  std::vector<std::string> warnings() const override { return navigator_.warnings(); }

  // A robot that cannot see where it goes does not wait for ever.
  void handle_hold(const Health& health, const PilotStep& step, hw::Robot& robot,
                   StopCondition& stop_condition) override {
    Pilot::handle_hold(health, step, robot, stop_condition);
    if (step.camera_lost && !navigator_.lost_cameras().empty()) {
      stop_condition.lose_device(DeviceError(navigator_.lost_cameras()));
    }
  }

 private:
  Navigator navigator_;
};

}  // namespace

std::unique_ptr<Pilot> make_navigator_pilot(PilotParts& parts) {
  return std::make_unique<NavigatorPilot>(parts.mission, parts.open.robot->timing(), *parts.slam,
                                          parts.rng, std::move(parts.listener));
}

}  // namespace panoptes

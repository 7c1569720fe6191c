// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/teleop.h"

#include <utility>

#include "apps/pilots/other_pilot.h"
#include "apps/teleop/teleop_console.h"

namespace panoptes {
namespace {

// A person who holds a key must be heard, whether pictures come or not.
constexpr double kHandDeadline_s = 0.1;

const std::string kByHand = "by hand";

// As a person drove when it was recorded.
class RecordedPilot : public OtherPilot {
 public:
  RecordedPilot(const Slam* slam, const hw::RecordedRobot& recorded)
      : OtherPilot(slam, kByHand, {}), recorded_(recorded) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    PilotStep step = OtherPilot::step(seen, at);
    command(recorded_.recorded_command().value_or(Twist2{}), step);
    return step;
  }
  Duration longest_command() const override { return kKeyHeld; }

 private:
  const hw::RecordedRobot& recorded_;
};

class HandPilot : public OtherPilot {
 public:
  HandPilot(const Slam* slam, const OpenRobot& open, std::unique_ptr<TeleopConsole> console)
      : OtherPilot(slam, kByHand, {}), open_(open), console_(std::move(console)) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    PilotStep step = OtherPilot::step(seen, at);
    if (!open_.real_time) {
      console_->keep_pace(open_.robot->now());
    }
    command(console_->command(seen, doing(slam(), step)), step);
    return step;
  }
  bool done() const override { return console_->left(); }

  // A person sees to what holds the robot.
  void handle_hold(const Health& /*health*/, const PilotStep& /*step*/, hw::Robot& robot,
                   StopCondition& /*stop_condition*/) override {
    if (console_->take_stop()) {
      robot.emergency_stop();
    } else if (console_->acknowledges()) {
      robot.acknowledge();
    }
  }
  Duration longest_wait() const override { return from_seconds(kHandDeadline_s); }
  Duration longest_command() const override { return kKeyHeld; }
  bool shows_progress() const override { return true; }
  void leave() override { console_.reset(); }

 private:
  const OpenRobot& open_;
  std::unique_ptr<TeleopConsole> console_;
};

}  // namespace

std::unique_ptr<Pilot> make_teleop_pilot(PilotParts& parts) {
  if (parts.console == nullptr) {
    return std::make_unique<RecordedPilot>(parts.slam, *parts.open.recorded);
  }
  return std::make_unique<HandPilot>(parts.slam, parts.open, std::move(parts.console));
}

}  // namespace panoptes

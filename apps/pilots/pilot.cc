// SPDX-License-Identifier: BSD-3-Clause
#include "apps/pilots/pilot.h"

#include <functional>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "apps/teleop/cockpit.h"
#include "apps/teleop/teleop.h"
#include "core/base/error.h"
#include "core/nav/navigator.h"

namespace panoptes {
namespace {

// A person who holds a key must be heard, whether pictures come or not.
constexpr double kHandDeadline_s = 0.1;

class NavigatorPilot : public Pilot {
 public:
  NavigatorPilot(const ExploreMission& mission, Slam& slam, const Rng& rng, StageListener listener)
      : navigator_(mission.navigator, mission.robot, slam, rng, std::move(listener)) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    return navigator_.step(seen, at);
  }
  bool done() const override { return navigator_.done(); }
  bool explored() const override { return navigator_.done(); }

  // A robot that cannot see where it goes stands as soon as it can, and does not wait for ever.
  void heed(const Health& health, const PilotStep& step, hw::Robot& robot, Until& until) override {
    Pilot::heed(health, step, robot, until);
    if (step.blind) {
      robot.brake_hard();
    }
    if (step.blind && !navigator_.given_up().empty()) {
      until.lose_device(DeviceError(navigator_.given_up()));
    }
  }

 private:
  Navigator navigator_;
};

// Those who plan nothing.
class OtherPilot : public Pilot {
 public:
  OtherPilot(const Slam* slam, std::string who, std::function<bool()> done)
      : slam_(slam), who_(std::move(who)), done_(std::move(done)) {}

  PilotStep step(const Observation& /*seen*/, const SlamStep& at) override {
    PilotStep step;
    step.reason = who_;
    if (!at.cameras_told.empty()) {
      step.reason += "; " + at.cameras_told;
    }
    step.mapped_free_m2 = slam_ != nullptr ? slam_->mapped_free_m2() : 0;
    return step;
  }
  bool done() const override { return done_ && done_(); }

 protected:
  const Slam* slam() const { return slam_; }
  static void command(const Twist2& command_body, PilotStep& step) {
    const bool stands = command_body.v_mps == 0 && command_body.w_radps == 0;
    step.command_body = command_body;
    step.state = stands ? PilotState::kStopped : PilotState::kDriving;
  }

 private:
  const Slam* slam_;
  std::string who_;
  std::function<bool()> done_;
};

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
  HandPilot(const Slam* slam, const OpenRobot& open, std::unique_ptr<Cockpit> cockpit)
      : OtherPilot(slam, kByHand, {}), open_(open), cockpit_(std::move(cockpit)) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    PilotStep step = OtherPilot::step(seen, at);
    if (!open_.paced) {
      cockpit_->keep_pace(open_.robot->now());
    }
    command(cockpit_->command(seen, doing(slam(), step)), step);
    return step;
  }
  bool done() const override { return cockpit_->left(); }

  // A person sees to what holds the robot.
  void heed(const Health& /*health*/, const PilotStep& /*step*/, hw::Robot& robot,
            Until& /*until*/) override {
    if (cockpit_->take_stop()) {
      robot.emergency_stop();
    } else if (cockpit_->acknowledges()) {
      robot.acknowledge();
    }
  }
  Duration longest_wait() const override { return from_seconds(kHandDeadline_s); }
  Duration longest_command() const override { return kKeyHeld; }
  bool shows_progress() const override { return true; }
  void leave() override { cockpit_.reset(); }

 private:
  const OpenRobot& open_;
  std::unique_ptr<Cockpit> cockpit_;
};

}  // namespace

void Pilot::heed(const Health& health, const PilotStep& /*step*/, hw::Robot& /*robot*/,
                 Until& until) {
  if (!health.held_by.empty()) {
    until.hold(health);
  }
}

bool by_hand(const ExploreMission& mission) {
  return std::holds_alternative<DriveByTeleop>(mission.drive) &&
         !std::holds_alternative<hw::RecordedOptions>(mission.platform);
}

std::unique_ptr<Pilot> make_pilot(const ExploreMission& mission, const OpenRobot& open, Slam* slam,
                                  std::unique_ptr<Cockpit> cockpit, const Rng& rng,
                                  StageListener listener) {
  struct Choose {
    const ExploreMission& mission;
    const OpenRobot& open;
    Slam* slam;
    std::unique_ptr<Cockpit>& cockpit;
    const Rng& rng;
    StageListener& listener;

    std::unique_ptr<Pilot> operator()(const DriveByNavigator&) const {
      return std::make_unique<NavigatorPilot>(mission, *slam, rng, std::move(listener));
    }
    std::unique_ptr<Pilot> operator()(const DriveAlongRoute&) const {
      return std::make_unique<OtherPilot>(slam, "along the route", open.route_done);
    }
    std::unique_ptr<Pilot> operator()(const DriveByTeleop&) const {
      if (cockpit == nullptr) {
        return std::make_unique<RecordedPilot>(slam, *open.recorded);
      }
      return std::make_unique<HandPilot>(slam, open, std::move(cockpit));
    }
    std::unique_ptr<Pilot> operator()(const DriveNowhere&) const {
      return std::make_unique<OtherPilot>(slam, "nobody drives", open.route_done);
    }
  };
  return std::visit(Choose{mission, open, slam, cockpit, rng, listener}, mission.drive);
}

std::string doing(const Slam* slam, const PilotStep& step) {
  if (slam == nullptr) {
    return step.reason;
  }
  return fmt::format("{:.1f} m2 mapped, {} keyframes, {}", step.mapped_free_m2,
                     slam->keyframes().size(), step.reason);
}

}  // namespace panoptes

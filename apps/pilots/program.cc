// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "apps/pilots/other_pilot.h"
#include "core/plan/motion_program.h"

namespace panoptes {
namespace {

bool is_real(const PlatformOptions& platform) {
  const auto* wired = std::get_if<PioneerOptions>(&platform);
  return wired != nullptr && wired->standin == nullptr;
}

// Drives by the wheels alone, and looks at nothing.
class ProgramPilot : public OtherPilot {
 public:
  explicit ProgramPilot(PilotParts& parts)
      : OtherPilot(parts.slam, {}, {}),
        drive_(std::get<Drive<"program">>(parts.mission.drive)),
        body_(parts.mission.robot),
        timing_(parts.open.robot->timing()),
        program_(drive_.motion, body_, timing_),
        recorded_(parts.open.recorded),
        is_real_(is_real(parts.mission.platform)) {}

  PilotStep step(const Observation& seen, const SlamStep& at) override {
    PilotStep step = OtherPilot::step(seen, at);
    const Duration since_last = last_ ? seen.stamp - *last_ : timing_.period;
    last_ = seen.stamp;
    if (seen.health.bumper_pressed && !is_elsewhere()) {
      touched_ = touch_told();
    }
    const std::optional<Odometry> odometry = told_odometry(seen, at);
    const Twist2 next = odometry ? program_.command(*odometry, since_last) : Twist2{};
    command(touched_.empty() ? next : Twist2{}, step);
    step.reason = (touched_.empty() ? program_.doing() : touched_) + step.reason;
    return step;
  }

  bool done() const override { return program_.done(); }

  void handle_hold(const Health& health, const PilotStep& step, hw::Robot& robot,
                   StopCondition& stop_condition) override {
    if (!touched_.empty()) {
      stop_condition.collide(touched_);
    } else {
      OtherPilot::handle_hold(health, step, robot, stop_condition);
    }
  }

  std::vector<std::string> warnings() const override {
    if (!is_real_) {
      return {};
    }
    return {"drive: the program does not look where it goes; see that it has " +
            room_told(drive_, body_)};
  }

  std::string unfinished() const override {
    return program_.done() || is_elsewhere()
               ? std::string()
               : "the program was not finished: the run ended in " + program_.doing();
  }

  Duration length() const override { return from_seconds(expected_s(drive_.motion, body_)); }

 private:
  // What touched a recorded robot that was driven by others says nothing of this program.
  bool is_elsewhere() const {
    return recorded_ != nullptr && recorded_->commands_diverged_at().has_value();
  }

  std::string touch_told() const {
    if (program_.done()) {
      return "something touched the robot after the last segment";
    }
    const MotionSegment& segment = program_.segments()[program_.at()];
    const double gone = std::abs(program_.gone());
    return fmt::format(
        "touched something in {}, {} from where that began; see that the program has {}, and "
        "try again",
        program_.doing(),
        segment.kind == MotionSegment::Kind::kLeg ? fmt::format("{:.2f} m", gone)
                                                  : fmt::format("{:.0f} degrees", rad_to_deg(gone)),
        room_told(drive_, body_));
  }

  Drive<"program"> drive_;
  Body body_;
  Timing timing_;
  MotionProgram program_;
  const hw::RecordedRobot* recorded_;
  bool is_real_;
  std::optional<Time> last_;
  std::string touched_;
};

}  // namespace

std::unique_ptr<Pilot> make_program_pilot(PilotParts& parts) {
  return std::make_unique<ProgramPilot>(parts);
}

}  // namespace panoptes

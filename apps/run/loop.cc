// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/loop.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <variant>

#include <fmt/format.h>

#include "apps/run/progress.h"
#include "apps/run/teleop.h"
#include "core/base/error.h"

namespace panoptes {

namespace {

// A person who holds a key must be heard, whether pictures come or not.
constexpr double kHandDeadline_s = 0.1;

bool is_teleop(const ExploreMission& mission) {
  return std::holds_alternative<DriveByTeleop>(mission.drive);
}

const char* who_drives(const DriveOptions& drive) {
  return std::holds_alternative<DriveAlongRoute>(drive) ? "along the route"
         : std::holds_alternative<DriveByTeleop>(drive) ? "by hand"
                                                        : "nobody drives";
}

}  // namespace

bool by_hand(const ExploreMission& mission) {
  return is_teleop(mission) && !std::holds_alternative<hw::RecordedOptions>(mission.platform);
}

StageListener listener(StageClock& clock) {
  return [&clock](std::string_view stage, bool begins) {
    begins ? clock.begin(stage) : clock.end(stage);
  };
}

Observation observe(hw::Robot& robot, const ExploreMission& mission, StageClock& clock) {
  const TimedStage stage(clock, "observe");
  const double longest_s = by_hand(mission) ? std::min(mission.frame_deadline_s, kHandDeadline_s)
                                            : mission.frame_deadline_s;
  return robot.observe(robot.now() + from_seconds(longest_s));
}

NavStep navigate(std::optional<Navigator>& navigator, const Observation& seen,
                 const DriveOptions& drive, StageClock& clock) {
  const TimedStage stage(clock, "step");
  NavStep step = navigator ? navigator->step(seen) : NavStep{};
  if (!std::holds_alternative<DriveByNavigator>(drive)) {
    step.command_body = {};
    step.goal_map.reset();
    step.state = NavState::kStopped;
    step.blind = false;
    step.reason = who_drives(drive);
    if (!step.cameras_told.empty()) {
      step.reason += "; " + step.cameras_told;
    }
  }
  return step;
}

NavStep driven_by_hand(NavStep step, const Twist2& command_body) {
  const bool stands = command_body.v_mps == 0 && command_body.w_radps == 0;
  step.command_body = command_body;
  step.state = stands ? NavState::kStopped : NavState::kDriving;
  return step;
}

Duration command_valid_for(const ExploreMission& mission) {
  const Duration valid_for = from_seconds(mission.command_valid_for_s);
  return is_teleop(mission) ? std::min(valid_for, kKeyHeld) : valid_for;
}

void refuse_bad_start(const ExploreMission& mission, const std::optional<Navigator>& navigator) {
  const auto* wired = std::get_if<PioneerOptions>(&mission.platform);
  const auto* simulated = std::get_if<sim::SimulatedOptions>(
      wired != nullptr && wired->standin != nullptr ? &wired->standin->platform
                                                    : &mission.platform);
  if (simulated == nullptr || !navigator || navigator->start_fault().empty()) {
    return;
  }
  const std::string& mention = simulated->start_mention;
  throw ConfigError(fmt::format(
      "{}{}platform.start: the robot cannot start {}: {}; give platform.start another pose{}",
      mention, mention.empty() ? "" : ": ", mention.empty() ? "where the seed has put it" : "here",
      navigator->start_fault(), mention.empty() ? ", or another --seed" : ""));
}

bool finished(const DriveOptions& drive, const std::optional<Navigator>& navigator,
              const OpenRobot& open) {
  if (open.recorded != nullptr &&
      (open.recorded->ended() || open.recorded->commands_diverged_at())) {
    return open.recorded->ended();
  }
  return std::holds_alternative<DriveByNavigator>(drive) ? navigator->done() : open.route_done();
}

std::size_t keyframe_count(const std::optional<Navigator>& navigator) {
  return navigator ? navigator->keyframes().size() : 0;
}

std::string doing(const std::optional<Navigator>& navigator, const NavStep& step) {
  if (!navigator) {
    return step.reason;
  }
  return fmt::format("{:.1f} m2 mapped, {} keyframes, {}", step.mapped_free_m2,
                     navigator->keyframes().size(), step.reason);
}

RunInfo run_info(const std::string& command, const ExploreMission& mission) {
  RunInfo info;
  info.command = command;
  info.version = PANOPTES_VERSION;
  info.mission = mission.name;
  info.seed = mission.seed;
  info.mission_yaml = write_settings(mission);
  info.require = requirements(mission);
  return info;
}

RunResult run_result(const std::optional<Navigator>& navigator) {
  constexpr double kCell_m = 0.01;
  RunResult result;
  if (!navigator) {
    return result;
  }
  result.graph = navigator->graph();
  // a step that was cut short may have left a keyframe without its node
  const std::size_t count = std::min(navigator->keyframes().size(), result.graph.T_map_node.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Keyframe& keyframe = navigator->keyframes()[i];
    result.keyframes.push_back(
        {keyframe.stamp, result.graph.T_map_node[i], keyframe.T_wheels_body});
  }
  result.map = navigator->map(kCell_m);
  return result;
}

namespace {

// Nothing to explore is no success for a robot that has not got away from where it stood.
bool shut_in(const Navigator& navigator, const Body& body) {
  return std::all_of(navigator.keyframes().begin(), navigator.keyframes().end(),
                     [&](const Keyframe& keyframe) {
                       return keyframe.T_wheels_body.position().norm() < body.radius_m;
                     });
}

// A few pictures lost just before the end of a run are no lost camera. One that is not good for a
// second is: the time within which a robot that steers by it stands.
constexpr double kLost_s = 1;

CameraReports lost_cameras(const CameraReports& cameras, Time now) {
  CameraReports lost = cameras;
  std::erase_if(
      lost, [now](const auto& camera) { return to_seconds(now - camera.second.since) < kLost_s; });
  return lost;
}

}  // namespace

RunEnd run_end(const Until& until, const ExploreMission& mission,
               const std::optional<Navigator>& navigator, const OpenRobot& open) {
  const bool replayed = open.recorded != nullptr;
  const std::optional<Time> diverged =
      replayed ? open.recorded->commands_diverged_at() : std::nullopt;
  const auto end = [&](const char* outcome, const std::string& reason) {
    return RunEnd{outcome,
                  reason,
                  diverged,
                  open.robot->devices(),
                  navigator ? navigator->cameras() : CameraReports{},
                  !replayed || open.recorded->touches_known()};
  };
  if (!until.device_fault().empty()) {
    return end("device_lost", until.device_fault());
  }
  if (!until.held_by().empty()) {
    return end(until.held_outcome(), "the robot is held: " + until.held_by());
  }
  if (until.interrupted()) {
    return end("interrupted", "");
  }
  if (navigator) {  // a part of the map is not to be had
    const std::string lost = told(lost_cameras(navigator->cameras(), open.robot->now()));
    if (!lost.empty()) {
      return end("device_lost", lost);
    }
  }
  const std::string reason = until.end_reason(open.robot->now(), keyframe_count(navigator));
  if (!reason.empty()) {
    return end("completed", reason);
  }
  const bool explored =
      std::holds_alternative<DriveByNavigator>(mission.drive) && navigator->done() && !diverged;
  if (replayed && !explored) {
    return end("completed", "end_of_data");
  }
  if (explored && shut_in(*navigator, mission.robot)) {
    return end("stuck", "");
  }
  return end("completed", explored ? "explored" : "goals_done");
}

sim::RendererOptions patient_renderer(const Until& until, bool quiet) {
  sim::RendererOptions options;
  options.bake_progress = [&until, line = std::make_shared<ProgressLine>(quiet)](double done) {
    if (line->due()) {
      line->show(share_line("light and shadow", done, line->wall_s()));
    }
    return !until.interrupted();
  };
  return options;
}

void print(const RunReport& report) {
  for (const std::string& line : report.summary) {
    std::printf("%s\n", line.c_str());
  }
  for (const std::filesystem::path& picture : report.pictures) {
    std::printf("%s\n", picture.c_str());
  }
}

}  // namespace panoptes

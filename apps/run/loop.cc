// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/loop.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <variant>

#include <fmt/format.h>

#include "apps/process/progress.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace panoptes {

StageListener listener(StageClock& clock) {
  return [&clock](std::string_view stage, bool begins) {
    begins ? clock.begin(stage) : clock.end(stage);
  };
}

void refuse_bad_start(const ExploreMission& mission, const Slam* slam) {
  const auto* wired = std::get_if<PioneerOptions>(&mission.platform);
  const auto* simulated = std::get_if<sim::SimulatedOptions>(
      wired != nullptr && wired->standin != nullptr ? &wired->standin->platform
                                                    : &mission.platform);
  if (simulated == nullptr || slam == nullptr || slam->start_fault().empty()) {
    return;
  }
  const std::string& mention = simulated->start_mention;
  throw ConfigError(fmt::format(
      "{}{}platform.start: the robot cannot start {}: {}; give platform.start another pose{}",
      mention, mention.empty() ? "" : ": ", mention.empty() ? "where the seed has put it" : "here",
      slam->start_fault(), mention.empty() ? ", or another --seed" : ""));
}

bool finished(const Pilot& pilot, const OpenRobot& open) {
  if (open.recorded != nullptr &&
      (open.recorded->ended() || open.recorded->commands_diverged_at())) {
    return open.recorded->ended();
  }
  return pilot.done();
}

std::size_t keyframe_count(const Slam* slam) {
  return slam == nullptr ? 0 : slam->keyframes().size();
}

RunInfo run_info(const std::string& command, const ExploreMission& mission) {
  RunInfo info;
  info.command = command;
  info.version = PANOPTES_VERSION;
  info.mission = mission.name;
  info.seed = mission.seed;
  info.mission_yaml = write_settings(mission);
  info.require = requirements(mission);
  info.rig = mission.rig;
  info.body = mission.robot;
  return info;
}

RunResult run_result(const Slam* slam) {
  constexpr double kCell_m = 0.01;
  RunResult result;
  if (slam == nullptr) {
    return result;
  }
  result.graph = pairwise(slam->graph());
  // a step that was cut short may have left a keyframe without its node
  const std::size_t count = std::min(slam->keyframes().size(), result.graph.T_map_node.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Keyframe& keyframe = slam->keyframes()[i];
    result.keyframes.push_back(
        {keyframe.stamp, result.graph.T_map_node[i], keyframe.T_wheels_body});
  }
  result.map = slam->map(kCell_m);
  if (!result.keyframes.empty()) {
    result.rig = slam->rig_estimate();
  }
  return result;
}

KeptKeyframes kept_keyframes(const Slam* slam) {
  KeptKeyframes kept;
  if (slam == nullptr) {
    return kept;
  }
  kept.looks.clear();
  for (const LoopCamera& camera : slam->loop_cameras()) {
    kept.looks.push_back(camera.looks);
  }
  for (const PlacedGrid& placed : slam->grids()) {
    const std::size_t k = kept.all.size();
    kept.all.push_back({slam->keyframes().at(k).stamp, placed.T_map_keyframe,
                        slam->place(static_cast<int>(k)), placed.grid});
  }
  return kept;
}

namespace {

// Nothing to explore is no success for a robot that has not got away from where it stood.
bool shut_in(const Slam& slam, const Body& body) {
  return std::all_of(slam.keyframes().begin(), slam.keyframes().end(),
                     [&](const Keyframe& keyframe) {
                       return keyframe.T_wheels_body.position().norm() < body.radius_m;
                     });
}

// For as long as this at least.
CameraReports lost_cameras(const CameraReports& cameras, Time now, double least_s) {
  CameraReports lost = cameras;
  std::erase_if(
      lost, [=](const auto& camera) { return to_seconds(now - camera.second.since) < least_s; });
  return lost;
}

}  // namespace

namespace {

// Of the goals that were refused, a line for all of them.
std::string refusals(const std::vector<GoalProgress>& goals) {
  std::vector<std::string> told;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    if (goals[i].state == GoalProgress::State::kRefused) {
      told.push_back(fmt::format("goal {}: {}", i + 1, goals[i].why));
    }
  }
  return joined(told, "; ");
}

}  // namespace

RunEnd run_end(const StopCondition& stop_condition, const ExploreMission& mission, const Slam* slam,
               const Pilot& pilot, const OpenRobot& open) {
  const bool replayed = open.recorded != nullptr;
  const std::optional<Time> diverged =
      replayed ? open.recorded->commands_diverged_at() : std::nullopt;
  const auto end = [&](const char* outcome, const std::string& reason) {
    return RunEnd{outcome,
                  reason,
                  diverged,
                  open.robot->devices(),
                  slam != nullptr ? slam->cameras() : CameraReports{},
                  !replayed || open.recorded->touches_known()};
  };
  if (!stop_condition.device_fault().empty()) {
    return end("device_lost", stop_condition.device_fault());
  }
  if (!stop_condition.held_by().empty()) {
    return end(stop_condition.held_outcome(), "the robot is held: " + stop_condition.held_by());
  }
  if (!stop_condition.touched().empty()) {
    return end("collision", stop_condition.touched());
  }
  if (!stop_condition.rig_fault().empty()) {
    return end("failed", stop_condition.rig_fault());
  }
  if (stop_condition.interrupted()) {
    return end("interrupted", "");
  }
  if (slam != nullptr) {  // a part of the map is not to be had
    const std::string lost =
        told(lost_cameras(slam->cameras(), open.robot->now(), mission.until.camera_lost_s));
    if (!lost.empty()) {
      return end("device_lost", lost);
    }
  }
  const std::vector<GoalProgress> goals = diverged ? std::vector<GoalProgress>{} : pilot.goals();
  if (const std::string why = refusals(goals); !why.empty()) {
    return end("goal_unreachable", why);
  }
  if (!goals.empty() && pilot.done()) {
    return end("completed", "goals_done");
  }
  const std::string reason = stop_condition.end_reason(open.robot->now(), keyframe_count(slam));
  if (!reason.empty()) {
    RunEnd ended = end("completed", reason);
    if (const std::string unfinished = pilot.unfinished(); !unfinished.empty()) {
      ended.warnings.push_back(unfinished);
    }
    return ended;
  }
  const bool explored = pilot.explored() && !diverged;
  if (replayed && !explored) {
    return end("completed", "end_of_data");
  }
  if (explored && shut_in(*slam, mission.robot)) {
    return end("stuck", fmt::format("no way that the robot, {:.2f} m wide, has room for leads from "
                                    "where it started",
                                    2 * mission.robot.radius_m));
  }
  return end("completed", explored ? "explored" : "goals_done");
}

sim::RendererOptions patient_renderer(const StopCondition& stop_condition, bool quiet) {
  sim::RendererOptions options;
  options.bake_progress = [&stop_condition,
                           line = std::make_shared<ProgressLine>(quiet)](double done) {
    if (line->due()) {
      line->show(share_line("light and shadow", done, line->wall_s()));
    }
    return !stop_condition.interrupted();
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

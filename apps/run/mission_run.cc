// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/mission_run.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include "apps/run/cockpit.h"
#include "apps/run/loop.h"
#include "apps/run/out_dir.h"
#include "apps/run/place_study.h"
#include "apps/run/progress.h"
#include "apps/run/recorder.h"
#include "apps/run/stage_clock.h"
#include "apps/run/until.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

std::vector<KeptKeyframe> kept_keyframes(const std::optional<Navigator>& navigator) {
  std::vector<KeptKeyframe> kept;
  if (!navigator) {
    return kept;
  }
  for (const PlacedGrid& placed : navigator->grids()) {
    const std::size_t k = kept.size();
    kept.push_back({navigator->keyframes()[k].stamp, placed.T_map_keyframe,
                    navigator->place(static_cast<int>(k)), placed.grid});
  }
  return kept;
}

// Empty where no person drives and none has driven.
std::optional<Twist2> hand_command(const ExploreMission& mission, std::optional<Cockpit>& cockpit,
                                   const OpenRobot& open, const Observation& seen,
                                   const std::string& doing) {
  if (cockpit) {
    if (!open.paced) {
      cockpit->keep_pace(open.robot->now());
    }
    return cockpit->command(seen, doing);
  }
  return std::holds_alternative<DriveByTeleop>(mission.drive)
             ? open.recorded->recorded_command().value_or(Twist2{})
             : std::optional<Twist2>();
}

// A person sees to what holds the robot; without one the run ends.
void heed(const Health& health, std::optional<Cockpit>& cockpit, hw::Robot& robot, Until& until) {
  if (cockpit && cockpit->take_stop()) {
    robot.emergency_stop();
  } else if (cockpit && cockpit->acknowledges()) {
    robot.acknowledge();
  } else if (!cockpit && !health.held_by.empty()) {
    until.hold(health);
  }
}

// A robot that cannot see where it goes stands as soon as it can, and does not wait for ever.
void heed_cameras(const NavStep& step, const std::optional<Navigator>& navigator, hw::Robot& robot,
                  Until& until) {
  if (!step.blind) {
    return;
  }
  robot.brake_hard();
  if (!navigator->given_up().empty()) {
    until.lose_device(DeviceError(navigator->given_up()));
  }
}

}  // namespace

int run_mission(const ExploreMission& mission, const MissionRun& run) {
  OutDir out(run.out_dir);
  Until until(mission.until);
  std::optional<Cockpit> cockpit;
  if (by_hand(mission)) {
    cockpit.emplace(mission.robot, run.quiet);
  }
  const Rng rng(mission.seed);
  RunInfo info = run_info(run.command, mission);
  info.judged = run.judged;
  OpenRobot open;
  try {
    open = open_robot(mission, rng.fork("robot"), patient_renderer(until, run.quiet));
  } catch (const sim::BakeStopped&) {
    out.keep();
    Recorder nothing(run.out_dir, info, nullptr);
    const RunReport report = nothing.write_report(std::nullopt, {}, {"interrupted", ""});
    print(report);
    return report.exit_status;
  }
  if (run.wrap) {
    run.wrap(open, run.out_dir);
  }
  if (cockpit) {
    open.route_done = [&cockpit] { return cockpit->left(); };
  }
  hw::Robot& robot = *open.robot;
  info.blind = open.rig.cameras.empty();
  info.start_unix_ns = robot.start_unix_ns();
  StageClock clock;
  std::optional<Navigator> navigator;
  if (can_navigate(open.rig)) {
    navigator.emplace(mission.navigator, mission.robot, open.rig, rng.fork("navigator"),
                      listener(clock));
  }
  std::optional<PlaceStudy> places;
  if (mission.places && navigator) {
    places.emplace(*mission.places, open.rig, open.look);
  }
  Recorder recorder(run.out_dir, info, &clock);
  Progress progress(std::min(from_seconds(mission.until.duration_s), open.length), run.quiet);
  for (const std::string& remark : open.remarks) {
    std::fprintf(stderr, "%s\n", remark.c_str());
  }

  try {
    while (!finished(mission.drive, navigator, open) &&
           !until.reached(robot.now(), keyframe_count(navigator))) {
      const Observation seen = observe(robot, mission, clock);
      NavStep step = navigate(navigator, seen, mission.drive, clock);
      refuse_bad_start(mission, navigator);
      if (const auto by_hand = hand_command(mission, cockpit, open, seen, doing(navigator, step))) {
        step = driven_by_hand(step, *by_hand);
      }
      if (places && step.keyframe_made) {
        places->add(seen);
      }
      heed(seen.health, cockpit, robot, until);
      robot.drive(step.command_body, command_valid_for(mission));
      heed_cameras(step, navigator, robot, until);
      recorder.add(seen, step);
      out.keep();
      if (navigator && recorder.snapshot_due(seen.stamp)) {
        recorder.add_snapshot(seen.stamp, navigator->planning_map());
      }
      if (!cockpit) {
        progress.show(seen.stamp, doing(navigator, step));
      }
      clock.end_frame();
    }
    robot.stop();
  } catch (const DeviceError& error) {  // what was done until then is kept
    cockpit.reset();
    std::fprintf(stderr, "%s\n", error.what());  // at once: writing what is there takes a while
    until.lose_device(error);
  }
  cockpit.reset();  // the terminal is its owner's again
  out.keep();
  const RunReport report = recorder.write_report(
      robot.truth(), run_result(navigator), run_end(until, mission, navigator, open),
      kept_keyframes(navigator), places ? &*places : nullptr);
  print(report);
  return report.exit_status;
}

}  // namespace panoptes

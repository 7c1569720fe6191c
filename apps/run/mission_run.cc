// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/mission_run.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "apps/run/cockpit.h"
#include "apps/run/fault.h"
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
    kept.push_back({navigator->keyframes().at(k).stamp, placed.T_map_keyframe,
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

// Whatever is thrown on the way, the robot stands afterwards, what is being written of the drive is
// written, and what went wrong is told: at once, for the rest takes a while. A mission that is
// refused before it has begun is thrown on.
template <class Drive>
Faults driven_to_its_end(const Drive& drive, const OpenRobot& open, const OutDir& out,
                         std::optional<Cockpit>& cockpit, Until& until) {
  Faults faults;
  std::exception_ptr refusal;
  const auto leave = [&] {  // the terminal is its owner's again
    cockpit.reset();
  };
  faults.attempt([&] {
    try {
      drive();
    } catch (const ConfigError&) {
      leave();
      if (out.kept()) {
        throw;
      }
      refusal = std::current_exception();
    } catch (const DeviceError& error) {
      leave();
      until.lose_device(error);
      throw;
    } catch (...) {
      leave();
      throw;
    }
  });
  faults.attempt([&] { open.robot->stop(); });
  leave();
  if (refusal) {
    std::rethrow_exception(refusal);
  }
  if (open.finish) {
    faults.attempt(open.finish);
  }
  return faults;
}

}  // namespace

int run_mission(const ExploreMission& mission, const MissionRun& run) {
  Until until(mission.until);
  OutDir out(run.out_dir);
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

  const auto drive = [&] {
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
  };
  Faults faults = driven_to_its_end(drive, open, out, cockpit, until);
  out.keep();
  std::optional<Truth> truth;
  RunResult result;
  std::vector<KeptKeyframe> kept;
  RunEnd end{"failed", ""};
  faults.attempt([&] { truth = robot.truth(); });
  faults.attempt([&] { result = run_result(navigator); });
  faults.attempt([&] { kept = kept_keyframes(navigator); });
  faults.attempt([&] { end = run_end(until, mission, navigator, open); });
  const RunReport report = recorder.write_report(std::move(truth), result, std::move(end), kept,
                                                 places ? &*places : nullptr, std::move(faults),
                                                 [&until] { return until.hurried(); });
  print(report);
  return report.exit_status;
}

}  // namespace panoptes

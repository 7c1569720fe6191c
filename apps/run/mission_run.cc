// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/mission_run.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "apps/command/out_dir.h"
#include "apps/listeners/listeners.h"
#include "apps/mission/stop_condition.h"
#include "apps/pilots/pilot.h"
#include "apps/process/fault.h"
#include "apps/process/stage_clock.h"
#include "apps/recognition/recognition_study.h"
#include "apps/report/recorder.h"
#include "apps/run/loop.h"
#include "apps/step/step_listener.h"
#include "apps/teleop/teleop_console.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

std::string odometry_fault(const Observation& seen, const SlamStep& at) {
  if (told_odometry(seen, at)) {
    return "";
  }
  return at.passed_over.empty() ? "the wheels tell no number" : at.passed_over;
}

// Whatever is thrown on the way, the robot stands afterwards, what is being written of the drive is
// written, and what went wrong is told: at once, for the rest takes a while. A mission that is
// refused before it has begun is thrown on.
template <class Drive>
Faults driven_to_its_end(const Drive& drive, const OpenRobot& open, const OutDir& out, Pilot& pilot,
                         Recorder& recorder, StopCondition& stop_condition) {
  Faults faults;
  std::exception_ptr refusal;
  faults.attempt([&] {
    try {
      drive();
    } catch (const ConfigError&) {
      pilot.leave();
      if (out.kept()) {
        throw;
      }
      refusal = std::current_exception();
    } catch (const DeviceError& error) {
      pilot.leave();
      stop_condition.lose_device(error);
      throw;
    } catch (...) {
      pilot.leave();
      throw;
    }
  });
  faults.attempt([&] { open.robot->stop(); });
  pilot.leave();
  if (refusal) {
    std::rethrow_exception(refusal);
  }
  faults.attempt([&] { recorder.keep_ended(); });
  if (open.finish) {
    faults.attempt(open.finish);
  }
  return faults;
}

}  // namespace

int run_mission(const ExploreMission& mission, const MissionRun& run) {
  StopCondition stop_condition(mission.until);
  OutDir out(run.out_dir);
  auto console =
      takes_terminal(mission) ? std::make_unique<TeleopConsole>(mission.robot, run.quiet) : nullptr;
  const Rng rng(mission.seed);
  RunInfo info = run_info(run.command, mission);
  info.judged = run.judged;
  OpenRobot open;
  try {
    open = open_robot(mission, rng.fork("robot"), patient_renderer(stop_condition, run.quiet));
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
  hw::Robot& robot = *open.robot;
  info.no_cameras = open.rig.cameras.empty();
  info.start_unix_ns = robot.start_unix_ns();
  StageClock clock;
  const Rng navigation = rng.fork("navigator");
  std::unique_ptr<Slam> slam;
  if (can_navigate(open.rig)) {
    slam = std::make_unique<Slam>(mission.navigator.slam, mission.robot, open.rig, navigation,
                                  listener(clock));
  }
  const std::unique_ptr<Pilot> pilot =
      make_pilot(mission, open, slam.get(), std::move(console), navigation, listener(clock));

  Recorder recorder(run.out_dir, info, &clock);
  std::optional<RecognitionStudy> places;
  std::vector<StepListener*> listeners{&recorder};
  if (mission.places && slam) {
    listeners.push_back(&places.emplace(*mission.places, open.rig, open.capture));
  }
  const std::vector<std::unique_ptr<StepListener>> others =
      make_listeners({mission, open, *pilot, slam.get(), recorder, run.quiet});
  for (const std::unique_ptr<StepListener>& other : others) {
    listeners.push_back(other.get());
  }
  for (const std::vector<std::string>& warnings : {open.warnings, pilot->warnings()}) {
    for (const std::string& warning : warnings) {
      std::fprintf(stderr, "%s\n", warning.c_str());
    }
  }

  const Duration deadline = std::min(from_seconds(mission.frame_deadline_s), pilot->longest_wait());
  const Duration valid_for =
      std::min(from_seconds(mission.command_valid_for_s), pilot->longest_command());
  std::size_t knocks = 0;
  const auto drive = [&] {
    while (!finished(*pilot, open) &&
           !stop_condition.reached(robot.now(), keyframe_count(slam.get()))) {
      clock.begin("observe");
      const Observation seen = robot.observe(robot.now() + deadline);
      clock.end("observe");
      clock.begin("step");
      const SlamStep at = slam ? slam->step(seen) : SlamStep{};
      PilotStep step = pilot->step(seen, at);
      for (; slam && knocks < slam->knocks().size(); ++knocks) {
        std::fprintf(stderr, "%s\n", told(slam->knocks()[knocks]).c_str());
      }
      if (std::string fault = slam ? slam->rig_fault() : ""; !fault.empty()) {
        step.command_body = {};
        step.reason = fault;
        stop_condition.refuse_rig(std::move(fault));
      }
      stop_condition.watch_odometry(seen.stamp, odometry_fault(seen, at));
      clock.end("step");
      refuse_bad_start(mission, slam.get());
      pilot->handle_hold(seen.health, step, robot, stop_condition);
      robot.drive(step.command_body, valid_for);
      if (step.camera_lost) {
        robot.brake_hard();
      }
      out.keep();
      for (StepListener* listener : listeners) {
        listener->add(seen, at, step);
      }
      clock.end_frame();
    }
  };
  Faults faults = driven_to_its_end(drive, open, out, *pilot, recorder, stop_condition);
  out.keep();
  std::optional<Truth> truth;
  RunResult result;
  KeptKeyframes kept;
  RunEnd end{"failed", ""};
  faults.attempt([&] { truth = robot.truth(); });
  faults.attempt([&] { result = run_result(slam.get()); });
  faults.attempt([&] { kept = kept_keyframes(slam.get()); });
  faults.attempt([&] { end = run_end(stop_condition, mission, slam.get(), *pilot, open); });
  const RunReport report = recorder.write_report(
      std::move(truth), result, std::move(end), kept, places ? &*places : nullptr,
      std::move(faults), [&stop_condition] { return stop_condition.hurried(); });
  print(report);
  return report.exit_status;
}

}  // namespace panoptes

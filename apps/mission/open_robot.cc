// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/open_robot.h"

#include <memory>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/io/dataset_gaps.h"
#include "hw/physical/physical_robot.h"
#include "hw/pioneer/base.h"
#include "hw/replay/tracked_truth.h"
#include "hw/standin/cameras.h"
#include "hw/standin/link.h"
#include "sim/world/load.h"

namespace panoptes {
namespace {

// What is driven by the wheels alone is driven blindly: the floor that it takes must be clear.
sim::SimulatedOptions with_room(sim::SimulatedOptions options, const DriveOptions& drive,
                                const Body& body) {
  if (const auto* program = std::get_if<Drive<"program">>(&drive)) {
    options.start_room.T_start_body = poses_of(program->motion);
    options.start_room.margin_m = kProgramMargin_m;
    options.start_room.needs =
        "what drive: program is to do, which needs " + room_told(*program, body);
  }
  return options;
}

OpenRobot open(const sim::SimulatedOptions& options, const ExploreMission& mission, const Rng& rng,
               const sim::RendererOptions& renderer) {
  std::unique_ptr<sim::SimulatedRobot> robot = sim::open_simulated(
      with_room(options, mission.drive, mission.robot), mission.robot, mission.rig, rng, renderer);
  OpenRobot out;
  if (options.truth.depth || options.truth.labels) {
    out.true_pictures.of_last_set = [known = robot.get()] { return known->true_pictures(); };
    out.true_pictures.things = robot->object_names();
  }
  out.capture = [eye = robot.get()](const std::string& camera) { return eye->capture(camera); };
  out.real_time = false;
  out.rig = robot->rig();
  out.route_done = [] { return false; };
  if (const auto* along = std::get_if<Drive<"route">>(&mission.drive)) {
    robot->follow(along->route);
    out.route_done = [follower = robot.get()] { return follower->route_done(); };
  }
  out.robot = std::move(robot);
  return out;
}

OpenRobot open(const hw::RecordedOptions& options, const ExploreMission& mission,
               const Rng& /*rng*/, const sim::RendererOptions& /*renderer*/) {
  Dataset dataset = read_dataset(options.dataset, mission.rig);
  OpenRobot out;
  out.rig = hw::recorded_rig(options, dataset, mission.rig);
  out.route_done = [] { return false; };  // the recording ends
  check_pictures(dataset, out.rig);
  const std::vector<std::string> gaps = gap_lines(dataset, out.rig);
  std::optional<hw::RecordedTruth> truth = hw::truth_of(options.dataset, dataset);
  auto robot = std::make_unique<hw::RecordedRobot>(std::move(dataset), out.rig, std::move(truth));
  out.length = robot->length();
  out.warnings = robot->remarks();
  out.warnings.insert(out.warnings.end(), gaps.begin(), gaps.end());
  out.real_time = false;
  out.recorded = robot.get();
  out.robot = std::move(robot);
  return out;
}

/// What an outer mission believes of a stand-in's rig: the marks of floor cameras that it says
/// nothing of are those surveyed on the stand-in.
Rig believed_of(const Rig& believed, const Rig& served) {
  Rig rig = believed;
  for (auto& [name, camera] : rig.cameras) {
    const auto there = served.cameras.find(name);
    if (there == served.cameras.end()) {
      throw ConfigError("rig.cameras." + name +
                        ": the stand-in has no such camera; leave the rig out to take the "
                        "stand-in's, or name its cameras");
    }
    if (camera.floor && !camera.floor->H_body_px && camera.floor->marks.empty() &&
        there->second.floor) {
      camera.floor->marks = there->second.floor->marks;
      camera.floor->H_body_px = there->second.floor->H_body_px;
    }
  }
  return rig;
}

hw::BaseRamp ramp_of(const Body& body) {
  return {body.max_accel_mps2, body.max_turn_accel_radps2, body.max_speed_mps, body.max_turn_radps};
}

OpenRobot open_standin(const PioneerOptions& options, const ExploreMission& mission, const Rng& rng,
                       const sim::RendererOptions& renderer) {
  const ExploreMission& served = *options.standin;
  const bool sees = options.cameras == PioneerOptions::Cameras::kStandIn;
  auto robot = sim::open_simulated(
      with_room(std::get<sim::SimulatedOptions>(served.platform), mission.drive, served.robot),
      served.robot, sees ? served.rig : Rig(), rng, renderer);
  OpenRobot out;
  out.real_time = false;
  out.route_done = [] { return false; };
  out.rig = sees ? believed_of(mission.rig, robot->rig()) : Rig();
  const hw::Robot* behind = robot.get();
  auto cameras = sees ? std::make_unique<hw::StandInCameras>() : nullptr;
  auto link = std::make_unique<hw::StandInLink>(
      std::move(robot), served.robot, options.controller, mission.robot,
      options.base == kStandInTcp ? hw::StandInLink::Wire::kTcp : hw::StandInLink::Wire::kPty,
      [to = cameras.get()](const Observation& seen) {
        if (to != nullptr) {
          to->add(seen);
        }
      });
  hw::connect(*link);
  out.robot = std::make_unique<hw::PhysicalRobot>(std::move(link), std::move(cameras),
                                                  ramp_of(mission.robot), behind);
  return out;
}

OpenRobot open(const PioneerOptions& options, const ExploreMission& mission, const Rng& rng,
               const sim::RendererOptions& renderer) {
  if (options.standin != nullptr) {
    return open_standin(options, mission, rng, renderer);
  }
  OpenRobot out;
  out.route_done = [] { return false; };
  auto base = std::make_unique<hw::PioneerBase>(options.base, mission.robot);
  hw::connect(*base);
  base->with([&](hw::PioneerClient& client) { out.warnings = client.take_remarks(); });
  out.robot = std::make_unique<hw::PhysicalRobot>(std::move(base), nullptr, ramp_of(mission.robot));
  return out;
}

void check(const sim::SimulatedOptions& options, const ExploreMission& mission, const Rng& rng) {
  sim::SimulatedRobot robot(with_room(options, mission.drive, mission.robot),
                            sim::bare_surroundings(sim::make_world(options.world), mission.robot),
                            mission.robot, mission.rig, rng);
  const auto* along = std::get_if<Drive<"route">>(&mission.drive);
  if (along != nullptr && !along->route.tour) {  // a tour is found in the world itself
    robot.follow(along->route);
  }
}

void check(const hw::RecordedOptions& options, const ExploreMission& mission, const Rng& rng) {
  open(options, mission, rng, {});
}

void check(const PioneerOptions& options, const ExploreMission& mission, const Rng& rng) {
  if (options.standin != nullptr) {
    const ExploreMission& served = *options.standin;
    check(with_room(std::get<sim::SimulatedOptions>(served.platform), mission.drive, served.robot),
          served, rng);
    if (options.cameras == PioneerOptions::Cameras::kStandIn) {
      believed_of(mission.rig, served.rig);
    }
  }
}

Rng platform_rng(const ExploreMission& mission) { return Rng(mission.seed).fork("robot"); }

}  // namespace

OpenRobot open_robot(const ExploreMission& mission, const Rng& rng,
                     const sim::RendererOptions& renderer) {
  OpenRobot out = std::visit(
      [&](const auto& options) { return open(options, mission, rng, renderer); }, mission.platform);
  for (const std::string& doubt : mission.rig.doubts) {
    out.warnings.push_back("the rig's calibration is not to be trusted: " + doubt);
  }
  return out;
}

std::unique_ptr<hw::Robot> open_robot_without_cameras(const ExploreMission& mission,
                                                      const Rng& rng) {
  if (const auto* wired = std::get_if<PioneerOptions>(&mission.platform);
      wired != nullptr && wired->standin != nullptr) {
    return open_robot_without_cameras(*wired->standin, rng);
  }
  const auto* options = std::get_if<sim::SimulatedOptions>(&mission.platform);
  if (options == nullptr) {
    throw ConfigError(mission.name +
                      ": platform: neither a recording nor a real robot can be served; name a "
                      "mission whose platform is simulated");
  }
  return sim::open_without_cameras(*options, mission.robot, rng);
}

void check_platform(const ExploreMission& mission) {
  std::visit([&](const auto& options) { check(options, mission, platform_rng(mission)); },
             mission.platform);
}

}  // namespace panoptes

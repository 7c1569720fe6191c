// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/open_robot.h"

#include <utility>
#include <variant>

#include "sim/world/load.h"

namespace panoptes {
namespace {

OpenRobot open(const sim::SimulatedOptions& options, const ExploreMission& mission, const Rng& rng,
               const sim::RendererOptions& renderer) {
  std::unique_ptr<sim::SimulatedRobot> robot =
      sim::open_simulated(options, mission.robot, mission.rig, rng, renderer);
  OpenRobot out;
  if (options.truth.depth || options.truth.labels) {
    out.true_pictures.of_last_set = [known = robot.get()] { return known->true_pictures(); };
    out.true_pictures.things = robot->object_names();
  }
  out.look = [eye = robot.get()](const std::string& camera) { return eye->look(camera); };
  out.rig = robot->rig();
  out.route_done = [] { return false; };
  if (const auto* along = std::get_if<DriveAlongRoute>(&mission.drive)) {
    robot->follow(along->route);
    out.route_done = [follower = robot.get()] { return follower->route_done(); };
  }
  out.robot = std::move(robot);
  return out;
}

OpenRobot open(const hw::RecordedOptions& options, const ExploreMission& mission,
               const Rng& /*rng*/, const sim::RendererOptions& /*renderer*/) {
  Dataset dataset = read_dataset(options.dataset);
  OpenRobot out;
  out.rig = hw::recorded_rig(options, dataset, mission.rig);
  out.route_done = [] { return false; };  // the recording ends
  check_pictures(dataset, out.rig);
  auto robot = std::make_unique<hw::RecordedRobot>(std::move(dataset), out.rig,
                                                   hw::RecordedTruth::read(options.dataset));
  out.length = robot->length();
  out.remarks = robot->remarks();
  out.recorded = robot.get();
  out.robot = std::move(robot);
  return out;
}

void check(const sim::SimulatedOptions& options, const ExploreMission& mission, const Rng& rng) {
  const sim::SimulatedRobot robot(
      options, sim::bare_surroundings(sim::make_world(options.world), mission.robot), mission.robot,
      mission.rig, rng);
}

void check(const hw::RecordedOptions& options, const ExploreMission& mission, const Rng& rng) {
  open(options, mission, rng, {});
}

Rng platform_rng(const ExploreMission& mission) { return Rng(mission.seed).fork("robot"); }

}  // namespace

OpenRobot open_robot(const ExploreMission& mission, const Rng& rng,
                     const sim::RendererOptions& renderer) {
  return std::visit([&](const auto& options) { return open(options, mission, rng, renderer); },
                    mission.platform);
}

void check_platform(const ExploreMission& mission) {
  std::visit([&](const auto& options) { check(options, mission, platform_rng(mission)); },
             mission.platform);
}

}  // namespace panoptes

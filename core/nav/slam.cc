// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/slam.h"

#include <utility>

namespace panoptes {
Slam::Slam(const SlamOptions& options, const Body& body, const Rig& rig, const Rng& rng,
           StageListener listener)
    : listener_(std::move(listener)),
      cameras_(rig, options.camera_health),
      rectifier_(rig),
      odometry_(make_odometry({options.localiser.odometry, options.localiser.wheels, body, rig})),
      localiser_(options.localiser, *odometry_, rectifier_.rig(), rng.fork("localiser")),
      mapper_(options.mapper, body, rectifier_.rig()) {}

OccupancyMap Slam::map(double cell_m) const {
  return mapper_.finished_map(cell_m, localiser_.graph().T_map_node);
}

bool Slam::something_came() const { return mapper_.something_came(); }

std::optional<std::vector<Vec2>> Slam::standing() const {
  return mapper_.standing(graph().T_map_node);
}

OccupancyMap Slam::planning_map() {
  OccupancyMap map = mapper_.map(localiser_.graph().T_map_node);
  mapped_free_m2_ = map.area_m2(Cell::kFree);
  return map;
}

SlamStep Slam::step(const Observation& raw) {
  const std::optional<Odometry> odometry = odometry_->at(raw);
  if (!odometry) {
    SlamStep step;
    step.stamp = raw.stamp;
    step.T_map_body = T_map_body_;
    step.T_odom_body = T_odom_body_;
    step.cameras_told = told(cameras_.reports());
    step.passed_over = odometry_->fault();
    return step;
  }
  Observation seen = raw;
  seen.odometry = *odometry;
  if (told(cameras_.check(seen)).empty()) {
    return step_accepted(seen);
  }
  return step_accepted(cameras_.accepted(seen));
}

std::string Slam::rig_fault() const {
  if (!localiser_.rig_fault().empty()) {
    return localiser_.rig_fault();
  }
  const std::string clock = cameras_.wrong_clock();
  return clock.empty() ? mapper_.rig_fault() : clock;
}

SlamStep Slam::step_accepted(const Observation& accepted) {
  if (!rectifier_.bends()) {
    return step_straight(accepted);
  }
  Observation straight;
  {
    const StageScope scope(listener_, "rectifying");
    straight = rectifier_.rectified(accepted);
  }
  return step_straight(straight);
}

SlamStep Slam::step_straight(const Observation& seen) {
  SlamStep step;
  step.stamp = seen.stamp;
  step.odometry = seen.odometry;
  step.cameras_told = told(cameras_.reports());
  const std::vector<Pose2>& T_map_nodes = localiser_.graph().T_map_node;
  const Located located = localiser_.step(
      seen, [&](int keyframe) { return mapper_.contour(keyframe, T_map_nodes); }, listener_,
      cameras_.reports());
  step.T_map_body = T_map_body_ = located.T_map_body;
  step.T_odom_body = T_odom_body_ = located.T_odom_body;
  step.keyframe = located.keyframe;
  step.keyframe_made = located.keyframe_made;
  step.closures = located.closures;
  step.relaxed = located.relaxed;
  {
    const StageScope scope(listener_, "mapping");
    Mapped mapped = mapper_.step(seen, located, localiser_.keyframes(), T_map_nodes);
    step.floor = std::move(mapped.reading);
    step.local_odom = std::move(mapped.local_odom);
  }
  if (!looked_at_floor_ && step.floor.projection) {
    looked_at_floor_ = true;
    start_fault_ = step.floor.sees_floor ? "" : step.floor.fault;
  }
  return step;
}

}  // namespace panoptes

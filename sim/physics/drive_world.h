// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "core/eval/truth.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "sim/physics/dynamic_objects.h"
#include "sim/physics/obstacles.h"

namespace panoptes::sim {

/// What the wheels roll in one step.
struct Motion {
  double forward_m = 0;
  double turn_rad = 0;
};

/// The robot's body among obstacles and dynamic objects: a disc with a differential drive that
/// follows the commanded velocity within its limits of speed and acceleration, and is stopped by
/// what it touches. Advances by steps of 1/120 s. Where nothing is touched every step is an exact
/// arc; contacts are Box2D's.
class DriveWorld {
 public:
  static constexpr std::int64_t kStepsPerSecond = 120;

  DriveWorld(const Body& body, const Obstacles& obstacles, const Pose2& T_scene_body,
             DynamicObjects dynamic_objects = {});
  ~DriveWorld();

  /// Followed until `expires`; then the robot brakes to a stop.
  void drive(const Twist2& command_body, Time expires);
  /// As hard as the tyres hold, whatever it was told, until it stands or is driven again.
  void brake_hard();
  void step();

  std::int64_t steps() const;
  Time now() const;  ///< steps / 120 s, rounded to nanoseconds
  Pose2 T_scene_body() const;
  Twist2 twist_body() const;
  Motion last_motion() const;  ///< of the last step
  double path_m() const;
  double clearance_m() const;
  const DynamicObjects& dynamic_objects() const;
  bool touching() const;
  const std::vector<double>& touch_bearings_rad() const;  ///< in the body; one a place or more
  const std::vector<TrueContact>& contacts() const;

 private:
  class Impl;  // of Box2D, unknown here
  std::unique_ptr<Impl> impl_;
};

/// The gap between a body there and whatever is nearest, the dynamic objects standing at `places`.
double clearance_m(const Obstacles& obstacles, const DynamicObjects& dynamic_objects,
                   const std::vector<Pose2>& places, const Body& body, const Vec2& at_scene);

/// The instant of a step: step / 120 s, rounded to whole nanoseconds.
Time time_of_step(std::int64_t step);

}  // namespace panoptes::sim

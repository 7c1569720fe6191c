// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes::sim {

struct Waypoint {
  double x_m = 0;  ///< in scene
  double y_m = 0;
};
void bind(Fields& f, Waypoint& o);

/// A way through the scene, driven in order.
struct Route {
  std::vector<Waypoint> waypoints;
  double speed_mps = 0.4;
};
void bind(Fields& f, Route& o);

/// Follows a route on the true pose: turns towards the next waypoint, drives to it, stops at the
/// last.
class RouteFollower {
 public:
  RouteFollower(const Route& route, const Body& body);

  Twist2 command(const Pose2& T_scene_body);
  bool done() const { return next_ >= route_.waypoints.size(); }

 private:
  Route route_;
  Body body_;
  std::size_t next_ = 0;
  bool driving_ = false;  // towards the next waypoint, not turning to it
};

}  // namespace panoptes::sim

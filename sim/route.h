// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
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

/// A path that is found in the world itself, see sim/tour.h.
struct TourOptions {
  double length_m = 600;  ///< how long it is
  double apart_m = 2;     ///< between the places that it visits
  int returns = 15;       ///< to earlier places, before it has been everywhere
  double return_m = 8;    ///< how far back each leads
};
void bind(Fields& f, TourOptions& o);

/// A path through the scene, driven in order: as written, or a tour of the world.
struct Route {
  std::vector<Waypoint> waypoints;
  double speed_mps = 0.4;
  std::optional<TourOptions> tour = {};
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

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/route.h"

#include <algorithm>
#include <cmath>

namespace panoptes::sim {
namespace {

constexpr double kArrived_m = 0.05;     // of a waypoint
constexpr double kTurnFirst_rad = 0.5;  // farther off the robot stands and turns
constexpr double kAligned_rad = 0.05;   // then it sets off
constexpr double kTurnGain_per_s = 2;

// The largest speed from which the rest can still be braked away.
double braking_speed(double rest, double acceleration) {
  return std::sqrt(2 * acceleration * std::max(0.0, rest));
}

}  // namespace

void bind(Fields& f, Waypoint& o) {
  f.needed("x_m", o.x_m);
  f.needed("y_m", o.y_m);
}

void bind(Fields& f, TourOptions& o) {
  f("length_m", o.length_m, between(1, 1e5));
  f("apart_m", o.apart_m, between(0.5, 100));
  f("returns", o.returns, not_negative);
  f("return_m", o.return_m, positive);
  f.renamed("way_m", "length_m");
}

void bind(Fields& f, Route& o) {
  f("waypoints", o.waypoints);
  f("tour", o.tour);
  f("speed_mps", o.speed_mps, positive);
  f.require(o.tour || !o.waypoints.empty(), "waypoints",
            "must hold at least one waypoint; or give tour: {}, which finds a way of its own");
  f.require(!o.tour || o.waypoints.empty(), "tour", "must not stand beside waypoints");
}

RouteFollower::RouteFollower(const Route& route, const Body& body) : route_(route), body_(body) {}

Twist2 RouteFollower::command(const Pose2& T_scene_body) {
  while (!done()) {
    const Waypoint& goal = route_.waypoints[next_];
    const Vec2 to_goal = Vec2(goal.x_m, goal.y_m) - T_scene_body.position();
    const double bearing_rad =
        wrap_angle(std::atan2(to_goal.y(), to_goal.x()) - T_scene_body.theta_rad);
    // Arrived as well when it has come alongside: there is no use in turning back for millimetres.
    if (to_goal.norm() < kArrived_m ||
        (driving_ && to_goal.norm() < 2 * kArrived_m && std::cos(bearing_rad) <= 0)) {
      ++next_;
      driving_ = false;
      continue;
    }
    if (std::abs(bearing_rad) > kTurnFirst_rad) {
      driving_ = false;
    } else if (std::abs(bearing_rad) < kAligned_rad) {
      driving_ = true;
    }
    // Half of what the robot could do is left to the lag between command and motion.
    const double turn_radps =
        std::min({kTurnGain_per_s * std::abs(bearing_rad), body_.max_turn_radps,
                  braking_speed(std::abs(bearing_rad), body_.max_turn_accel_radps2 / 2)});
    const double speed_mps =
        driving_ ? std::min({route_.speed_mps, body_.max_speed_mps,
                             braking_speed(to_goal.norm(), body_.max_accel_mps2 / 2)})
                 : 0.0;
    return {speed_mps, std::copysign(turn_radps, bearing_rad)};
  }
  return {};
}

}  // namespace panoptes::sim

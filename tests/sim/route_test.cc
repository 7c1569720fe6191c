// SPDX-License-Identifier: BSD-3-Clause
#include "sim/route.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/config/fields.h"
#include "sim/physics/drive_world.h"

namespace panoptes::sim {
namespace {

TEST(RouteFollower, PassesEveryWaypointAndStandsAtTheLast) {
  const Obstacles nothing({});
  const Body body;
  const Route route{{{2, 0}, {2, 2}, {0, 2}, {-1, -1}}, 0.5};
  DriveWorld world(body, nothing, {0, 0, -2});
  RouteFollower follower(route, body);
  std::vector<double> nearest_m(route.waypoints.size(), 1e9);
  double fastest_mps = 0;
  for (int i = 0; i < 120 * 60; ++i) {
    world.drive(follower.command(world.T_scene_body()), Time::max());
    world.step();
    for (std::size_t k = 0; k < nearest_m.size(); ++k) {
      const Vec2 goal(route.waypoints[k].x_m, route.waypoints[k].y_m);
      nearest_m[k] = std::min(nearest_m[k], (world.T_scene_body().position() - goal).norm());
    }
    fastest_mps = std::max(fastest_mps, world.twist_body().v_mps);
  }
  EXPECT_TRUE(follower.done());
  for (const double distance_m : nearest_m) {
    EXPECT_LE(distance_m, 0.05);  // what counts as there
  }
  EXPECT_LE((world.T_scene_body().position() - Vec2(-1, -1)).norm(), 0.05);
  EXPECT_EQ(world.twist_body().v_mps, 0);
  EXPECT_EQ(world.twist_body().w_radps, 0);
  EXPECT_NEAR(fastest_mps, 0.5, 1e-9);
}

TEST(Route, NeedsWaypointsOrATour) {
  const auto read = [](const char* text) { return read_settings_text<Route>(text, "way.yaml"); };
  EXPECT_EQ(read("waypoints: [{x_m: 1, y_m: 2}]\nspeed_mps: 0.3\n").waypoints.size(), 1U);
  EXPECT_EQ(read("tour: {length_m: 30}\n").tour->length_m, 30);
  EXPECT_THROW(read("tour: {}\nwaypoints: [{x_m: 1, y_m: 2}]\n"), ConfigError);
  EXPECT_THROW(read("waypoints: []\n"), ConfigError);
  EXPECT_THROW(read("speed_mps: 0.3\n"), ConfigError);
  try {
    read("tour: {way_m: 30}\n");
    ADD_FAILURE() << "way_m is refused";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.lines(),
                testing::ElementsAre("way.yaml:1:8: tour.way_m: way_m is now length_m"));
  }
  EXPECT_THROW(read("waypoints: [{x_m: 1}]\n"), ConfigError);
}

}  // namespace
}  // namespace panoptes::sim

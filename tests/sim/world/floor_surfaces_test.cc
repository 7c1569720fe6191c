// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/floor_surfaces.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/sim/world/boxes.h"

namespace panoptes::sim {
namespace {

void put(World& world, const std::vector<Triangle>& triangles,
         Object::Kind kind = Object::Kind::kFixed) {
  world.objects.emplace_back();
  world.objects.back().triangles = triangles;
  world.objects.back().kind = kind;
}

/// A floor (0), a line of paint across it (1) for -0.06 < x < 0.06, a rug (2) over some of both.
World painted_floor() {
  World world;
  put(world, floor_sheet());
  put(world, box({-0.06, -5, 0}, {0.06, 5, 0.004}, 1));
  put(world, box({-1, -1, 0}, {1, 1, 0.008}, 2));
  return world;
}

TEST(FloorSurfaces, CountsWhatIsSeenFromAbove) {
  const FloorSurfaces floor(painted_floor());
  EXPECT_EQ(floor.looks_within(0.7, {3, 3}), 1);
  EXPECT_EQ(floor.looks_within(0.7, {0.5, 3}), 2);
  EXPECT_EQ(floor.looks_within(0.7, {0.5, 1.3}), 3);
  EXPECT_EQ(floor.looks_within(0.7, {0, 0}), 1) << "the rug hides the rest";
  EXPECT_EQ(floor.looks_within(0.7, {8, 8}), 0) << "beside the floor";
  EXPECT_EQ(FloorSurfaces().looks_within(0.7, {0, 0}), 0);
}

TEST(FloorSurfaces, UnderASunLieInItsLightAndInShadow) {
  World world = painted_floor();
  world.sun = Sun{};
  EXPECT_EQ(FloorSurfaces(world).looks_within(0.7, {3, 3}), 2);
  EXPECT_EQ(FloorSurfaces(world).looks_within(0.7, {0.5, 3}), 4);
}

TEST(FloorSurfaces, ThingsThatStandOnTheFloorAreNoneOfIt) {
  World world = painted_floor();
  put(world, box({2.8, 2.8, 0}, {3.2, 3.2, 0.5}, 3));
  put(world, box({2.8, 2.8, -0.2}, {3.2, 3.2, -0.1}, 3));
  put(world, box({2.8, 2.8, 0}, {3.2, 3.2, 0.01}, 3), Object::Kind::kPerson);
  EXPECT_EQ(FloorSurfaces(world).looks_within(0.7, {3, 3}), 1);
}

TEST(FloorSurfaces, StandWhereTheirObjectStands) {
  World world = painted_floor();
  world.objects[1].T_scene_object = on_floor({0, 3, deg_to_rad(90)});
  const FloorSurfaces floor(world);
  EXPECT_EQ(floor.looks_within(0.7, {3, 3.5}), 2);
  EXPECT_EQ(floor.looks_within(0.7, {0.5, 4}), 1);
}

}  // namespace
}  // namespace panoptes::sim

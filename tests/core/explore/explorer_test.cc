// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/explorer.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

Explorer make_explorer(const ExploreOptions& options = {}) {
  return {options, Body(), FloorWedge(), Rng(1)};
}

/// A room of 6 x 4 m of which the part beyond x = 3 m is unknown.
OccupancyMap half_known() {
  OccupancyMap map = test::empty_room(6, 4, 0.01);
  test::fill(map, 3, 0, 6, 4, Cell::kUnknown);
  return map;
}

TEST(Explorer, LooksTowardsTheUnknown) {
  Explorer explorer = make_explorer();
  const ExploreChoice choice = explorer.choose(Time(), half_known(), {1, 2, deg_to_rad(180)});
  ASSERT_TRUE(choice.goal) << choice.reason;
  EXPECT_TRUE(choice.frontier_reachable);
  EXPECT_LT(choice.goal->pose_map.x_m, 3);
  EXPECT_LT(std::abs(choice.goal->pose_map.theta_rad), deg_to_rad(60));
  EXPECT_GT(choice.goal->gain_m2, 1);
}

TEST(Explorer, IsDoneInAKnownRoom) {
  Explorer explorer = make_explorer();
  const ExploreChoice choice = explorer.choose(Time(), test::empty_room(6, 4, 0.01), {1, 2, 0});
  EXPECT_FALSE(choice.goal);
  EXPECT_FALSE(choice.frontier_reachable);
}

TEST(Explorer, DoesNotHopeForWhatTheRobotCannotReach) {
  // A niche 30 cm wide behind a gap, and an unknown patch inside a desk: neither takes the robot.
  OccupancyMap map = test::empty_room(6, 4, 0.01);
  test::fill(map, 5, 0, 6, 4, Cell::kOccupied);
  test::fill(map, 5, 2, 6, 2.3, Cell::kUnknown);
  test::fill(map, 2, 1, 3, 2, Cell::kOccupied);
  test::fill(map, 2.3, 1.3, 2.7, 1.7, Cell::kUnknown);
  const ExploreChoice choice = make_explorer().choose(Time(), map, {1, 2, 0});
  EXPECT_FALSE(choice.goal);
  EXPECT_FALSE(choice.frontier_reachable);
}

TEST(Explorer, IgnoresWhatIsBehindAWall) {
  OccupancyMap map = half_known();
  test::fill(map, 2.95, 0, 3, 4, Cell::kOccupied);
  EXPECT_FALSE(make_explorer().choose(Time(), map, {1, 2, 0}).frontier_reachable);
}

TEST(Explorer, KeepsItsGoalWhileNothingIsClearlyBetter) {
  Explorer explorer = make_explorer();
  const OccupancyMap map = half_known();
  const ExploreChoice first = explorer.choose(Time(), map, {1, 2, 0});
  const ExploreChoice second = explorer.choose(time_at(1), map, {1.1, 2, 0.1});
  ASSERT_TRUE(first.goal && second.goal);
  EXPECT_EQ(first.goal->pose_map, second.goal->pose_map);
}

TEST(Explorer, LeavesAGoalGivenUpAlone) {
  ExploreOptions options;
  Explorer explorer = make_explorer(options);
  const OccupancyMap map = half_known();
  const ExploreChoice first = explorer.choose(Time(), map, {1, 2, 0});
  ASSERT_TRUE(first.goal);
  explorer.give_up(Time());
  const ExploreChoice second = explorer.choose(time_at(1), map, {1, 2, 0});
  ASSERT_TRUE(second.goal);
  EXPECT_GT((second.goal->pose_map.position() - first.goal->pose_map.position()).norm(),
            options.blacklist_m);
}

TEST(Explorer, StopsHopingForWhatNeverComesIntoView) {
  // The map never changes however often the robot looks: it must come to an end all the same.
  Explorer explorer = make_explorer();
  const OccupancyMap map = half_known();
  Pose2 T_map_body{1, 2, 0};
  int looks = 0;
  for (; looks < 100; ++looks) {
    const ExploreChoice choice = explorer.choose(time_at(5.0 * looks), map, T_map_body);
    if (!choice.goal) {
      EXPECT_FALSE(choice.frontier_reachable);
      break;
    }
    T_map_body = choice.goal->pose_map;
    explorer.reached();
  }
  EXPECT_LT(looks, 100);
}

TEST(Explorer, DrawsTheThesissRandomGoalsInItsSquareAndFartherAfterTooLong) {
  ExploreOptions options;
  options.method = RandomOptions();
  Explorer explorer = make_explorer(options);
  const OccupancyMap map = test::empty_room(12, 12, 0.01);
  const Pose2 T_map_body{6, 6, 0};
  bool farther = false;
  for (int i = 0; i < 40; ++i) {
    const ExploreChoice choice = explorer.choose(time_at(i), map, T_map_body);
    ASSERT_TRUE(choice.goal) << choice.reason;
    const double off =
        (choice.goal->pose_map.position() - T_map_body.position()).cwiseAbs().maxCoeff();
    if (i < 30) {
      EXPECT_LE(off, 1.5);
    }
    farther = farther || off > 1.5;
    explorer.reached();
  }
  EXPECT_TRUE(farther);
}

}  // namespace
}  // namespace panoptes

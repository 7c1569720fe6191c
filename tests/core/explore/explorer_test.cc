// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/explorer.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

Explorer make_explorer(const ExploreOptions& options = {}) {
  return {options, Body(), FloorWedge(), Rng(1)};
}

/// What an explorer with these defaults is given to choose by.
DrivableGrid grid_of(const OccupancyMap& map) {
  const SearchOptions search;
  return drivable_grid_of_coarse(search, Body(), coarsen(map, search.cell_m, FloorWedge().far_m));
}

/// A room of 6 x 4 m of which the part beyond x = 3 m is unknown.
OccupancyMap half_known() {
  OccupancyMap map = test::empty_room(6, 4, 0.01);
  test::fill(map, 3, 0, 6, 4, Cell::kUnknown);
  return map;
}

TEST(Explorer, LooksTowardsTheUnknown) {
  Explorer explorer = make_explorer();
  const ExploreChoice choice =
      explorer.choose(Time(), grid_of(half_known()), {1, 2, deg_to_rad(180)});
  ASSERT_TRUE(choice.goal) << choice.reason;
  EXPECT_TRUE(choice.frontier_reachable);
  EXPECT_LT(choice.goal->pose_map.x_m, 3);
  EXPECT_LT(std::abs(choice.goal->pose_map.theta_rad), deg_to_rad(60));
  EXPECT_GT(choice.goal->information_gain_m2, 1);
}

TEST(Explorer, IsDoneInAKnownRoom) {
  Explorer explorer = make_explorer();
  const ExploreChoice choice =
      explorer.choose(Time(), grid_of(test::empty_room(6, 4, 0.01)), {1, 2, 0});
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
  const ExploreChoice choice = make_explorer().choose(Time(), grid_of(map), {1, 2, 0});
  EXPECT_FALSE(choice.goal);
  EXPECT_FALSE(choice.frontier_reachable);
}

TEST(Explorer, DoesNotHopeForWhatThePlannerWouldRefuse) {
  // A hall behind a gap that the body would fit into, but for what the planner keeps.
  const auto hopes = [](double gap_m) {
    OccupancyMap map = test::empty_room(6, 4, 0.01);
    test::fill(map, 3, 0, 3.1, 4, Cell::kOccupied);
    test::fill(map, 3, 2, 6, 2 + gap_m, Cell::kUnknown);
    test::fill(map, 3.1, 0.1, 5.9, 3.9, Cell::kUnknown);
    return make_explorer().choose(Time(), grid_of(map), {1, 2.3, 0}).frontier_reachable;
  };
  const double planner_m = 2 * (Body().radius_m + from_afar(SearchOptions()).margin_m);
  EXPECT_FALSE(hopes(2 * Body().radius_m + 0.02));
  EXPECT_TRUE(hopes(planner_m + 0.1));
}

TEST(Explorer, IgnoresWhatIsBehindAWall) {
  OccupancyMap map = half_known();
  test::fill(map, 2.95, 0, 3, 4, Cell::kOccupied);
  EXPECT_FALSE(make_explorer().choose(Time(), grid_of(map), {1, 2, 0}).frontier_reachable);
}

/// Along the walls of a room of 6 x 4 m, but for the east wall from y = 1.3 to 2.7 m.
std::vector<Vec2> standing_but_for_a_doorway() {
  std::vector<Vec2> standing;
  for (double x = 0; x <= 6; x += 0.1) {
    standing.emplace_back(x, 0);
    standing.emplace_back(x, 3.99);
  }
  for (double y = 0; y <= 4; y += 0.1) {
    standing.emplace_back(0, y);
    if (std::abs(y - 2) > 0.7) {
      standing.emplace_back(5.99, y);
    }
  }
  return standing;
}

TEST(Explorer, LooksFromNearByAtAnObstacleThatNothingIsKnownToStandOn) {
  const DrivableGrid grid = grid_of(test::empty_room(6, 4, 0.01));
  std::vector<Vec2> standing = standing_but_for_a_doorway();
  Explorer explorer = make_explorer();
  const Pose2 T_map_body{1, 2, 0};
  const Vec2 doorway(5.9, 2);
  std::vector<double> ranges_m;
  for (int looks = 0; looks < 20; ++looks) {
    const ExploreChoice choice =
        explorer.choose(time_at(5.0 * looks), grid, T_map_body, {}, &standing);
    if (!choice.goal) {
      break;
    }
    const Pose2& view = choice.goal->pose_map;
    const Vec2 to_doorway = view.inverse() * doorway;
    EXPECT_LT(std::abs(std::atan2(to_doorway.y(), to_doorway.x())), deg_to_rad(60));
    ranges_m.push_back(to_doorway.norm());
    explorer.reached();
  }
  ASSERT_GE(ranges_m.size(), 2U) << "once from near by, and once nearer";
  EXPECT_LT(ranges_m.size(), 10U) << "and not for ever";
  EXPECT_LT(ranges_m.front(), 1.6);
  EXPECT_LT(ranges_m.back(), 1.0);

  EXPECT_FALSE(make_explorer().choose(Time(), grid, T_map_body).goal)
      << "where nobody looks for what stands, an obstacle is one";
  standing.emplace_back(5.99, 1.5);
  standing.emplace_back(5.99, 2);
  standing.emplace_back(5.99, 2.5);
  EXPECT_FALSE(make_explorer().choose(Time(), grid, T_map_body, {}, &standing).goal);
}

TEST(Explorer, WhatIsInViewOfARobotThatDrivesHasBeenLookedAt) {
  const DrivableGrid grid = grid_of(test::empty_room(6, 4, 0.01));
  const std::vector<Vec2> standing = standing_but_for_a_doorway();
  const auto looks = [&](const std::vector<Pose2>& T_map_keyframes) {
    return make_explorer()
        .choose(Time(), grid, {1, 2, 0}, T_map_keyframes, &standing)
        .goal.has_value();
  };
  EXPECT_FALSE(looks({{4.2, 2, 0}, {4.5, 2, 0}, {4.8, 2, 0}, {5.1, 2, 0}, {5.4, 2, 0}}));
  EXPECT_TRUE(looks({{5, 2, -0.2}, {5, 2, 0}, {5, 2, 0.2}, {5, 2, 0.4}})) << "it only turned";
  EXPECT_TRUE(looks({{4.2, 2, 3.1}, {4.5, 2, 3.1}, {4.8, 2, 3.1}, {5.1, 2, 3.1}})) << "away";
}

/// A room of 6 x 4 m whose east wall has not been seen, nor what is left and right of two openings
/// in the north and in the south wall.
OccupancyMap with_two_openings() {
  OccupancyMap map = test::empty_room(6, 4, 0.01);
  test::fill(map, 0.3, 3.9, 1.5, 4, Cell::kUnknown);
  test::fill(map, 4.5, 0, 5.7, 0.1, Cell::kUnknown);
  return map;
}

TEST(Explorer, LooksWhereTheWayToATargetMayLead) {
  const DrivableGrid grid = grid_of(with_two_openings());
  const Pose2 T_map_body{3, 2, 0};
  const ExploreChoice north =
      make_explorer().choose(Time(), grid, T_map_body, {}, nullptr, ExploreTarget{{1, 6}});
  ASSERT_TRUE(north.goal) << north.reason;
  EXPECT_GT(north.goal->pose_map.theta_rad, 0);
  EXPECT_LT(north.goal->pose_map.x_m, 3);
  const ExploreChoice south =
      make_explorer().choose(Time(), grid, T_map_body, {}, nullptr, ExploreTarget{{5, -2}});
  ASSERT_TRUE(south.goal) << south.reason;
  EXPECT_LT(south.goal->pose_map.theta_rad, 0);
  EXPECT_GT(south.goal->pose_map.x_m, 3);
}

TEST(Explorer, LooksTowardsATargetThatLiesFarOutsideTheMap) {
  const DrivableGrid grid = grid_of(half_known());
  const Pose2 T_map_body{1, 2, deg_to_rad(180)};
  const ExploreTarget far{{5000, -3000}};
  EXPECT_EQ(make_explorer().outlook(far, grid, T_map_body), TargetOutlook::kOpen);
  const ExploreChoice choice = make_explorer().choose(Time(), grid, T_map_body, {}, nullptr, far);
  ASSERT_TRUE(choice.goal) << choice.reason;
  EXPECT_LT(std::abs(choice.goal->pose_map.theta_rad), deg_to_rad(90));
}

// Of two unknown patches in a room, each of which shows enough, that alone counts in which the
// target is: the other cannot be on the way.
TEST(Explorer, LeavesUnknownFloorAloneThatNoWayToTheTargetLeadsOver) {
  OccupancyMap map = test::empty_room(8, 4, 0.01);
  test::fill(map, 2, 1, 3, 3, Cell::kUnknown);
  test::fill(map, 6.5, 1, 7.5, 3, Cell::kUnknown);
  const ExploreChoice choice =
      make_explorer().choose(Time(), grid_of(map), {1, 2, 0}, {}, nullptr, ExploreTarget{{7, 2}});
  ASSERT_TRUE(choice.goal) << choice.reason;
  EXPECT_GT(choice.goal->pose_map.x_m, 3);
}

TEST(Explorer, StopsLookingForAWayThatNeverComesIntoView) {
  Explorer explorer = make_explorer();
  const OccupancyMap map = half_known();
  Pose2 T_map_body{1, 2, 0};
  int looks = 0;
  for (; looks < 100; ++looks) {
    const ExploreChoice choice = explorer.choose(time_at(5.0 * looks), grid_of(map), T_map_body, {},
                                                 nullptr, ExploreTarget{{5, 3}});
    if (!choice.goal) {
      break;
    }
    T_map_body = choice.goal->pose_map;
    explorer.reached();
  }
  EXPECT_LT(looks, 100);
}

TEST(Explorer, TellsWhatTheMapSaysOfATarget) {
  const Pose2 T_map_body{1, 2, 0};
  const auto outlook = [&](const OccupancyMap& map, const Vec2& target_map) {
    return make_explorer().outlook({target_map}, grid_of(map), T_map_body);
  };
  const OccupancyMap room = test::empty_room(6, 4, 0.01);
  EXPECT_EQ(outlook(room, {5, 2}), TargetOutlook::kOpen);
  EXPECT_EQ(outlook(room, {5.95, 2}), TargetOutlook::kObstructed);
  EXPECT_EQ(outlook(room, {6.5, 2}), TargetOutlook::kNoWay) << "behind the wall";
  EXPECT_EQ(outlook(room, {60, 2}), TargetOutlook::kNoWay) << "outside all that is known";
  EXPECT_EQ(outlook(half_known(), {6.5, 2}), TargetOutlook::kOpen);
  EXPECT_EQ(outlook(half_known(), {60, 2}), TargetOutlook::kOpen);
  OccupancyMap desk = room;
  test::fill(desk, 3, 1, 5, 3, Cell::kOccupied);
  test::fill(desk, 3.1, 1.1, 4.9, 2.9, Cell::kUnknown);
  EXPECT_EQ(outlook(desk, {4, 2}), TargetOutlook::kNoWay) << "inside a thing";
}

TEST(Explorer, KeepsItsGoalWhileNothingIsClearlyBetter) {
  Explorer explorer = make_explorer();
  const OccupancyMap map = half_known();
  const ExploreChoice first = explorer.choose(Time(), grid_of(map), {1, 2, 0});
  const ExploreChoice second = explorer.choose(time_at(1), grid_of(map), {1.1, 2, 0.1});
  ASSERT_TRUE(first.goal && second.goal);
  EXPECT_EQ(first.goal->pose_map, second.goal->pose_map);
}

// What is near may block every way for a moment; the map alone is asked then.
TEST(Explorer, KeepsItsGoalWhileOneOfItsGridsHasNoWayToAny) {
  Explorer explorer = make_explorer();
  const OccupancyMap map = half_known();
  OccupancyMap walled_in = map;
  test::fill(walled_in, 1.5, 0, 1.6, 4, Cell::kOccupied);
  const ExploreChoice first = explorer.choose(Time(), grid_of(map), {1, 2, 0});
  const ExploreChoice none = explorer.choose(time_at(1), grid_of(walled_in), {1, 2.1, -1.5});
  const ExploreChoice second = explorer.choose(time_at(1), grid_of(map), {1, 2.1, -1.5});
  ASSERT_TRUE(first.goal && second.goal);
  EXPECT_FALSE(none.goal);
  EXPECT_EQ(first.goal->pose_map, second.goal->pose_map);
  const ExploreChoice anew = make_explorer().choose(time_at(1), grid_of(map), {1, 2.1, -1.5});
  ASSERT_TRUE(anew.goal);
  EXPECT_NE(first.goal->pose_map, anew.goal->pose_map) << "the pose tells the two apart";
}

// What a view counts through a gap between two cells is seen from there, or looking would never
// end.
TEST(Explorer, EndsWhereNoLookShowsAnything) {
  for (int world = 0; world < 5; ++world) {
    Rng rng(100 + world);
    OccupancyMap map = test::empty_room(8, 8, 0.05);
    for (int patch = 0; patch < 6; ++patch) {
      const double x = rng.uniform(0.5, 6);
      const double y = rng.uniform(0.5, 6);
      test::fill(map, x, y, x + rng.uniform(0.5, 1.8), y + rng.uniform(0.5, 1.8), Cell::kUnknown);
    }
    for (int post = 0; post < 60; ++post) {
      const double x = rng.uniform(0, 7.9);
      const double y = rng.uniform(0, 7.9);
      test::fill(map, x, y, x + 0.05, y + 0.05, Cell::kOccupied);
    }
    test::fill(map, 0.1, 0.1, 0.9, 0.9, Cell::kFree);
    Explorer explorer = make_explorer();
    Pose2 here{0.5, 0.5, 0};
    int looks = 0;
    for (; looks < 300; ++looks) {
      const ExploreChoice choice = explorer.choose(time_at(looks), grid_of(map), here);
      if (!choice.goal) {
        break;
      }
      here = choice.goal->pose_map;
      explorer.reached();
    }
    EXPECT_LT(looks, 300) << world;
  }
}

TEST(Explorer, EndsWhereNoLookShowsAnythingThatOneOfItsGridsHopesFor) {
  // What is near stands before the unknown floor that the map alone shows.
  OccupancyMap blocked = half_known();
  test::fill(blocked, 2.95, 0, 6, 4, Cell::kOccupied);
  const DrivableGrid near = grid_of(blocked);
  const DrivableGrid by_map = grid_of(half_known());
  Explorer explorer = make_explorer();
  Pose2 T_map_body{1, 2, 0};
  for (int looks = 0; looks < 40; ++looks) {
    const Time now = time_at(5.0 * looks);
    ExploreChoice choice = explorer.choose(now, near, T_map_body);
    if (!choice.goal) {
      choice = explorer.choose(now, by_map, T_map_body);
    }
    if (!choice.goal) {
      return;
    }
    T_map_body = choice.goal->pose_map;
    explorer.reached();
  }
  FAIL() << "it looks for ever";
}

TEST(Explorer, LeavesAGoalGivenUpAlone) {
  ExploreOptions options;
  Explorer explorer = make_explorer(options);
  const OccupancyMap map = half_known();
  const ExploreChoice first = explorer.choose(Time(), grid_of(map), {1, 2, 0});
  ASSERT_TRUE(first.goal);
  explorer.abandon(Time(), grid_of(map).clearance.map);
  const ExploreChoice second = explorer.choose(time_at(1), grid_of(map), {1, 2, 0});
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
    const ExploreChoice choice = explorer.choose(time_at(5.0 * looks), grid_of(map), T_map_body);
    if (!choice.goal) {
      EXPECT_FALSE(choice.frontier_reachable);
      break;
    }
    T_map_body = choice.goal->pose_map;
    explorer.reached();
  }
  EXPECT_LT(looks, 100);
}

// What a relaxation does that takes every keyframe, and with them the map, as far.
constexpr double kMoved_m = 0.5;
OccupancyMap moved(OccupancyMap map) {
  map.origin += Vec2::Constant(kMoved_m);
  return map;
}
Pose2 moved(const Pose2& T) { return {T.x_m + kMoved_m, T.y_m + kMoved_m, T.theta_rad}; }

TEST(Explorer, ItsGoalAndThoseGivenUpMoveWithTheMap) {
  ExploreOptions options;
  constexpr double kRoundoff = 1e-9;
  const std::vector<Pose2> before = {{1, 2, 0}, {2.5, 2, 1}};
  const std::vector<Pose2> after = {moved(before[0]), moved(before[1])};
  for (const bool given_up : {false, true}) {
    Explorer explorer = make_explorer(options);
    const ExploreChoice first = explorer.choose(Time(), grid_of(half_known()), {1, 2, 0}, before);
    ASSERT_TRUE(first.goal);
    if (given_up) {
      explorer.abandon(Time(), grid_of(half_known()).clearance.map, before);
    }
    const ExploreChoice second =
        explorer.choose(time_at(1), grid_of(moved(half_known())), moved({1, 2, 0}), after);
    ASSERT_TRUE(second.goal);
    const double off =
        (second.goal->pose_map.position() - moved(first.goal->pose_map).position()).norm();
    if (given_up) {
      EXPECT_GT(off, options.blacklist_m);
    } else {
      EXPECT_NEAR(off, 0, kRoundoff);
    }
  }
}

TEST(Explorer, WhatNeverCameIntoViewIsNotHopedForAgainWhereTheMapHasMoved) {
  Explorer explorer = make_explorer();
  const OccupancyMap map = half_known();
  Pose2 T_map_body{1, 2, 0};
  std::vector<Pose2> T_map_keyframes = {T_map_body};
  double at_s = 0;
  for (; at_s < 500; at_s += 5) {
    const ExploreChoice choice =
        explorer.choose(time_at(at_s), grid_of(map), T_map_body, T_map_keyframes);
    if (!choice.goal) {
      break;
    }
    T_map_body = choice.goal->pose_map;
    T_map_keyframes.push_back(T_map_body);
    explorer.reached();
  }
  ASSERT_LT(at_s, 500);
  for (Pose2& T : T_map_keyframes) {
    T = moved(T);
  }
  EXPECT_FALSE(
      explorer.choose(time_at(at_s), grid_of(moved(map)), moved(T_map_body), T_map_keyframes).goal);
}

TEST(Explorer, DrawsTheThesissRandomGoalsInItsSquareAndFartherAfterTooLong) {
  ExploreOptions options;
  options.method = RandomOptions();
  Explorer explorer = make_explorer(options);
  const OccupancyMap map = test::empty_room(12, 12, 0.01);
  const Pose2 T_map_body{6, 6, 0};
  bool farther = false;
  for (int i = 0; i < 40; ++i) {
    const ExploreChoice choice = explorer.choose(time_at(i), grid_of(map), T_map_body);
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

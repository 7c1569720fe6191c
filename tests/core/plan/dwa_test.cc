// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/dwa.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

const DwaOptions kOptions;
constexpr double kCycle_s = 0.067;
const Body kBody;

ClearanceMap open_floor() { return clearance_map(test::empty_room(8, 8, 0.02), 1); }

DwaRequest request_at(const Pose2& T_odom_body, const Twist2& twist, const Vec2& lookahead) {
  DwaRequest request;
  request.T_odom_body = T_odom_body;
  request.twist_body = twist;
  request.cycle_s = kCycle_s;
  request.longest_cycle_s = kCycle_s;
  request.lookahead_odom = lookahead;
  return request;
}

double gap(const ClearanceMap& map, const Vec2& p) {
  const std::size_t i = map.index(map.column(p), map.row(p));
  return std::min(map.to_occupied_m[i], map.to_unknown_m[i]) - kBody.radius_m;
}

TEST(Dwa, DrivesStraightAndFasterTowardsALookaheadPointAhead) {
  const DwaResult result =
      choose_arc(kOptions, kBody, open_floor(), request_at({4, 4, 0}, {0.3, 0}, {4.7, 4}));
  ASSERT_TRUE(result.choice);
  EXPECT_NEAR(result.choice->command_body.w_radps, 0,
              1e-9);  // keeping straight on is in the window
  EXPECT_NEAR(result.choice->command_body.v_mps, 0.3 + kBody.max_accel_mps2 * kCycle_s, 1e-9);
}

TEST(Dwa, MirroredLookaheadPointsGiveMirroredCommands) {
  // The robot's middle on a cell's centre, so that the map is its own mirror image too.
  for (const double side : {0.1, 0.3, 0.6}) {
    const DwaResult left = choose_arc(kOptions, kBody, open_floor(),
                                      request_at({4.01, 4.01, 0}, {0.4, 0}, {4.61, 4.01 + side}));
    const DwaResult right = choose_arc(kOptions, kBody, open_floor(),
                                       request_at({4.01, 4.01, 0}, {0.4, 0}, {4.61, 4.01 - side}));
    ASSERT_TRUE(left.choice && right.choice);
    EXPECT_GT(left.choice->command_body.w_radps, 0);
    EXPECT_NEAR(left.choice->command_body.w_radps, -right.choice->command_body.w_radps, 1e-9);
    EXPECT_NEAR(left.choice->command_body.v_mps, right.choice->command_body.v_mps, 1e-9);
  }
}

TEST(Dwa, StaysWithinWhatTheBodyCanDo) {
  Rng rng(3);
  const ClearanceMap floor = open_floor();
  for (int i = 0; i < 200; ++i) {
    const Twist2 now{rng.uniform(0, 0.6), rng.uniform(-1.5, 1.5)};
    const DwaResult result = choose_arc(
        kOptions, kBody, floor,
        request_at({4, 4, rng.uniform(-3, 3)}, now, {rng.uniform(3, 5), rng.uniform(3, 5)}));
    if (!result.choice) {
      continue;
    }
    const Twist2& command = result.choice->command_body;
    constexpr double kRoundoff = 1e-9;
    EXPECT_LE(std::abs(command.v_mps - now.v_mps), kBody.max_accel_mps2 * kCycle_s + kRoundoff);
    EXPECT_LE(std::abs(command.w_radps - now.w_radps),
              kBody.max_turn_accel_radps2 * kCycle_s + kRoundoff);
    EXPECT_GE(command.v_mps, 0);
    EXPECT_LE(command.v_mps, kBody.max_speed_mps);
    EXPECT_LE(std::abs(command.w_radps), kBody.max_turn_radps);
  }
}

// The law that keeps the robot whole: whatever lookahead point it steers for, driving on by the
// chosen command for the reaction time and then braking on the same arc touches nothing.
TEST(Dwa, CanAlwaysStopInTime) {
  Rng rng(4);
  for (int world = 0; world < 10; ++world) {
    OccupancyMap map = test::empty_room(6, 6, 0.02);
    for (int i = 0; i < 12; ++i) {
      const Vec2 p(rng.uniform(0, 6), rng.uniform(0, 6));
      test::fill(map, p.x(), p.y(), p.x() + 0.3, p.y() + 0.3,
                 i % 3 == 0 ? Cell::kUnknown : Cell::kOccupied);
    }
    const ClearanceMap clear = clearance_map(map, 1);
    for (int drive = 0; drive < 10; ++drive) {
      Pose2 T{rng.uniform(0.5, 5.5), rng.uniform(0.5, 5.5), rng.uniform(-3, 3)};
      if (gap(clear, T.position()) < 0.08) {
        continue;
      }
      const Vec2 lookahead(rng.uniform(0, 6), rng.uniform(0, 6));
      Twist2 twist;
      for (int i = 0; i < 100; ++i) {
        const DwaResult result =
            choose_arc(kOptions, kBody, clear, request_at(T, twist, lookahead));
        if (result.choice) {
          twist = result.choice->command_body;
        } else {
          const double v = std::max(0.0, twist.v_mps - kBody.max_accel_mps2 * kCycle_s);
          twist = {v, twist.v_mps > 0 ? twist.w_radps * v / twist.v_mps : 0};
        }
        T = T * exp_twist(twist, kCycle_s);
        // Distances are between the centres of cells: half a cell may be missing.
        ASSERT_GE(gap(clear, T.position()), -0.5 * clear.map.cell_m)
            << "world " << world << " drive " << drive << " step " << i;
      }
    }
  }
}

TEST(Dwa, TreatsTheUnknownAsAWall) {
  OccupancyMap map = test::empty_room(4, 4, 0.02);
  test::fill(map, 2.45, 0, 4, 4, Cell::kUnknown);
  const DwaResult result =
      choose_arc(kOptions, kBody, clearance_map(map, 1), request_at({2.17, 2, 0}, {0, 0}, {3, 2}));
  EXPECT_TRUE(!result.choice || result.choice->command_body.v_mps == 0);
}

// How far it may drive on towards a passage with `spare_m` to each side of the body.
double free_path_through_m(double spare_m, Cell sides) {
  OccupancyMap map = test::empty_room(4, 4, 0.02);
  const double half_m = kBody.radius_m + spare_m;
  test::fill(map, 1.4, 0, 3, 2.01 - half_m, sides);
  test::fill(map, 1.4, 2.01 + half_m, 3, 4, sides);
  const DwaResult result = choose_arc(kOptions, kBody, clearance_map(map, 1),
                                      request_at({1, 2.01, 0}, {0.02, 0}, {1.7, 2.01}));
  return result.choice ? result.choice->free_path_m : 0;
}

TEST(Dwa, KeepsLessFromUnknownFloorThanFromThings) {
  for (const double spare_m : {0.02, 0.03}) {
    EXPECT_GT(free_path_through_m(spare_m, Cell::kUnknown), 0.9) << spare_m;
    EXPECT_LT(free_path_through_m(spare_m, Cell::kOccupied), 0.5) << spare_m;
  }
  EXPECT_LT(free_path_through_m(-0.02, Cell::kUnknown), 0.5);
  EXPECT_GT(free_path_through_m(0.08, Cell::kOccupied), 0.9);
}

TEST(Dwa, GetsOutOfTheMarginItStandsIn) {
  OccupancyMap map = test::empty_room(4, 4, 0.02);
  // One centimetre from a wall along its right side, less than the margin.
  const DwaResult result = choose_arc(kOptions, kBody, clearance_map(map, 1),
                                      request_at({2, 0.285, 0.3}, {0, 0}, {2.6, 0.6}));
  ASSERT_TRUE(result.choice);
  EXPECT_GT(result.choice->command_body.v_mps, 0);
}

TEST(Dwa, HandsBackItsWindowWhenAsked) {
  DwaRequest request = request_at({4, 4, 0}, {0.3, 0}, {4.7, 4});
  EXPECT_TRUE(choose_arc(kOptions, kBody, open_floor(), request).window.empty());
  request.keep_window = true;
  const DwaResult result = choose_arc(kOptions, kBody, open_floor(), request);
  EXPECT_EQ(result.window.size(),
            static_cast<std::size_t>(kOptions.speed_samples * kOptions.turn_samples));
  for (const WindowScore& candidate : result.window) {
    EXPECT_GE(candidate.score, 0);
    EXPECT_LE(candidate.score, 1);
  }
}

}  // namespace
}  // namespace panoptes

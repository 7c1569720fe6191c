// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/room_plan.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes::sim {
namespace {

constexpr double kRoundoff_m = 1e-12;

TEST(RoomPlan, AWallHasPiecesBetweenItsOpeningsAndAboveThem) {
  WorldSettings settings;
  WallSettings wall;
  wall.from = Vec2(1, 2);
  wall.to = Vec2(1, 8);
  wall.openings = {{0, 1, 2.1}, {3, 4.5, 2.0}};
  put_wall(settings, wall);
  ASSERT_EQ(settings.boxes.size(), 4U);  // lintel, piece, lintel, piece
  EXPECT_NEAR(settings.boxes[0].z_m, 2.1, kRoundoff_m);
  EXPECT_NEAR(settings.boxes[1].size_m.x(), 2, kRoundoff_m);
  EXPECT_NEAR(settings.boxes[1].at.y_m, 4, kRoundoff_m);
  EXPECT_NEAR(settings.boxes[2].size_m.z(), kRoomHeight_m - 2.0, kRoundoff_m);
  EXPECT_NEAR(settings.boxes[3].size_m.x(), 1.5, kRoundoff_m);
  EXPECT_NEAR(settings.boxes[3].at.theta_rad, std::numbers::pi / 2, kRoundoff_m);
}

TEST(RoomPlan, AFaceLooksIntoTheRoomFromItsLeftToItsRight) {
  const WallFace south({4, 0}, {0, 0});  // seen from the room to its north
  const Pose2 at = south.at(1);
  EXPECT_NEAR(at.x_m, 3, kRoundoff_m);
  EXPECT_NEAR(at.theta_rad, std::numbers::pi / 2, kRoundoff_m);
  EXPECT_NEAR(south.along({3, 5}), 1, kRoundoff_m);
}

TEST(RoomPlan, NothingHangsOverAnotherThingOrOverTheEdge) {
  WorldSettings settings;
  WallFace face({0, 0}, {3, 0});
  const Hanging poster{"office/poster_01", {0.7, 0.7}};
  EXPECT_TRUE(hang(settings, face, poster, 1, 1.5));
  EXPECT_FALSE(hang(settings, face, poster, 1.5, 1.5));
  EXPECT_FALSE(hang(settings, face, poster, 2.8, 1.5));
  EXPECT_TRUE(hang(settings, face, poster, 2, 1.5));
  EXPECT_EQ(settings.objects.size(), 2U);
}

TEST(RoomPlan, AWallIsDressedAsFarAsAskedFor) {
  const auto hung = [](double share) {
    WorldSettings settings;
    WallFace face({0, 0}, {8, 0});
    Rng rng(1);
    dress(settings, face, share, rng);
    return settings.objects.size();
  };
  EXPECT_EQ(hung(0), 0U);
  EXPECT_GT(hung(1), 20U);
  EXPECT_LT(hung(0.4), hung(1));
}

TEST(RoomPlan, SkirtingEndsAtADoor) {
  WorldSettings settings;
  WallFace face({0, 0}, {4, 0});
  ASSERT_TRUE(put_door(settings, face, 2));
  put_skirting(settings, face);
  ASSERT_EQ(settings.boxes.size(), 2U);
  EXPECT_NEAR(settings.boxes[0].size_m.y() + settings.boxes[1].size_m.y(), 4 - 1.02, 0.15);
}

TEST(RoomPlan, FloorIsTakenWithClearance) {
  FloorSpace floor({0, 0}, {4, 4});
  const Rectangle desk = FloorSpace::outline({1, 1, std::numbers::pi / 2}, {0.8, 1.6});
  EXPECT_NEAR(desk.high.x() - desk.low.x(), 1.6, kRoundoff_m);
  floor.take(desk);
  const Rectangle beside = FloorSpace::outline({1, 2, 0}, {0.4, 0.4});
  EXPECT_TRUE(floor.is_clear(beside, 0.3));
  EXPECT_FALSE(floor.is_clear(beside, 0.5));
  EXPECT_FALSE(floor.is_clear(FloorSpace::outline({3.9, 3, 0}, {0.4, 0.4})));
}

}  // namespace
}  // namespace panoptes::sim

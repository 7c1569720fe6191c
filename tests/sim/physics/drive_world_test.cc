// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/drive_world.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/sim/physics/rooms.h"

namespace panoptes::sim {
namespace {

using testing::SizeIs;

constexpr double kRoundoff = 1e-9;  // of thousands of steps, each to a few ulps at room scale
// Box2D lets shapes sink into one another by up to three of its slops (0.25 mm here).
constexpr double kSlop_m = 0.00075;
const Time kForever = Time::max();

void run(DriveWorld& world, double seconds) {
  const std::int64_t end =
      world.steps() + std::llround(seconds * static_cast<double>(DriveWorld::kStepsPerSecond));
  while (world.steps() < end) {
    world.step();
  }
}

Body quick() {  // reaches any speed within a step, so that an arc is known from its start
  Body body;
  body.max_accel_mps2 = 1e6;
  body.max_turn_accel_radps2 = 1e6;
  return body;
}

TEST(TimeOfStep, IsTheNearestNanosecondAndNeverDrifts) {
  EXPECT_EQ(time_of_step(0).time_since_epoch().count(), 0);
  EXPECT_EQ(time_of_step(1).time_since_epoch().count(), 8'333'333);
  EXPECT_EQ(time_of_step(2).time_since_epoch().count(), 16'666'667);
  EXPECT_EQ(time_of_step(120).time_since_epoch().count(), 1'000'000'000);
  EXPECT_EQ(time_of_step(120LL * 86'400 * 365).time_since_epoch().count(),
            86'400LL * 365 * 1'000'000'000);
}

TEST(DriveWorld, DrivesExactArcs) {
  const Obstacles obstacles(walls(10));
  const Pose2 start{5, 5, 0.3};
  for (const Twist2 twist : {Twist2{0.4, 0}, Twist2{0, 1.2}, Twist2{0.4, 0.5}, Twist2{-0.3, 0.7}}) {
    DriveWorld world(quick(), obstacles, start);
    world.drive(twist, kForever);
    run(world, 4);
    const Pose2 expected = start * exp_twist(twist, 4);
    EXPECT_NEAR(world.T_scene_body().x_m, expected.x_m, kRoundoff);
    EXPECT_NEAR(world.T_scene_body().y_m, expected.y_m, kRoundoff);
    EXPECT_NEAR(wrap_angle(world.T_scene_body().theta_rad - expected.theta_rad), 0, kRoundoff);
    EXPECT_NEAR(world.path_m(), std::abs(twist.v_mps) * 4, kRoundoff);
    EXPECT_THAT(world.contacts(), SizeIs(0));
  }
}

TEST(DriveWorld, KeepsWithinItsSpeedsAndAccelerations) {
  const Obstacles obstacles(walls(10));
  const Body body;
  DriveWorld world(body, obstacles, {5, 5, 0});
  Rng rng(3);
  Twist2 before;
  for (int i = 0; i < 2000; ++i) {
    if (i % 20 == 0) {
      world.drive({rng.uniform(-2, 2), rng.uniform(-5, 5)}, kForever);
    }
    world.step();
    const Twist2 now = world.twist_body();
    const double step_s = 1.0 / DriveWorld::kStepsPerSecond;
    EXPECT_LE(std::abs(now.v_mps), body.max_speed_mps);
    EXPECT_LE(std::abs(now.w_radps), body.max_turn_radps);
    EXPECT_LE(std::abs(now.v_mps - before.v_mps), body.max_accel_mps2 * step_s + kRoundoff);
    EXPECT_LE(std::abs(now.w_radps - before.w_radps),
              body.max_turn_accel_radps2 * step_s + kRoundoff);
    before = now;
  }
}

TEST(DriveWorld, BrakesWhenTheCommandExpires) {
  const Obstacles obstacles(walls(10));
  const Body body;
  DriveWorld world(body, obstacles, {2, 5, 0});
  world.drive({0.6, 0.5}, time_at(2));
  run(world, 2);
  EXPECT_NEAR(world.twist_body().v_mps, 0.6, kRoundoff);
  const double path_m = world.path_m();
  run(world, 0.6 / body.max_accel_mps2 + 0.1);
  EXPECT_EQ(world.twist_body().v_mps, 0);
  EXPECT_EQ(world.twist_body().w_radps, 0);
  const double step_m = 0.6 / DriveWorld::kStepsPerSecond;
  EXPECT_NEAR(world.path_m() - path_m, 0.6 * 0.6 / (2 * body.max_accel_mps2), step_m);
}

TEST(DriveWorld, IsStoppedByAWallAndCountsOneContact) {
  const Obstacles obstacles(walls(4));
  DriveWorld world(Body{}, obstacles, {2, 2, 0});
  world.drive({0.6, 0}, kForever);
  run(world, 10);
  EXPECT_NEAR(world.T_scene_body().x_m, 4 - 0.25, kSlop_m);
  EXPECT_NEAR(world.T_scene_body().y_m, 2, kSlop_m);
  EXPECT_NEAR(world.twist_body().v_mps, 0, 0.01);
  EXPECT_LE(world.clearance_m(), kSlop_m);
  EXPECT_TRUE(world.touching());
  ASSERT_THAT(world.contacts(), SizeIs(1));
  const TrueContact& contact = world.contacts().front();
  EXPECT_EQ(contact.object, "east wall");
  EXPECT_TRUE(contact.while_moving);
  EXPECT_NEAR(contact.p_scene.x(), 4, kSlop_m);
  EXPECT_NEAR(contact.p_scene.y(), 2, kSlop_m);
  // 0.5 s and 0.3 m less 0.15 m to reach 0.6 m/s, the rest at that speed
  EXPECT_NEAR(to_seconds(contact.stamp), 1 + (1.75 - 0.3) / 0.6, 0.01);
}

TEST(DriveWorld, CountsAContactAgainOnlyAfterASecondApart) {
  const Obstacles obstacles(walls(4));
  DriveWorld world(Body{}, obstacles, {3.5, 2, 0});
  const auto touch_and_part = [&](double apart_s) {
    world.drive({0.2, 0}, kForever);
    run(world, 3);
    EXPECT_TRUE(world.touching());
    world.drive({-0.2, 0}, world.now() + from_seconds(apart_s / 3));
    run(world, apart_s / 3);
    world.drive({0, 0}, kForever);
    run(world, apart_s / 3);
    EXPECT_FALSE(world.touching());
  };
  touch_and_part(0.3);
  touch_and_part(6);
  EXPECT_THAT(world.contacts(), SizeIs(1));
  touch_and_part(0.3);
  EXPECT_THAT(world.contacts(), SizeIs(2));
}

TEST(DriveWorld, TurnsAndBacksAwayFromWhatItTouches) {
  const Obstacles obstacles(walls(4));
  DriveWorld world(Body{}, obstacles, {3.5, 2, 0});
  world.drive({0.3, 0}, kForever);
  run(world, 3);
  world.drive({0, 1}, kForever);
  run(world, 2);
  EXPECT_NEAR(world.T_scene_body().x_m, 3.75, kSlop_m);
  EXPECT_GT(world.T_scene_body().theta_rad, 1);
  world.drive({0.3, 0.5}, kForever);
  run(world, 2);
  EXPECT_GT(world.clearance_m(), 0.1);
}

TEST(DriveWorld, KnowsWhereOnItsBodyItIsTouched) {
  constexpr double kSlop_rad = 0.01;  // contacts are of before a step
  std::vector<Outline> things{{"room", {{0, 0}, {4, 0}, {4, 4}, {0, 4}}}};
  const Obstacles obstacles(things);
  DriveWorld world(Body{}, obstacles, {3.5, 3.5, deg_to_rad(45)});
  EXPECT_THAT(world.touch_bearings_rad(), testing::IsEmpty());
  world.drive({0.3, 0}, kForever);
  run(world, 3);  // into the corner
  EXPECT_THAT(world.touch_bearings_rad(),
              testing::UnorderedElementsAre(testing::DoubleNear(deg_to_rad(45), kSlop_rad),
                                            testing::DoubleNear(deg_to_rad(-45), kSlop_rad)));
  world.drive({-0.2, 0}, kForever);
  run(world, 1);
  EXPECT_THAT(world.touch_bearings_rad(), testing::IsEmpty());
}

TEST(DriveWorld, NeverEntersAnythingHoweverItIsDriven) {
  std::vector<Outline> things = walls(4);
  things.push_back(box("desk", 1, 1, 2.6, 1.8));
  things.push_back({"pillar", {{3, 3}, {3.3, 3}, {3.15, 3.4}}});
  things.push_back({"screen", {{1, 3}, {2, 3.2}}});  // a sheet
  const Obstacles obstacles(things);
  Rng rng(11);
  DriveWorld world(Body{}, obstacles, {0.5, 0.5, 0});
  for (int i = 0; i < 12'000; ++i) {
    if (i % 60 == 0) {
      world.drive({rng.uniform(-0.2, 0.6), rng.uniform(-1.5, 1.5)}, kForever);
    }
    world.step();
    const std::optional<Nearest> nearest = obstacles.nearest(world.T_scene_body().position());
    ASSERT_TRUE(nearest);
    ASSERT_GE(nearest->distance_m, 0.25 - kSlop_m) << "in " << nearest->outline->object;
  }
  EXPECT_GT(world.contacts().size(), 5U);
}

TEST(DriveWorld, RepeatsItselfBitForBit) {
  const Obstacles obstacles(walls(3));
  const auto drive = [&] {
    DriveWorld world(Body{}, obstacles, {1.5, 1.5, 0});
    Rng rng(5);
    for (int i = 0; i < 6000; ++i) {
      if (i % 40 == 0) {
        world.drive({rng.uniform(-0.6, 0.6), rng.uniform(-1.5, 1.5)}, kForever);
      }
      world.step();
    }
    return world.T_scene_body();
  };
  EXPECT_TRUE(drive() == drive());
}

}  // namespace
}  // namespace panoptes::sim

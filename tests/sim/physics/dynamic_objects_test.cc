// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/dynamic_objects.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "sim/physics/drive_world.h"
#include "tests/sim/physics/rooms.h"

namespace panoptes::sim {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

constexpr double kRoundoff = 1e-9;   // of thousands of steps, each to a few ulps at room scale
constexpr double kSlop_m = 0.00075;  // see drive_world_test.cc
const Disc kFarAway{{1000, 1000}, 0.25};
const Time kForever = Time::max();

// A block of 1 m height, its middle at its origin.
Object block(const std::string& name, const Pose2& at, double x_m, double y_m) {
  Object object;
  object.name = name;
  object.kind = Object::Kind::kMovable;
  object.T_scene_object = on_floor(at);
  const std::array<Vec2, 4> feet{Vec2(-x_m / 2, -y_m / 2), Vec2(x_m / 2, -y_m / 2),
                                 Vec2(x_m / 2, y_m / 2), Vec2(-x_m / 2, y_m / 2)};
  const auto corner = [](const Vec2& foot, double z) {
    return Corner{Vec3(foot.x(), foot.y(), z), Vec2::Zero()};
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2& a = feet[i];
    const Vec2& b = feet[(i + 1) % 4];
    object.triangles.push_back({{corner(a, 0), corner(b, 0), corner(b, 1)}});
    object.triangles.push_back({{corner(a, 0), corner(b, 1), corner(a, 1)}});
  }
  object.triangles.push_back({{corner(feet[0], 1), corner(feet[1], 1), corner(feet[2], 1)}});
  object.triangles.push_back({{corner(feet[0], 1), corner(feet[2], 1), corner(feet[3], 1)}});
  return object;
}

World walker(Person person) {
  World world;
  Object figure;
  figure.name = "walker";
  figure.kind = Object::Kind::kPerson;
  world.objects = {figure};
  person.object = 0;
  world.people = {person};
  return world;
}

DynamicObjects dynamic_objects_of(const World& world) {
  return DynamicObjects(world, kFloorLayerTop_m, 0.8);
}

void step(DynamicObjects& dynamic_objects, double seconds, std::int64_t& steps,
          const Disc& robot = kFarAway) {
  const std::int64_t end =
      steps + std::llround(seconds * static_cast<double>(DriveWorld::kStepsPerSecond));
  for (; steps < end; ++steps) {
    dynamic_objects.step(time_of_step(steps), time_of_step(steps + 1), robot);
  }
}

void run(DriveWorld& world, double seconds) {
  const std::int64_t end =
      world.steps() + std::llround(seconds * static_cast<double>(DriveWorld::kStepsPerSecond));
  while (world.steps() < end) {
    world.step();
  }
}

TEST(DynamicObjects, PeopleWalkTheirWayAndBackAgain) {
  Person person;
  person.path_scene = {{0, 0}, {2, 0}, {2, 1}};
  person.speed_mps = 0.5;
  person.start = time_at(1);
  DynamicObjects dynamic_objects = dynamic_objects_of(walker(person));
  std::int64_t steps = 0;
  const auto expect_at = [&](double x, double y, double theta) {
    EXPECT_NEAR(dynamic_objects.places()[0].x_m, x, kRoundoff);
    EXPECT_NEAR(dynamic_objects.places()[0].y_m, y, kRoundoff);
    EXPECT_NEAR(wrap_angle(dynamic_objects.places()[0].theta_rad - theta), 0, kRoundoff);
  };
  step(dynamic_objects, 1, steps);
  expect_at(0, 0, 0);
  step(dynamic_objects, 2, steps);
  expect_at(1, 0, 0);
  step(dynamic_objects, 3, steps);
  expect_at(2, 0.5, std::numbers::pi / 2);
  step(dynamic_objects, 2, steps);
  expect_at(2, 0.5, -std::numbers::pi / 2);  // on the way back
  step(dynamic_objects, 2, steps);
  expect_at(1.5, 0, std::numbers::pi);
  step(dynamic_objects, 4, steps);
  expect_at(0.5, 0, 0);  // and again
}

TEST(DynamicObjects, PeopleWhoDoNotReturnStandAtTheEnd) {
  Person person;
  person.path_scene = {{0, 0}, {0, 1}};
  person.returns = false;
  DynamicObjects dynamic_objects = dynamic_objects_of(walker(person));
  std::int64_t steps = 0;
  step(dynamic_objects, 5, steps);
  EXPECT_NEAR(dynamic_objects.places()[0].y_m, 1, kRoundoff);
  EXPECT_NEAR(dynamic_objects.places()[0].theta_rad, std::numbers::pi / 2, kRoundoff);
}

TEST(DynamicObjects, PeopleWaitForTheRobotInTheirWayAndGoPastOneBesideIt) {
  Person person;
  person.path_scene = {{0, 0}, {4, 0}};
  DynamicObjects waiting = dynamic_objects_of(walker(person));
  std::int64_t steps = 0;
  step(waiting, 4, steps, {{3, 0.2}, 0.25});
  const double gap_m = (waiting.places()[0].position() - Vec2(3, 0.2)).norm() - 0.25 - 0.25;
  EXPECT_LE(gap_m, person.waits_m);
  EXPECT_GE(gap_m, person.waits_m - 1.0 / DriveWorld::kStepsPerSecond);
  EXPECT_FALSE(waiting.stands_against_robot(0));
  step(waiting, 1, steps, {{3, 2}, 0.25});
  EXPECT_GT(waiting.places()[0].x_m, 2.5) << "the way is free again";

  DynamicObjects passing = dynamic_objects_of(walker(person));
  steps = 0;
  step(passing, 3.5, steps, {{2, 0.51}, 0.25});
  EXPECT_NEAR(passing.places()[0].x_m, 3.5, kRoundoff);
}

TEST(DynamicObjects, WhoHasWaitedLongEnoughGoesBackTheWayHeCame) {
  Person person;
  person.path_scene = {{0, 0}, {4, 0}};
  person.turns_back_s = 5;
  DynamicObjects dynamic_objects = dynamic_objects_of(walker(person));
  std::int64_t steps = 0;
  const Disc robot{{3, 0.2}, 0.25};
  step(dynamic_objects, 6, steps, robot);  // for two of them he walked
  const double x_m = dynamic_objects.places()[0].x_m;
  EXPECT_GT(x_m, 1.9);
  step(dynamic_objects, 2, steps, robot);
  EXPECT_NEAR(std::abs(dynamic_objects.places()[0].theta_rad), std::numbers::pi, kRoundoff);
  EXPECT_NEAR(dynamic_objects.places()[0].x_m, x_m - 1, 0.2);
  step(dynamic_objects, 4, steps, robot);
  EXPECT_LT(std::abs(dynamic_objects.places()[0].theta_rad), kRoundoff) << "and comes again";

  person.returns = false;
  DynamicObjects staying = dynamic_objects_of(walker(person));
  steps = 0;
  step(staying, 20, steps, robot);
  EXPECT_NEAR(staying.places()[0].x_m, x_m, kRoundoff);
}

TEST(DynamicObjects, EventsMoveThingsEvenlyAndTurnThemTheShortWay) {
  World world;
  world.objects = {block("chair", {1, 1, 3}, 0.4, 0.4), block("door", {0, 0, 0}, 1, 0.04)};
  world.move_events = {{time_at(1), from_seconds(2), 0, {3, 1, -3}},
                       {time_at(1.5), from_seconds(1), 1, {0, 0, deg_to_rad(90)}},
                       {time_at(2), from_seconds(1), 1, {0, 0, 0}},  // before it is open
                       {time_at(6), Duration(0), 0, {1, 1, 3}}};
  DynamicObjects dynamic_objects = dynamic_objects_of(world);
  std::int64_t steps = 0;
  step(dynamic_objects, 1, steps);
  EXPECT_THAT(dynamic_objects.scene_state(time_at(1), dynamic_objects.places()).T_scene_object,
              IsEmpty());
  step(dynamic_objects, 1, steps);
  EXPECT_NEAR(dynamic_objects.places()[0].x_m, 2, kRoundoff);
  EXPECT_NEAR(wrap_angle(dynamic_objects.places()[0].theta_rad - std::numbers::pi), 0, kRoundoff);
  EXPECT_NEAR(dynamic_objects.places()[1].theta_rad, deg_to_rad(45), kRoundoff);
  step(dynamic_objects, 0.5, steps);
  EXPECT_NEAR(dynamic_objects.places()[1].theta_rad, deg_to_rad(22.5), kRoundoff);
  step(dynamic_objects, 1, steps);
  EXPECT_TRUE((dynamic_objects.places()[0] == Pose2{3, 1, -3}));
  EXPECT_TRUE((dynamic_objects.places()[1] == Pose2{0, 0, 0}));
  EXPECT_THAT(dynamic_objects.scene_state(time_at(3.5), dynamic_objects.places()).T_scene_object,
              SizeIs(1));
  step(dynamic_objects, 3, steps);
  EXPECT_THAT(dynamic_objects.scene_state(time_at(6.5), dynamic_objects.places()).T_scene_object,
              IsEmpty());
}

TEST(DynamicObjects, KeepTheirHeight) {
  World world;
  world.objects = {block("lamp", {1, 1, 0}, 0.4, 0.4)};
  world.objects[0].T_scene_object.translation.z() = 0.7;
  world.move_events = {{time_at(0), from_seconds(1), 0, {2, 1, 0.5}}};
  DynamicObjects dynamic_objects = dynamic_objects_of(world);
  std::int64_t steps = 0;
  step(dynamic_objects, 2, steps);
  const SceneState scene_state = dynamic_objects.scene_state(time_at(2), dynamic_objects.places());
  const Vec3 at = scene_state.T_scene_object.at(0) * Vec3(0, 0, 0);
  EXPECT_NEAR((at - Vec3(2, 1, 0.7)).norm(), 0, kRoundoff);
}

TEST(DynamicObjects, LightsGoEvenlyToTheirPowerAndStay) {
  World world;
  world.light_events = {{time_at(1), from_seconds(2), "lamps", 0},
                        {time_at(2), from_seconds(1), "lamps", 1},  // before it is dark
                        {time_at(3), Duration(0), "sun", 0.2}};
  const DynamicObjects dynamic_objects = dynamic_objects_of(world);
  const auto power = [&](double t_s, const char* group) {
    const SceneState scene_state = dynamic_objects.scene_state(time_at(t_s), {});
    const auto found = scene_state.power.find(group);
    return found == scene_state.power.end() ? 1.0 : found->second;
  };
  EXPECT_EQ(power(0.5, "lamps"), 1);
  EXPECT_NEAR(power(1.5, "lamps"), 0.75, kRoundoff);
  EXPECT_NEAR(power(2, "lamps"), 0.5, kRoundoff);
  EXPECT_NEAR(power(2.5, "lamps"), 0.75, kRoundoff);
  EXPECT_NEAR(power(9, "lamps"), 1, kRoundoff);
  EXPECT_EQ(power(2.9, "sun"), 1);
  EXPECT_EQ(power(3, "sun"), 0.2);
}

TEST(DriveWorld, IsStoppedByAThingWhereItStandsNow) {
  World world;
  world.objects = {block("chair", {2, 2.5, 0}, 0.4, 0.4)};
  world.move_events = {{time_at(1), from_seconds(1), 0, {3, 2, 0}}};
  const Obstacles obstacles(walls(4));
  DriveWorld drive(Body{}, obstacles, {1, 2, 0}, dynamic_objects_of(world));
  EXPECT_NEAR(drive.clearance_m(), std::hypot(0.8, 0.3) - 0.25, kRoundoff);
  run(drive, 3);
  EXPECT_NEAR(drive.clearance_m(), 0.75, kRoundoff) << "the west wall";
  drive.drive({0.5, 0}, kForever);
  run(drive, 6);
  EXPECT_NEAR(drive.T_scene_body().x_m, 3 - 0.2 - 0.25, kSlop_m);
  EXPECT_TRUE(drive.touching());
  EXPECT_LE(drive.clearance_m(), kSlop_m);
  ASSERT_THAT(drive.contacts(), SizeIs(1));
  EXPECT_EQ(drive.contacts()[0].object, "chair");
  EXPECT_TRUE(drive.contacts()[0].while_moving);
  EXPECT_NEAR(drive.contacts()[0].p_scene.x(), 2.8, kSlop_m);
}

TEST(DriveWorld, SomebodyWhoWalksIntoTheStandingRobotDoesNotPushIt) {
  Person person;
  person.path_scene = {{0.5, 2}, {3.5, 2}};
  person.waits_m = 0;
  const Obstacles obstacles(walls(4));
  const Pose2 stands{2, 2.1, 1};
  DriveWorld drive(Body{}, obstacles, stands, dynamic_objects_of(walker(person)));
  run(drive, 5);
  EXPECT_TRUE(drive.T_scene_body() == stands);
  EXPECT_TRUE(drive.touching());
  EXPECT_NEAR(drive.clearance_m(), 0, 1e-6);
  ASSERT_THAT(drive.contacts(), SizeIs(1));
  EXPECT_EQ(drive.contacts()[0].object, "walker");
  EXPECT_FALSE(drive.contacts()[0].while_moving);
  EXPECT_NEAR((drive.contacts()[0].p_scene - stands.position()).norm(), 0.25, 1e-6);
  // It drives off, and the walk goes on.
  drive.drive({0.5, 0}, kForever);
  run(drive, 4);
  EXPECT_FALSE(drive.touching());
  EXPECT_THAT(drive.contacts(), SizeIs(1));
}

TEST(DriveWorld, ADoorStopsAtTheRobotAndGoesOnWhenItHasLeft) {
  World world;
  Object door = block("door", {2, 2, 0}, 1, 0.04);
  for (Triangle& triangle : door.triangles) {
    for (Corner& corner : triangle.corners) {
      corner.p_object.x() += 0.5;  // hinged at its end
    }
  }
  world.objects = {door};
  world.move_events = {{time_at(1), from_seconds(1), 0, {2, 2, deg_to_rad(90)}}};
  const Obstacles obstacles(walls(6));
  const Pose2 behind{2.6, 2.6, deg_to_rad(90)};
  DriveWorld drive(Body{}, obstacles, behind, dynamic_objects_of(world));
  run(drive, 5);
  EXPECT_TRUE(drive.T_scene_body() == behind);
  EXPECT_NEAR(drive.clearance_m(), 0, 1e-6);
  EXPECT_GT(drive.dynamic_objects().places()[0].theta_rad, 0.3);
  EXPECT_LT(drive.dynamic_objects().places()[0].theta_rad, 0.6);
  drive.drive({0.5, 0}, kForever);
  run(drive, 5);
  EXPECT_NEAR(drive.dynamic_objects().places()[0].theta_rad, deg_to_rad(90), kRoundoff);
  ASSERT_THAT(drive.contacts(), SizeIs(1));
  EXPECT_FALSE(drive.contacts()[0].while_moving);
}

TEST(DriveWorld, NeverEntersThingsHoweverBothMove) {
  World world;
  Rng rng(4);
  for (int i = 0; i < 3; ++i) {
    world.objects.push_back(block("crate", {rng.uniform(1, 3), rng.uniform(1, 3), 0}, 0.5, 0.3));
  }
  for (int k = 1; k < 90; ++k) {
    world.move_events.push_back(
        {time_at(k),
         from_seconds(rng.uniform(0, 1)),
         static_cast<std::size_t>(rng.index(3)),
         {rng.uniform(0.5, 3.5), rng.uniform(0.5, 3.5), rng.uniform(-3, 3)}});
  }
  for (int i = 0; i < 2; ++i) {
    Object figure;
    figure.name = "walker";
    figure.kind = Object::Kind::kPerson;
    Person person;
    person.object = world.objects.size();
    person.path_scene = {{0.3, 1.0 + i}, {3.7, 2.0 - i}};
    person.waits_m = i == 0 ? 0 : 0.1;
    world.objects.push_back(figure);
    world.people.push_back(person);
  }
  const auto run_it = [&] {
    const Obstacles obstacles(walls(4));
    DriveWorld drive(Body{}, obstacles, {0.4, 3.5, 0}, dynamic_objects_of(world));
    Rng commands(11);
    double nearest_m = 1;
    for (int i = 0; i < 90 * 120; ++i) {
      if (i % 60 == 0) {
        drive.drive({commands.uniform(-0.3, 0.6), commands.uniform(-1.5, 1.5)}, kForever);
      }
      drive.step();
      const Vec2 at = drive.T_scene_body().position();
      nearest_m = std::min(nearest_m, obstacles.nearest(at)->distance_m);
      for (std::size_t k = 0; k < drive.dynamic_objects().count(); ++k) {
        nearest_m = std::min(nearest_m, drive.dynamic_objects()
                                            .nearest_on(k, drive.dynamic_objects().places()[k], at)
                                            .distance_m);
      }
    }
    EXPECT_GE(nearest_m, 0.25 - 2 * kSlop_m);  // between two it may rest on both
    EXPECT_GT(drive.contacts().size(), 10U);
    return std::pair(drive.T_scene_body(), drive.contacts().size());
  };
  const auto first = run_it();
  const auto again = run_it();
  EXPECT_TRUE(first.first == again.first);
  EXPECT_EQ(first.second, again.second);
}

TEST(DriveWorld, ThingsThatStayAwayChangeNothing) {
  World world;
  Person person;
  person.path_scene = {{0.3, 0.3}, {0.3, 1}};
  world = walker(person);
  const Obstacles obstacles(walls(6));
  const auto drive = [&](DynamicObjects dynamic_objects) {
    DriveWorld drive_world(Body{}, obstacles, {3, 3, 0}, std::move(dynamic_objects));
    for (int i = 0; i < 40; ++i) {
      drive_world.drive({0.5, i % 4 == 0 ? 1.0 : 0.0}, kForever);
      run(drive_world, 0.2);
    }
    return drive_world.T_scene_body();
  };
  EXPECT_TRUE(drive({}) == drive(dynamic_objects_of(world)));
}

}  // namespace
}  // namespace panoptes::sim

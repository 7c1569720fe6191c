// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/mapper.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/camera/mounting.h"
#include "core/geometry/pose3.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kCell_m = 0.01;
const Body kBody;                        // a disc of 0.25 m
constexpr double kInside = 0.9;          // of a radius: clear of the cells that its edge cuts
constexpr double kStart_m = 0.25 + 0.2;  // the floor is mapped from 0.2 m before the body

FloorScene carpet() {
  FloorScene scene;
  scene.carpet = {Vec3(120, 110, 90), 0.08, 1};
  for (const double x : {8.0, -8.2}) {  // far walls, ahead and behind
    scene.boxes.push_back({{x, -30}, {x + 0.2, 30}, 2.5, {Vec3(180, 190, 200), 0.5, 2}});
  }
  return scene;
}

// A red box whose face towards the robot is x = 1.2.
FloorScene carpet_with_a_box() {
  FloorScene scene = carpet();
  scene.boxes.push_back({{1.2, 0.2}, {1.8, 1.4}, 0.7, {Vec3(30, 40, 200), 0.4, 6}});
  return scene;
}

Rig one_floor_camera() {
  Rig rig;
  rig.cameras["floor"] = office_floor_camera();
  return rig;
}

RigCamera turned(RigCamera camera, double yaw_rad) {
  camera.T_body_camera = on_floor({0, 0, yaw_rad}) * camera.T_body_camera;
  return camera;
}

std::vector<Pose2> moved(const std::vector<Pose2>& poses, const Pose2& T_new_old) {
  std::vector<Pose2> out;
  for (const Pose2& T : poses) {
    out.push_back(T_new_old * T);
  }
  return out;
}

bool same(const OccupancyMap& a, const OccupancyMap& b) {
  return a.cell_m == b.cell_m && a.origin == b.origin && a.columns == b.columns &&
         a.rows == b.rows && a.cells == b.cells;
}

int count(const OccupancyMap& map, Cell cell) {
  return static_cast<int>(std::count(map.cells.begin(), map.cells.end(), cell));
}

/// A mapper told by hand where its robot is and where keyframes are made.
class Ride {
 public:
  explicit Ride(const MapperOptions& options = {}, const Rig& rig = one_floor_camera(),
                const FloorScene& scene = carpet())
      : mapper(options, kBody, rig), rig_(rig), scene_(scene) {}

  /// What it sees from `T_odom_body`, where wheels and odom are one.
  Observation look(const Pose2& T_odom_body) {
    Observation seen = feel(T_odom_body);
    for (const auto& [name, camera] : rig_.cameras) {
      seen.pictures[name] = {seen.stamp, draw(scene_, camera, T_odom_body, rng_)};
    }
    return seen;
  }
  /// The same with its eyes shut.
  Observation feel(const Pose2& T_odom_body) const {
    Observation seen;
    seen.stamp = now;
    seen.odometry.T_odom_body = T_odom_body;
    return seen;
  }

  Mapped keyframe(const Observation& seen) {
    const Pose2& T_odom_body = seen.odometry.T_odom_body;
    keyframes.push_back({seen.stamp, T_odom_body, T_odom_body});
    T_map_keyframes.push_back(T_odom_body);
    return step(seen, static_cast<int>(keyframes.size()) - 1);
  }
  Mapped step(const Observation& seen, std::optional<int> made = std::nullopt,
              bool relaxed = false) {
    Located located;
    located.T_odom_body = seen.odometry.T_odom_body;
    located.T_last_body = keyframes.back().T_odom_body.inverse() * seen.odometry.T_odom_body;
    located.T_map_body = T_map_keyframes.back() * located.T_last_body;
    located.keyframe = static_cast<int>(keyframes.size()) - 1;
    located.keyframe_made = made;
    located.relaxed = relaxed;
    now += kFrame;
    return mapper.step(seen, located, keyframes, T_map_keyframes);
  }

  void put(const SceneBox& box) { scene_.boxes.push_back(box); }

  void knock(const std::string& name, const MountingOffset& by) {
    RigCamera& camera = rig_.cameras.at(name);
    camera.T_body_camera = displaced(camera.T_body_camera, by);
  }

  OccupancyMap finished() const { return mapper.finished_map(kCell_m, T_map_keyframes); }

  static constexpr Duration kFrame = std::chrono::milliseconds(50);
  Mapper mapper;
  Time now;
  std::vector<Keyframe> keyframes;
  std::vector<Pose2> T_map_keyframes;

 private:
  Rig rig_;
  FloorScene scene_;
  Rng rng_{5};
};

// Of points `radius_m` about a place, how many the map calls so.
int around(const OccupancyMap& map, const Vec2& middle, double radius_m, Cell cell) {
  int all = 0;
  for (int i = 0; i < 16; ++i) {
    const double angle = i * std::numbers::pi / 8;
    all += map.at(middle + radius_m * Vec2(std::cos(angle), std::sin(angle))) == cell ? 1 : 0;
  }
  return all;
}

TEST(FloorCameras, ComeStraightestAheadFirst) {
  Rig rig;
  rig.cameras["a"] = turned(office_floor_camera(), std::numbers::pi);
  rig.cameras["b"] = turned(office_floor_camera(), 0.5);
  rig.cameras["c"] = turned(office_floor_camera(), -0.2);
  rig.cameras["d"] = office_floor_camera();
  rig.cameras["e"] = turned(office_floor_camera(), -0.5);
  rig.cameras["f"] = office_floor_camera();
  rig.cameras["f"].roles = {"loop_front"};
  EXPECT_THAT(floor_cameras(rig), ElementsAre("d", "c", "b", "e", "a"));
}

TEST(FloorCameras, NoneIsRefused) {
  Rig rig = one_floor_camera();
  rig.cameras["floor"].roles = {"loop_front", "loop_back"};
  try {
    const Mapper mapper({}, kBody, rig);
    ADD_FAILURE() << "it maps with no camera";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "rig: no camera has the role floor; free space is mapped with one");
  }
}

TEST(Mapper, AnObservationBeforeAnyKeyframeYieldsNothing) {
  Ride ride;
  Ride without;
  const Observation seen = ride.look({});
  const Mapped mapped = ride.mapper.step(seen, {}, {}, {});
  EXPECT_EQ(mapped.reading.projection, nullptr);
  EXPECT_THAT(mapped.reading.evidence, IsEmpty());
  EXPECT_EQ(mapped.local_odom.columns, 0);
  EXPECT_EQ(ride.mapper.map({}).columns, 0);
  EXPECT_EQ(ride.mapper.finished_map(kCell_m, {}).columns, 0);
  EXPECT_THAT(ride.mapper.placed({}), IsEmpty());
  // and leaves no trace in what comes after
  ride.keyframe(seen);
  without.keyframe(seen);
  EXPECT_TRUE(same(ride.finished(), without.finished()));
}

TEST(Mapper, AssumesTheBlindRingFreeAtTheStartAndNowhereElse) {
  const Pose2 start{0.3, -0.2, 0.7};
  const Pose2 later{3.3, -0.2, 0};
  for (const double margin_m : {0.1, 0.3}) {
    MapperOptions options;
    options.start_margin_m = margin_m;
    Ride ride(options);
    const double radius_m = kStart_m + margin_m;
    EXPECT_NEAR(ride.mapper.start_radius_m(), radius_m, kCell_m);
    const OccupancyMap local_odom = ride.keyframe(ride.feel(start)).local_odom;
    const OccupancyMap driving = ride.mapper.map(ride.T_map_keyframes);
    for (const OccupancyMap& map : {ride.finished(), local_odom, driving}) {
      EXPECT_EQ(map.at(start.position()), Cell::kFree);
      EXPECT_EQ(around(map, start.position(), radius_m - 2 * map.cell_m, Cell::kFree), 16);
      EXPECT_EQ(around(map, start.position(), radius_m + 2 * map.cell_m, Cell::kUnknown), 16);
    }
    ride.keyframe(ride.feel(later));
    const OccupancyMap map = ride.finished();
    EXPECT_EQ(around(map, start.position(), radius_m - 2 * kCell_m, Cell::kFree), 16);
    EXPECT_EQ(around(map, later.position(), kInside * kBody.radius_m, Cell::kFree), 16);
    EXPECT_EQ(around(map, later.position(), kBody.radius_m + 2 * kCell_m, Cell::kUnknown), 16);
  }
}

// Along the x axis from 3 m on, away from what is assumed at the start; steps so long that the
// discs alone would leave the edges of the way open.
constexpr double kFrom_m = 3;
constexpr double kStep_m = 0.24;
Ride driven(int steps, double step_m, bool touching, bool keyframes) {
  Ride ride;
  ride.keyframe(ride.feel({0, 0, 0}));
  for (int i = 0; i <= steps; ++i) {
    Observation seen = ride.feel({kFrom_m + i * step_m, 0, 0.5});
    seen.health.bumper_pressed = touching && i > 0;  // it has driven up to there
    keyframes ? ride.keyframe(seen) : ride.step(seen);
  }
  return ride;
}

TEST(Mapper, TheSweepOfTheBodyIsFree) {
  constexpr int kSteps = 8;
  for (const bool keyframes : {false, true}) {  // across their borders too
    const OccupancyMap map = driven(kSteps, kStep_m, false, keyframes).finished();
    for (double x = kFrom_m; x <= kFrom_m + kSteps * kStep_m; x += kCell_m) {
      for (const double y : {-kInside, 0.0, kInside}) {
        ASSERT_EQ(map.at(Vec2(x, y * kBody.radius_m)), Cell::kFree) << x << " " << y;
      }
      for (const double side : {-1, 1}) {
        ASSERT_EQ(map.at(Vec2(x, side * (kBody.radius_m + 2 * kCell_m))), Cell::kUnknown) << x;
      }
    }
  }
}

TEST(Mapper, NobodyKnowsWhatLiesBetweenPlacesFartherApartThanTheBody) {
  const OccupancyMap map = driven(1, 1, false, false).finished();
  EXPECT_EQ(map.at(Vec2(kFrom_m, 0)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(kFrom_m + 0.5, 0)), Cell::kUnknown);
  EXPECT_EQ(map.at(Vec2(kFrom_m + 1, 0)), Cell::kFree);
}

TEST(Mapper, WheelsThatTurnAgainstAThingSweepNothing) {
  const OccupancyMap map = driven(4, kStep_m, true, false).finished();
  const double between_m = kFrom_m + 2.5 * kStep_m;
  EXPECT_EQ(map.at(Vec2(between_m, 0)), Cell::kFree);  // under the discs at either end
  EXPECT_EQ(map.at(Vec2(between_m, 0.95 * kBody.radius_m)), Cell::kUnknown);
}

// A mapper's readings are those of a camera that may not learn from the contact until 3 s after its
// end.
TEST(Mapper, ABumpersContactStopsLearningTheFloorForThreeSeconds) {
  Ride ride;
  const RigCamera camera = office_floor_camera();
  FloorMapper expected({}, camera, kBody);
  FloorMapper always({}, camera, kBody);
  Rng rng(3);
  const cv::Mat bgr = draw(carpet(), camera, {}, rng);
  constexpr int kFrames = 60;
  constexpr double kPeriod_s = 0.125;
  int unlike_always = 0;
  for (int i = 0; i < kFrames; ++i) {
    const double at_s = i * kPeriod_s;
    ride.now = time_at(at_s);
    Observation seen = ride.feel({});
    cv::Mat dimmer;  // what is not learned shows as the light fades
    bgr.convertTo(dimmer, -1, 1 - 0.01 * i);
    seen.pictures["floor"] = {seen.stamp, dimmer};
    seen.health.bumper_pressed = (at_s >= 1 && at_s <= 1.5) || at_s == 2.25;
    // 2.25 + 3 s is a frame to learn in: each third is
    const bool may_learn = at_s < 1 || at_s > 2.25 + 3;
    const Mapped mapped = i == 0 ? ride.keyframe(seen) : ride.step(seen);
    ASSERT_EQ(mapped.reading.evidence, expected.read(dimmer, {}, may_learn).evidence) << at_s;
    unlike_always += mapped.reading.evidence != always.read(dimmer, {}, true).evidence ? 1 : 0;
  }
  EXPECT_GT(unlike_always, 0);  // else the light says nothing of learning
}

TEST(Mapper, FindsABoxWhereItIsFromEveryKeyframe) {
  Ride ride({}, one_floor_camera(), carpet_with_a_box());
  for (const Pose2& T : {Pose2{0, 0.5, 0.1}, Pose2{0.2, 0.6, 0}, Pose2{0.4, 0.7, -0.1}}) {
    ride.keyframe(ride.look(T));
  }
  const OccupancyMap map = ride.finished();
  for (double y = 0.35; y < 1; y += 0.05) {
    EXPECT_EQ(map.at(Vec2(1.2 - 0.04, y)), Cell::kFree) << y;
    EXPECT_EQ(map.at(Vec2(1.2 + 0.015, y)), Cell::kOccupied) << y;
    EXPECT_EQ(map.at(Vec2(1.5, y)), Cell::kUnknown) << y;
  }
}

// The free floor that is mapped in and behind a box of the carpet's own colour.
double leaked_m2(bool upright) {
  FloorScene scene = carpet();
  scene.carpet.contrast = 0.25;
  const SceneBox box{{1.6, -0.4}, {2.2, 0.4}, 0.5, scene.carpet};
  scene.boxes.push_back(box);
  MapperOptions options;
  options.floor.upright = upright;
  Ride ride(options, one_floor_camera(), scene);
  for (int i = 0; i < 25; ++i) {
    const Observation seen = ride.look({0.04 * i, 0, 0});
    if (i % 5 == 0) {
      ride.keyframe(seen);
    } else {
      ride.step(seen);
    }
  }
  ride.keyframe(ride.look({1.0, 0, 0}));  // closes the one before
  const OccupancyMap map = ride.finished();
  int free = 0;
  for (double x = box.low.x() + 0.03; x < 3.5; x += kCell_m) {
    for (double y = -0.35; y < 0.35; y += kCell_m) {
      free += map.at(Vec2(x, y)) == Cell::kFree ? 1 : 0;
    }
  }
  return free * kCell_m * kCell_m;
}

TEST(Mapper, WhoComesToStandOnKnownFloorIsInTheLocalMapInThreePictures) {
  Ride ride;
  ride.keyframe(ride.look({}));
  double x = 0;
  Mapped mapped;
  for (; x < 0.6; x += 0.015) {  // two seconds
    mapped = ride.step(ride.look({x, 0, 0}));
  }
  const SceneBox feet{{x + 1, -0.1}, {x + 1.1, 0.1}, 1.7, {Vec3(40, 40, 60), 0.3, 8}};
  ASSERT_EQ(mapped.local_odom.at(Vec2(feet.low.x(), 0)), Cell::kFree);
  ride.put(feet);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(mapped.local_odom.at(Vec2(feet.low.x(), 0)), Cell::kFree);
    mapped = ride.step(ride.look({x, 0, 0}));
  }
  EXPECT_EQ(mapped.local_odom.at(Vec2(feet.low.x(), 0)), Cell::kOccupied);
  EXPECT_EQ(mapped.local_odom.at(Vec2(feet.low.x() - 0.1, 0)), Cell::kOccupied) << "he is wider";
  EXPECT_EQ(mapped.local_odom.at(Vec2(feet.low.x() - 0.3, 0)), Cell::kFree);
}

// The floor behind the start is of another colour, and is not known for floor at first.
TEST(Mapper, AnotherFloorThatBeginsAtTheStartIsNobodyWhoCame) {
  FloorScene scene = carpet();
  scene.seam_x_m = -0.4;
  scene.second_carpet = scene.carpet;
  scene.carpet = {Vec3(60, 40, 150), 0.08, 4};  // behind the seam
  Ride ride({}, one_floor_camera(), scene);
  Mapped mapped = ride.keyframe(ride.look({}));
  for (double heading_rad = 0; heading_rad < std::numbers::pi; heading_rad += 0.067) {
    mapped = ride.step(ride.look({0, 0, heading_rad}));
  }
  EXPECT_EQ(mapped.local_odom.at(Vec2(-kStart_m - 0.05, 0)), Cell::kOccupied);
  EXPECT_EQ(mapped.local_odom.at(Vec2(-0.36, 0)), Cell::kFree);
  EXPECT_FALSE(ride.mapper.something_came());
}

TEST(Mapper, AThingOfTheFloorsColourIsNoFloorOnceTheRobotHasComeNear) {
  const double by_colour_m2 = leaked_m2(false);
  EXPECT_GT(by_colour_m2, 0.3);
  EXPECT_LT(leaked_m2(true), 0.4 * by_colour_m2);
}

TEST(Mapper, APictureLiesWhereTheBodyWasWhenItWasTaken) {
  Ride ride({}, one_floor_camera(), carpet_with_a_box());
  const Pose2 T_then{0.2, 0.6, 0};
  constexpr double kSpeed_mps = 0.5;
  constexpr double kAgo_s = 0.2;
  Observation seen = ride.look(T_then);
  seen.odometry.T_odom_body = T_then * Pose2{kSpeed_mps * kAgo_s, 0, 0};
  seen.odometry.twist_body = {kSpeed_mps, 0};
  seen.stamp += from_seconds(kAgo_s);
  ride.keyframe(seen);
  const OccupancyMap map = ride.finished();
  EXPECT_EQ(map.at(Vec2(1.2 - 0.04, 0.6)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(1.2 + 0.015, 0.6)), Cell::kOccupied);
}

TEST(Mapper, EverySecondFloorCameraMapsButTheForemostIsRead) {
  Rig rig = one_floor_camera();
  rig.cameras["a-behind"] = turned(office_floor_camera(), std::numbers::pi);
  Ride ride({}, rig);
  Observation seen = ride.look({});
  const Mapped both = ride.keyframe(seen);
  ASSERT_NE(both.reading.projection, nullptr);
  EXPECT_NEAR(both.reading.projection->T_body_view.theta_rad, 0, 1e-12);
  EXPECT_EQ(ride.finished().at(Vec2(-1, 0)), Cell::kFree);
  EXPECT_EQ(ride.finished().at(Vec2(1, 0)), Cell::kFree);

  Ride behind({}, rig);
  seen.pictures.erase("floor");
  EXPECT_EQ(behind.keyframe(seen).reading.projection, nullptr);
  EXPECT_EQ(behind.finished().at(Vec2(-1, 0)), Cell::kFree);
  EXPECT_EQ(behind.finished().at(Vec2(1, 0)), Cell::kUnknown);
}

TEST(Mapper, ASecondCameraThatHasSeenNoFloorSaysNothing) {
  Rig rig = one_floor_camera();
  rig.cameras["behind"] = turned(office_floor_camera(), std::numbers::pi);
  Ride ride({}, rig);
  Ride alone({}, rig);
  Observation seen = ride.look({});
  cv::Mat& bgr = seen.pictures.at("behind").bgr;
  bgr = cv::Mat::zeros(bgr.size(), bgr.type());
  ride.keyframe(seen);
  seen.pictures.erase("behind");
  alone.keyframe(seen);
  EXPECT_TRUE(same(ride.finished(), alone.finished()));
}

TEST(Mapper, WhatEachCameraSeesFromAPlaceIsNewEvidence) {
  const auto seen_by = [](const std::vector<std::string>& names) {
    Rig rig;
    for (const std::string& name : names) {
      rig.cameras[name] = office_floor_camera();
    }
    Rng rng(9);
    const cv::Mat bgr = draw(carpet_with_a_box(), office_floor_camera(), {0, 0.5, 0}, rng);
    Ride ride({}, rig);
    Observation seen = ride.feel({});
    for (const std::string& name : names) {
      seen.pictures[name] = {seen.stamp, bgr};
    }
    ride.keyframe(seen);
    return ride.mapper.placed(ride.T_map_keyframes).front().grid;
  };
  const auto one = seen_by({"a"});
  const auto three = seen_by({"a", "b", "c"});
  int cells = 0;
  for (int row = -50; row < 50; ++row) {
    for (int column = 60; column < 120; ++column) {  // beyond what is assumed at the start
      ASSERT_EQ(three->at(column, row), 3 * one->at(column, row)) << column << " " << row;
      cells += one->at(column, row) != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(cells, 1000);
}

// Three keyframes before a box, the wheels off by 0.3 m at the second.
struct Drifted {
  Ride ride;
  std::vector<Pose2> T_true;

  Drifted() : ride({}, one_floor_camera(), carpet_with_a_box()) {
    T_true = {{0, 0.6, 0}, {0.1, 0.6, 0}, {0.2, 0.6, 0}};
    const Pose2 slip{-0.3, 0, 0};
    for (std::size_t i = 0; i < T_true.size(); ++i) {
      Observation seen = ride.look(T_true[i]);
      seen.odometry.T_odom_body = i == 0 ? T_true[i] : slip * T_true[i];
      ride.keyframe(seen);
    }
  }
};

TEST(Mapper, RelaxationMovesGridsToWhereTheyBelong) {
  Drifted drifted;
  const auto faces = [](const OccupancyMap& map) {  // occupied along the way ahead
    std::vector<double> at;
    for (double x = 0.5; x < 1.5; x += kCell_m) {
      if (map.at(Vec2(x, 0.6)) == Cell::kOccupied) {
        at.push_back(x);
      }
    }
    return at;
  };
  const std::vector<double> doubled = faces(drifted.ride.finished());
  ASSERT_FALSE(doubled.empty());
  EXPECT_LT(doubled.front(), 1.0);  // two keyframes see it 0.3 m too near
  constexpr double kFoot_m = 0.06;  // how far behind its face a thing is taken to reach, and a cell
  const std::vector<double> healed =
      faces(drifted.ride.mapper.finished_map(kCell_m, drifted.T_true));
  ASSERT_FALSE(healed.empty());
  EXPECT_NEAR(healed.front(), 1.2, 2 * kCell_m);
  EXPECT_LT(healed.back(), 1.2 + kFoot_m);
}

TEST(Mapper, RelaxationLeavesTheContentOfGridsAlone) {
  Drifted drifted;
  Ride& ride = drifted.ride;
  const std::vector<PlacedGrid> before = ride.mapper.placed(ride.T_map_keyframes);
  const OccupancyMap was = ride.finished();
  const Vec2 shift(1, -0.5);
  // all moved alike: the same map elsewhere
  const std::vector<Pose2> shifted = moved(ride.T_map_keyframes, {shift.x(), shift.y(), 0});
  const OccupancyMap is = ride.mapper.finished_map(kCell_m, shifted);
  constexpr double kRoundoff_m = 1e-9;
  EXPECT_NEAR((is.origin - was.origin - shift).norm(), 0, kRoundoff_m);
  EXPECT_EQ(is.columns, was.columns);
  EXPECT_EQ(is.cells, was.cells);

  ride.T_map_keyframes = drifted.T_true;
  ride.step(ride.feel(ride.keyframes.back().T_odom_body), std::nullopt, true);
  const std::vector<PlacedGrid> after = ride.mapper.placed(ride.T_map_keyframes);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k + 1 < after.size(); ++k) {
    EXPECT_EQ(after[k].grid, before[k].grid);  // not even copied
    EXPECT_EQ(after[k].T_map_keyframe, drifted.T_true[k]);
  }
  EXPECT_EQ(after.back().grid->cells, before.back().grid->cells);
  EXPECT_EQ(after.back().T_map_keyframe, drifted.T_true.back());
}

TEST(Mapper, TheMapWhileDrivingFollowsARelaxationWithinTheTimeGranted) {
  MapperOptions options;
  options.refuse_s = 4 * to_seconds(Ride::kFrame);
  Ride ride(options);
  constexpr int kKeyframes = 9;  // eight closed
  for (int i = 0; i < kKeyframes; ++i) {
    ride.keyframe(ride.feel({0.5 * i, 0, 0}));
  }
  const auto driving = [&ride] { return ride.mapper.map(ride.T_map_keyframes); };
  const auto afresh = [&ride, &options] {
    return ride.mapper.finished_map(options.plan_cell_m, ride.T_map_keyframes);
  };
  EXPECT_TRUE(same(driving(), afresh()));
  for (Pose2& T : ride.T_map_keyframes) {
    T = Pose2{0, 2, 0.1} * T;
  }
  const Observation here = ride.feel(ride.keyframes.back().T_odom_body);
  for (int i = 0; i < 3; ++i) {
    Observation seen = here;
    seen.stamp = ride.now;
    ride.step(seen, std::nullopt, i == 0);
    EXPECT_FALSE(same(driving(), afresh())) << i;  // a share at a time
  }
  Observation last = here;
  last.stamp = ride.now;
  ride.step(last);
  EXPECT_TRUE(same(driving(), afresh()));
}

TEST(Mapper, TheWindowHoldsTheLastKeyframesWhereOdomHasThemWhateverTheMapSays) {
  MapperOptions options;
  options.local_keyframes = 2;
  options.local_half_width_m = 10;
  Ride ride(options);
  constexpr int kKeyframes = 6;
  Mapped mapped;
  for (int i = 0; i < kKeyframes; ++i) {
    mapped = ride.keyframe(ride.feel({i * 1.0, 0, 0}));
  }
  for (int i = 1; i < kKeyframes; ++i) {
    const bool kept = i >= kKeyframes - 1 - options.local_keyframes;
    EXPECT_EQ(mapped.local_odom.at(Vec2(i, 0)), kept ? Cell::kFree : Cell::kUnknown) << i;
    EXPECT_EQ(ride.finished().at(Vec2(i, 0)), Cell::kFree) << i;
  }
  ride.T_map_keyframes = moved(ride.T_map_keyframes, {3, 4, 1});
  const Observation again = ride.feel(ride.keyframes.back().T_odom_body);
  EXPECT_TRUE(same(ride.step(again, std::nullopt, true).local_odom, mapped.local_odom));
}

// Keyframes half a metre apart along a row of posts, each of which the nearest keyframes see, and
// one more that is open.
constexpr int kPosts = 8;
constexpr double kPost_m = 0.5;
std::vector<Observation> look_along_posts() {
  FloorScene scene = carpet();
  for (int i = 0; i < kPosts; ++i) {
    const double x = i * kPost_m + 1;
    scene.boxes.push_back({{x, 0.35}, {x + 0.15, 0.6}, 0.7, {Vec3(30, 40, 200), 0.4, 6 + i}});
  }
  Ride ride({}, one_floor_camera(), scene);
  std::vector<Observation> seen;
  for (int i = 0; i < kPosts; ++i) {
    seen.push_back(ride.look({i * kPost_m, 0, 0}));
  }
  return seen;
}

Ride along(const std::vector<Observation>& posts, double contour_path_m, int contour_keyframes) {
  MapperOptions options;
  options.contour_path_m = contour_path_m;
  options.contour_keyframes = contour_keyframes;
  Ride ride(options);
  for (const Observation& seen : posts) {
    ride.keyframe(seen);
  }
  return ride;
}

// Which keyframes' grids the contour of one is made of: those that change it where they lie
// elsewhere, a little aside.
std::vector<int> made_of(const Ride& ride, int keyframe) {
  const std::vector<Vec2> contour = ride.mapper.contour(keyframe, ride.T_map_keyframes);
  EXPECT_FALSE(contour.empty());
  std::vector<int> used;
  for (int k = 0; k < static_cast<int>(ride.keyframes.size()); ++k) {
    std::vector<Pose2> T = ride.T_map_keyframes;
    T[static_cast<std::size_t>(k)].y_m += 0.04;
    if (ride.mapper.contour(keyframe, T) != contour) {
      used.push_back(k);
    }
  }
  return used;
}

TEST(Mapper, AContourUsesTheGridsOfTheWayToEitherSideAndNoMore) {
  const std::vector<Observation> seen = look_along_posts();
  constexpr double kTwoSteps_m = 1.1;
  constexpr double kOneStep_m = 0.6;
  constexpr int kMany = 12;
  const Ride two_steps = along(seen, kTwoSteps_m, kMany);
  EXPECT_THAT(made_of(two_steps, 3), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(made_of(two_steps, 1), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(made_of(two_steps, 5), ElementsAre(3, 4, 5, 6));  // 7 is open
  EXPECT_THAT(made_of(along(seen, kOneStep_m, kMany), 3), ElementsAre(2, 3, 4));
  EXPECT_THAT(made_of(along(seen, 5, 1), 3), ElementsAre(2, 3, 4));
}

TEST(Mapper, AContourIsSeenFromItsKeyframeHoweverTheMapLies) {
  Ride ride({}, one_floor_camera(), carpet_with_a_box());
  const Pose2 T_scene_keyframe{0.2, 0.6, 0.3};
  ride.keyframe(ride.look(T_scene_keyframe));
  ride.keyframe(ride.feel({0, 0.6, 0}));
  const std::vector<Vec2> contour = ride.mapper.contour(0, ride.T_map_keyframes);
  ASSERT_GT(contour.size(), 20U);
  constexpr double kCells_m = 0.04;  // two of a contour's
  int on_the_face = 0;
  for (const Vec2& p_keyframe : contour) {
    const Vec2 p = T_scene_keyframe * p_keyframe;
    if (p.x() < 1.5 && p.y() > 0.25 && p.y() < 1.2) {
      EXPECT_NEAR(p.x(), 1.2, kCells_m);
      ++on_the_face;
    }
  }
  EXPECT_GT(on_the_face, 20);
  // a map that lies elsewhere by whole cells and no turn is the same from the keyframe
  EXPECT_EQ(ride.mapper.contour(0, moved(ride.T_map_keyframes, {2, -4, 0})).size(), contour.size());
}

TEST(Mapper, AFloorCameraThatIsKnockedIsNamedAndOneThatIsNotIsNot) {
  constexpr int kLearned = 60;
  Ride ride;
  Pose2 T_odom_body;
  const auto go_on = [&](int steps) {
    for (int k = 0; k < steps && ride.mapper.rig_fault().empty(); ++k) {
      T_odom_body = T_odom_body * exp_twist(k % 2 == 0 ? Twist2{0.16, 0} : Twist2{0, 0.2}, 1);
      const Observation seen = ride.look(T_odom_body);
      ride.keyframes.empty() ? ride.keyframe(seen) : ride.step(seen);
    }
  };
  go_on(kLearned);
  EXPECT_EQ(ride.mapper.rig_fault(), "");
  ride.knock("floor", {Vec3(0, deg_to_rad(1.5), 0), Vec3::Zero()});
  go_on(kLearned / 3);
  EXPECT_THAT(ride.mapper.rig_fault(),
              testing::StartsWith("floor was knocked: the floor moves in its pictures as if"));
}

TEST(Mapper, TheSameStepsMakeTheSameBits) {
  std::vector<Ride> rides;
  std::vector<Mapped> last;
  for (int run = 0; run < 2; ++run) {
    rides.emplace_back(MapperOptions{}, one_floor_camera(), carpet_with_a_box());
    Ride& ride = rides.back();
    for (int i = 0; i < 4; ++i) {
      const Observation seen = ride.look({0.05 * i, 0.5, 0.05 * i});
      i % 2 == 0 ? ride.keyframe(seen) : ride.step(seen, std::nullopt, i == 3);
    }
    last.push_back(ride.step(ride.look({0.3, 0.5, 0.3})));
  }
  EXPECT_GT(count(rides[0].finished(), Cell::kOccupied), 0);
  EXPECT_TRUE(same(rides[0].finished(), rides[1].finished()));
  EXPECT_TRUE(same(last[0].local_odom, last[1].local_odom));
  EXPECT_EQ(last[0].reading.evidence, last[1].reading.evidence);
  EXPECT_TRUE(same(rides[0].mapper.map(rides[0].T_map_keyframes),
                   rides[1].mapper.map(rides[1].T_map_keyframes)));
  EXPECT_EQ(rides[0].mapper.contour(0, rides[0].T_map_keyframes),
            rides[1].mapper.contour(0, rides[1].T_map_keyframes));
}

}  // namespace
}  // namespace panoptes

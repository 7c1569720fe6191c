// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_mapper.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/camera/mounting.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

const Surface kGreyBlue{Vec3(110, 95, 85), 0.1, 1};
const Surface kBrown{Vec3(70, 90, 120), 0.12, 2};
const Surface kWood{Vec3(90, 140, 185), 0.12, 3};
const Surface kWhite{Vec3(205, 205, 205), 0.03, 4};

int evidence_at(const FloorReading& reading, double x_m, double y_m) {
  const FloorProjection& p = *reading.projection;
  const Vec2 at = (Vec2(x_m, y_m) - p.origin_view) / p.cell_m;
  return reading.evidence[static_cast<std::size_t>(static_cast<int>(at.y()) * p.cell_columns +
                                                   static_cast<int>(at.x()))];
}

// Share of the cells of a rectangle that speak for free, and against.
struct Shares {
  double free = 0;
  double occupied = 0;
};

Shares shares(const FloorReading& reading, const Vec2& low, const Vec2& high) {
  Shares out;
  int cells = 0;
  for (double x = low.x(); x < high.x(); x += 0.01) {
    for (double y = low.y(); y < high.y(); y += 0.01) {
      const int e = evidence_at(reading, x, y);
      out.free += e > 0 ? 1 : 0;
      out.occupied += e < 0 ? 1 : 0;
      ++cells;
    }
  }
  return {out.free / cells, out.occupied / cells};
}

const SceneBox kFarWall = {Vec2(8, -30), Vec2(8.2, 30), 2.5, kWood};

TEST(FloorMapper, SeesAnEmptyCarpetAsFree) {
  Rng rng(1);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.boxes = {kFarWall};
  const FloorReading reading = mapper.read(draw(scene, camera, {}, rng), {}, true);
  EXPECT_TRUE(reading.sees_floor) << reading.fault;
  EXPECT_GT(shares(reading, Vec2(0.5, -0.3), Vec2(3, 0.3)).free, 0.98);
  EXPECT_NEAR(reading.free_ahead_m, 3, 0.1);
  EXPECT_EQ(reading.log_ratio.type(), CV_32F);
}

TEST(FloorMapper, SeesOnlyTheFootOfABoxAndNothingBehind) {
  Rng rng(2);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.boxes = {{Vec2(1.2, -0.3), Vec2(1.8, 0.3), 0.5, kWood}};
  scene.contact_shade = 0.35;
  const FloorReading reading = mapper.read(draw(scene, camera, {}, rng), {}, true);
  EXPECT_GT(shares(reading, Vec2(0.5, -0.2), Vec2(1.16, 0.2)).free, 0.97);
  const Shares foot = shares(reading, Vec2(1.205, -0.25), Vec2(1.235, 0.25));
  EXPECT_GT(foot.occupied, 0.9);
  const Shares behind = shares(reading, Vec2(1.3, -0.25), Vec2(2.9, 0.25));
  EXPECT_EQ(behind.free, 0);
  EXPECT_EQ(behind.occupied, 0);
  // beside it the floor is seen
  EXPECT_GT(shares(reading, Vec2(1.2, 0.5), Vec2(2, 0.8)).free, 0.97);
  EXPECT_NEAR(reading.free_ahead_m, 1.2 - 0.25, 0.03);
}

TEST(FloorMapper, PassesOverAStainTooLowToBeAThing) {
  Rng rng(3);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.boxes = {{Vec2(1.2, -0.3), Vec2(1.22, 0.3), 0.001, kWhite}};
  const FloorReading reading = mapper.read(draw(scene, camera, {}, rng), {}, true);
  EXPECT_GT(shares(reading, Vec2(1.3, -0.25), Vec2(2, 0.25)).free, 0.95);
}

// Dark joints of 1 cm, 20 cm apart both ways.
FloorScene tiles() {
  FloorScene scene;
  scene.carpet = kGreyBlue;
  const Surface joint{Vec3(40, 40, 45), 0.05, 9};
  for (double at = -1; at <= 1.001; at += 0.2) {
    scene.boxes.push_back({Vec2(0.9, at - 0.005), Vec2(2.3, at + 0.005), 0.001, joint});
  }
  for (double at = 0.9; at <= 2.31; at += 0.2) {  // beyond the floor that it knows from the start
    scene.boxes.push_back({Vec2(at, -1), Vec2(at + 0.01, 1), 0.001, joint});
  }
  return scene;
}

TEST(FloorMapper, TheJointsOfTilesAreFloorAlongAcrossAndWhereTheyCross) {
  Rng rng(3);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  const FloorReading reading = mapper.read(draw(tiles(), camera, {}, rng), {}, true);
  const Shares seen = shares(reading, Vec2(0.8, -0.3), Vec2(1.6, 0.3));
  EXPECT_GT(seen.free, 0.9);
  EXPECT_LT(seen.occupied, 0.01);
}

TEST(FloorMapper, AThinPostAmongTheJointsOfTilesIsNone) {
  Rng rng(3);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene = tiles();
  scene.boxes.push_back({Vec2(1.29, 0.1), Vec2(1.315, 0.125), 0.7, {Vec3(40, 40, 45), 0.05, 9}});
  const FloorReading reading = mapper.read(draw(scene, camera, {}, rng), {}, true);
  EXPECT_GT(shares(reading, Vec2(1.28, 0.1), Vec2(1.32, 0.125)).occupied, 0.5);
  EXPECT_LT(shares(reading, Vec2(1.4, 0.12), Vec2(1.8, 0.13)).free, 0.2);
}

TEST(FloorMapper, LearnsASecondCarpetByDrivingTowardsIt) {
  Rng rng(4);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.second_carpet = kBrown;
  scene.seam_x_m = 1.8;
  scene.boxes = {{Vec2(1.9, 0.35), Vec2(2.4, 0.9), 0.6, kWood}};
  double learned_at_m = -1;
  for (double x = 0; x <= 1.3; x += 0.027) {
    const FloorReading reading = mapper.read(draw(scene, camera, {x, 0, 0}, rng), {x, 0, 0}, true);
    if (reading.learned_new_floor && learned_at_m < 0) {
      learned_at_m = x;
    }
    if (x < 0.1) {
      EXPECT_LT(shares(reading, Vec2(1.9 - x, -0.3), Vec2(2.5 - x, 0.1)).free, 0.05);
    }
  }
  ASSERT_GE(learned_at_m, 0);
  EXPECT_LE(learned_at_m, 1.0);
  const Pose2 end{1.3, 0, 0};
  const FloorReading reading = mapper.read(draw(scene, camera, end, rng), end, true);
  EXPECT_GT(shares(reading, Vec2(0.6, -0.3), Vec2(1.5, 0.1)).free, 0.95);
  EXPECT_LT(shares(reading, Vec2(0.61, 0.4), Vec2(1.2, 0.85)).free, 0.02);
}

// Far away a pixel of a wide lens covers more floor than its texture is wide, which tells nothing.
TEST(FloorMapper, LearnsASecondCarpetThroughAWideLens) {
  Rng rng(4);
  RigCamera camera = office_floor_camera();
  camera.intrinsics = pinhole(320, 240, deg_to_rad(110));
  camera.T_body_camera = mounted_camera(Vec3(0.2, 0, 0.55), 0, deg_to_rad(24));
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.second_carpet = kBrown;
  scene.second_carpet.contrast = 0.3;
  scene.seam_x_m = 1.2;
  scene.boxes = {kFarWall};
  double learned_at_m = -1;
  for (double x = 0; x <= 0.7 && learned_at_m < 0; x += 0.027) {
    if (mapper.read(draw(scene, camera, {x, 0, 0}, rng), {x, 0, 0}, true).learned_new_floor) {
      learned_at_m = x;
    }
  }
  EXPECT_GE(learned_at_m, 0);
}

TEST(FloorMapper, FurnitureOfItsColourDoesNotForbidACarpet) {
  Rng rng(11);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.second_carpet = kBrown;
  scene.seam_x_m = 2.2;
  scene.boxes = {{Vec2(0.9, 0.45), Vec2(1.9, 1.2), 0.7, {kBrown.bgr, 0.12, 8}},
                 {Vec2(1.1, -1.2), Vec2(1.8, -0.5), 0.7, {kBrown.bgr, 0.12, 9}}};
  bool learned = false;
  for (double x = 0; x <= 1.7; x += 0.027) {
    const FloorReading reading = mapper.read(draw(scene, camera, {x, 0, 0}, rng), {x, 0, 0}, true);
    if (x < 0.4) {
      ASSERT_FALSE(reading.learned_new_floor) << "of a box, at " << x;
    }
    learned = learned || reading.learned_new_floor;
  }
  EXPECT_TRUE(learned);
}

TEST(FloorMapper, NeverLearnsABoxHoweverLongItLooks) {
  for (const Surface& surface : {kWood, kWhite, kBrown}) {
    Rng rng(5);
    const RigCamera camera = office_floor_camera();
    FloorMapper mapper({}, camera, {});
    FloorScene scene;
    scene.carpet = kGreyBlue;
    scene.boxes = {{Vec2(2, -2), Vec2(2.6, 2), 0.72, surface}};
    for (double x = 0; x <= 1.5; x += 0.027) {
      const Pose2 pose{x, 0.1 * std::sin(2 * x), 0.2 * std::cos(2 * x)};
      const FloorReading reading = mapper.read(draw(scene, camera, pose, rng), pose, true);
      ASSERT_FALSE(reading.learned_new_floor) << "at " << x << " m of " << surface.bgr.transpose();
    }
  }
}

TEST(FloorMapper, LeavesTheSecondCarpetAnObstacleWithoutParallax) {
  Rng rng(6);
  const RigCamera camera = office_floor_camera();
  FloorMapperOptions options;
  options.parallax = false;
  FloorMapper mapper(options, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.second_carpet = kBrown;
  scene.seam_x_m = 1.8;
  for (double x = 0; x <= 1; x += 0.1) {
    const FloorReading reading = mapper.read(draw(scene, camera, {x, 0, 0}, rng), {x, 0, 0}, true);
    EXPECT_LT(shares(reading, Vec2(1.9 - x, -0.2), Vec2(2.4 - x, 0.2)).free, 0.02);
  }
}

// What is found to stand up on a drive of 0.8 m towards what lies ahead.
std::vector<UprightPoint> found_ahead(const FloorScene& scene) {
  Rng rng(11);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  std::vector<UprightPoint> found;
  for (int i = 0; i < 21; ++i) {
    const Pose2 T{0.04 * i, 0, 0};
    const FloorReading reading = mapper.read(draw(scene, camera, T, rng), T, true);
    found.insert(found.end(), reading.upright_odom.begin(), reading.upright_odom.end());
  }
  return found;
}

TEST(FloorMapper, FindsTheWholeFaceOfAThingOfTheFloorsColour) {
  FloorScene scene;
  scene.carpet = {kGreyBlue.bgr, 0.25, 1};
  const SceneBox box{Vec2(1.6, -0.35), Vec2(2.2, 0.4), 0.5, scene.carpet};
  scene.boxes = {kFarWall, box};
  const std::vector<UprightPoint> found = found_ahead(scene);
  for (double y = box.low.y() + 0.05; y < box.high.y(); y += 0.05) {
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const UprightPoint& point) {
      return (point.p_odom - Vec2(box.low.x(), y)).norm() < 0.08;
    })) << y;
  }
  const auto astray = std::count_if(found.begin(), found.end(), [&](const UprightPoint& point) {
    return point.p_odom.x() < box.low.x() - 0.08;
  });
  EXPECT_LE(10 * astray, static_cast<int>(found.size()));
}

// A wall with a skirting board of the floor's colour: colour alone sees floor up to its edge.
// It stands still, so that nothing moves: only how far up the wall goes tells it from the floor.
TEST(FloorMapper, AWallOfTheFloorsColourEndsTheFloorForACameraThatSeesTheHorizon) {
  const RigCamera camera = office_floor_camera();
  RigCamera level = camera;
  level.floor.reset();
  level.T_body_camera = mounted_camera(camera.T_body_camera.translation - Vec3(0, 0, 0.3), 0, 0);
  FloorScene scene;
  scene.carpet = kGreyBlue;
  Surface plain = kGreyBlue;
  plain.bgr *= 1.1;
  plain.contrast = 0.01;
  scene.boxes = {{Vec2(1.4, -5), Vec2(1.6, 5), 2, plain}};
  const auto leaks = [&](bool faces) {
    Rng rng(2);
    FloorMapperOptions options;
    options.faces = faces;
    FloorMapper mapper(options, camera, {}, &level);
    FloorReading reading;
    for (int i = 0; i < 5; ++i) {
      const cv::Mat picture = draw(scene, camera, {}, rng);
      const FloorMapper::SecondPicture second{draw(scene, level, {}, rng), Pose2{}};
      reading = mapper.read(picture, {}, true, &second);
    }
    EXPECT_GT(shares(reading, Vec2(0.5, -0.2), Vec2(1.25, 0.2)).free, 0.9);
    return shares(reading, Vec2(1.6, -0.3), Vec2(2.5, 0.3)).free;
  };
  EXPECT_GT(leaks(false), 0.9);
  EXPECT_LT(leaks(true), 0.02);
}

TEST(FloorMapper, AWallStandsWhereItsSkirtingBoardDoes) {
  FloorScene scene;
  scene.carpet = {kGreyBlue.bgr, 0.15, 1};
  constexpr double kWall_m = 1.5;
  scene.boxes = {{Vec2(kWall_m, -30), Vec2(kWall_m + 0.005, 30), 0.1, scene.carpet},
                 {Vec2(kWall_m + 0.005, -30), Vec2(kWall_m + 0.2, 30), 2.5, {kWhite.bgr, 0.2, 4}}};
  const std::vector<UprightPoint> found = found_ahead(scene);
  int on_it = 0;
  for (const UprightPoint& point : found) {
    on_it += std::abs(point.p_odom.x() - kWall_m) < 0.06 ? 1 : 0;
  }
  EXPECT_GE(found.size(), 20U);
  EXPECT_GE(on_it, static_cast<int>(0.9 * static_cast<double>(found.size())));
}

TEST(FloorMapper, TellsWhichPlacesArePaintedAndNotWhatStands) {
  for (const double height_m : {0.001, 0.15}) {
    Rng rng(6);
    const RigCamera camera = office_floor_camera();
    FloorMapper mapper({}, camera, {});
    FloorScene scene;
    scene.carpet = kGreyBlue;
    scene.boxes = {{Vec2(1.8, -0.8), Vec2(1.9, 0.8), height_m, kWhite}};
    std::vector<Vec2> painted;
    for (double x = 0; x <= 0.9; x += 0.025) {
      const FloorReading reading =
          mapper.read(draw(scene, camera, {x, 0, 0}, rng), {x, 0, 0}, true);
      painted.insert(painted.end(), reading.painted_odom.begin(), reading.painted_odom.end());
    }
    if (height_m > 0.1) {
      EXPECT_TRUE(painted.empty()) << painted.size();
      continue;
    }
    EXPECT_GE(painted.size(), 1000U);
    EXPECT_TRUE(std::all_of(painted.begin(), painted.end(), [](const Vec2& p) {
      return p.x() > 1.77 && p.x() < 1.93 && std::abs(p.y()) < 0.83;
    }));
  }
}

// Where no robot passes between two things, what shows there is no floor to drive on.
TEST(FloorMapper, WhatStandsCloseTogetherHidesWhatShowsBetween) {
  Rng rng(4);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  const Surface textured{Vec3(90, 120, 200), 0.6, 5};
  scene.boxes = {{Vec2(1.6, 0.08), Vec2(1.66, 0.16), 0.5, textured},
                 {Vec2(1.6, -0.16), Vec2(1.66, -0.08), 0.5, textured}};
  FloorReading reading;
  double x = 0;
  for (; x <= 0.7; x += 0.04) {
    reading = mapper.read(draw(scene, camera, {x, 0, 0}, rng), {x, 0, 0}, true);
  }
  x -= 0.04;
  EXPECT_LT(shares(reading, Vec2(1.75 - x, -0.05), Vec2(2.1 - x, 0.05)).free, 0.2);
  EXPECT_GT(shares(reading, Vec2(1.75 - x, 0.5), Vec2(2.1 - x, 0.6)).free, 0.9);
}

TEST(FloorMapper, NothingStandsOnTwoCarpets) {
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.second_carpet = kBrown;
  scene.seam_x_m = 1.5;
  scene.boxes = {kFarWall};
  EXPECT_TRUE(found_ahead(scene).empty());
}

TEST(FloorMapper, DoesNotLearnAfterABump) {
  Rng rng(7);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.boxes = {kFarWall};
  ASSERT_TRUE(mapper.read(draw(scene, camera, {}, rng), {}, true).sees_floor);
  const double mass = mapper.colour().learned()[0].mass;
  for (int i = 0; i < 6; ++i) {
    mapper.read(draw(scene, camera, {}, rng), {}, false);
  }
  EXPECT_EQ(mapper.colour().learned()[0].mass, mass);
}

TEST(FloorMapper, LearnsAsOftenWhateverTheRateOfItsCamera) {
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.boxes = {kFarWall};
  for (const auto& [rate_hz, learned] :
       std::vector<std::pair<double, int>>{{15, 5}, {30, 3}, {5, 15}, {1, 15}}) {
    Rng rng(7);
    RigCamera camera = office_floor_camera();
    camera.rate_hz = rate_hz;
    FloorMapperOptions options;
    options.colour.mass_max = 1e9;
    FloorMapper mapper(options, camera, {});
    int times = 0;
    double mass = 0;
    for (int i = 0; i < 15; ++i) {
      mapper.read(draw(scene, camera, {}, rng), {}, true);
      times += mapper.colour().learned()[0].mass != mass ? 1 : 0;
      mass = mapper.colour().learned()[0].mass;
    }
    EXPECT_EQ(times, learned) << rate_hz;
  }
}

TEST(FloorMapper, SaysThatItDoesNotSeeAFloor) {
  Rng rng(8);
  const RigCamera camera = office_floor_camera();
  cv::Mat jumble(240, 320, CV_8UC3);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      for (int c = 0; c < 3; ++c) {
        jumble.ptr<std::uint8_t>(v)[3 * u + c] = static_cast<std::uint8_t>(rng.index(256));
      }
    }
  }
  FloorMapper mapper({}, camera, {});
  const FloorReading reading = mapper.read(jumble, {}, true);
  EXPECT_FALSE(reading.sees_floor);
  EXPECT_NE(reading.fault, "");
  FloorMapper dark({}, camera, {});
  EXPECT_FALSE(dark.read(cv::Mat::zeros(240, 320, CV_8UC3), {}, true).sees_floor);
}

TEST(FloorMapper, APlainFaceUpToTheHorizonIsNoFloor) {
  Rng rng(12);
  const RigCamera camera = office_floor_camera();
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.boxes = {{Vec2(0.3, -2), Vec2(0.9, 2), 2.0, kWood}};
  FloorMapper mapper({}, camera, {});
  const FloorReading reading = mapper.read(draw(scene, camera, {}, rng), {}, true);
  EXPECT_FALSE(reading.sees_floor);
  EXPECT_EQ(
      reading.fault,
      "what lies just ahead of the robot looks the same up to the horizon: a thing, no floor");
}

TEST(FloorMapper, ADeskRightAheadIsNoFloor) {
  Rng rng(10);
  const RigCamera camera = office_floor_camera();
  FloorScene scene;
  scene.carpet = kGreyBlue;
  // a wooden front with a white sheet and a dark plinth, 5 cm before the bumper
  scene.boxes = {{Vec2(0.3, -1), Vec2(0.9, 1), 0.72, kWood},
                 {Vec2(0.295, -0.3), Vec2(0.3, -0.02), 0.5, kWhite},
                 {Vec2(0.295, 0.1), Vec2(0.3, 0.4), 0.5, {Vec3(40, 30, 30), 0.1, 7}}};
  FloorMapper mapper({}, camera, {});
  const FloorReading reading = mapper.read(draw(scene, camera, {}, rng), {}, true);
  EXPECT_FALSE(reading.sees_floor);
  EXPECT_NE(reading.fault, "");
  // where two carpets meet right ahead, both are floor
  FloorScene seam;
  seam.carpet = kGreyBlue;
  seam.second_carpet = kBrown;
  seam.seam_x_m = 0.5;
  seam.boxes = {kFarWall};
  FloorMapper both({}, camera, {});
  const FloorReading two = both.read(draw(seam, camera, {}, rng), {}, true);
  EXPECT_TRUE(two.sees_floor) << two.fault;
  EXPECT_GT(shares(two, Vec2(0.6, -0.3), Vec2(2, 0.3)).free, 0.95);
}

TEST(FloorMapper, GivesTheSameBitsTwice) {
  const RigCamera camera = office_floor_camera();
  FloorScene scene;
  scene.carpet = kGreyBlue;
  scene.second_carpet = kBrown;
  scene.seam_x_m = 1.6;
  FloorMapper one({}, camera, {});
  FloorMapper two({}, camera, {});
  Rng rng(9);
  for (double x = 0; x < 0.5; x += 0.05) {
    const cv::Mat picture = draw(scene, camera, {x, 0, 0}, rng);
    EXPECT_EQ(one.read(picture, {x, 0, 0}, true).evidence,
              two.read(picture, {x, 0, 0}, true).evidence);
  }
}

}  // namespace
}  // namespace panoptes

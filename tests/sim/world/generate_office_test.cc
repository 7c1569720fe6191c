// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/config/data_files.h"
#include "core/config/fields.h"
#include "sim/physics/obstacles.h"
#include "sim/world/generate.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"
#include "sim/world/office_room.h"
#include "tests/sim/world/look_around.h"

namespace panoptes::sim {
namespace {

constexpr double kRobotRadius_m = 0.25;
constexpr double kRobotHeight_m = 0.8;
constexpr double kCell_m = 0.05;  // of FreeRegion's grid
constexpr std::size_t kMostTriangles = 45000;

template <class Plan>
WorldSettings generated(const Plan& plan) {
  WorldSettings settings;
  generate(plan, settings);
  return settings;
}

/// One small picture instead of many large ones, where only shapes matter.
World shapes_of(WorldSettings settings) {
  for (BoxSettings& box : settings.boxes) {
    box.picture = data_root() + "/assets/office/plain_white.png";
    for (auto& [face, picture] : box.faces) {
      picture = picture.empty() ? "" : box.picture;
    }
  }
  return make_world(settings);
}

std::size_t triangles_of(const World& world) {
  return std::accumulate(world.objects.begin(), world.objects.end(), std::size_t{0},
                         [](std::size_t sum, const Object& o) { return sum + o.triangles.size(); });
}

/// Of the room's floor that a robot of 0.25 m radius could stand on, how much it cannot drive to.
double unreached_m2(const World& world, const Vec2& size_m) {
  const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
  const FreeRegion region(obstacles, kRobotRadius_m);
  // A few millimetres more than the region asks for, so that its cells' rounding decides nothing.
  constexpr double kMore_m = 0.02;
  int lost = 0;
  for (double x = kCell_m / 2; x < size_m.x(); x += kCell_m) {
    for (double y = kCell_m / 2; y < size_m.y(); y += kCell_m) {
      const Vec2 p(x, y);
      lost +=
          !region.contains(p) && !obstacles.nearest(p, kRobotRadius_m + kCell_m + kMore_m) ? 1 : 0;
    }
  }
  return lost * kCell_m * kCell_m;
}

OfficePlan plan_of(std::uint64_t seed) {
  Rng rng(seed);
  OfficePlan plan;
  plan.size_m = Vec2(rng.uniform(5, 16), rng.uniform(5, 16));
  plan.desks = rng.index(most_desks(plan.size_m) + 1);
  plan.overhangs = rng.index(2) == 0;
  plan.texture = rng.uniform();
  plan.seed = seed;
  return plan;
}

TEST(GenerateOffice, EveryPlaceIsReachedInRoomsOfAnySize) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const OfficePlan plan = plan_of(seed);
    const WorldSettings settings = generated(plan);
    EXPECT_EQ(std::count_if(settings.objects.begin(), settings.objects.end(),
                            [](const ObjectSettings& o) { return o.name.starts_with("desk-"); }),
              plan.desks)
        << seed;
    const World world = shapes_of(settings);
    EXPECT_EQ(unreached_m2(world, plan.size_m), 0) << seed;
    EXPECT_LT(triangles_of(world), kMostTriangles) << seed;
  }
}

TEST(GenerateOffice, TheSamePlanGivesTheSamePlaceAndAnotherSeedAnother) {
  const OfficePlan plan = plan_of(3);
  const std::string first = write_settings(generated(plan));
  EXPECT_EQ(write_settings(generated(plan)), first);
  OfficePlan other = plan;
  other.seed = 4;
  EXPECT_NE(write_settings(generated(other)), first);
}

TEST(GenerateOffice, AsManyDesksAsFitAreTakenAndOneMoreIsRefused) {
  OfficePlan plan;
  plan.size_m = Vec2(12, 9);
  plan.desks = most_desks(plan.size_m);
  EXPECT_EQ(plan.desks, 20);
  generated(plan);
  plan.desks += 1;
  EXPECT_THROW(generated(plan), ConfigError);
}

TEST(GenerateOffice, WhatDoesNotFitIsRefusedWhereItIsWritten) {
  try {
    read_settings_text<WorldSettings>("generate: {office: {size_m: [6, 5], desks: 40}}\n",
                                      "world.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_EQ(std::string(error.what()),
              "world.yaml:1:44: generate.office.desks: must be at most 4, which is what fits into "
              "6 m x 5 m with aisles of 0.9 m; take fewer desks or a larger size_m, got 40");
  }
  try {
    read_settings_text<WorldSettings>("generate: {mirrored: {desks: 7}}\n", "world.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("must be even and at most"));
  }
}

TEST(GenerateOffice, WithoutTextureNothingHangsOnTheWalls) {
  OfficePlan plan;
  plan.texture = 0;
  for (const ObjectSettings& object : generated(plan).objects) {
    for (const char* kind : {"poster", "banner", "sign", "sheet", "plate", "socket", "shelf"}) {
      EXPECT_FALSE(object.name.starts_with(kind)) << object.name;
    }
  }
}

TEST(GenerateOffice, OverhangsLeaveTheFloorUnderThemFreeButCoverIt) {
  OfficePlan plan;
  plan.overhangs = true;
  plan.desks = 4;
  const WorldSettings settings = generated(plan);
  const World world = shapes_of(settings);
  const TruthLayer low = occupancy(world, kFloorLayerTop_m, 0.28, 0.02);
  const TruthLayer body = occupancy(world, kFloorLayerTop_m, kRobotHeight_m, 0.02);
  for (const ObjectSettings& object : settings.objects) {
    if (object.name.starts_with("desk-legs")) {
      const Vec2 knees = object.at * Vec2(0.0, 0.55);  // beside the chair, between the legs
      EXPECT_FALSE(low.at(knees)) << object.name;
      EXPECT_TRUE(body.at(knees)) << object.name;
    }
  }
}

TEST(GenerateMirrored, EveryThingHasItsDoubleHalfATurnOff) {
  constexpr double kRoundoff_m = 1e-9;
  MirroredPlan plan;
  plan.seed = 5;
  const WorldSettings settings = generated(plan);
  ASSERT_FALSE(settings.objects.empty());
  for (const ObjectSettings& a : settings.objects) {
    const Vec2 there = plan.size_m - a.at.position();
    EXPECT_TRUE(
        std::any_of(settings.objects.begin(), settings.objects.end(),
                    [&](const ObjectSettings& b) {
                      return b.mesh == a.mesh && b.textures == a.textures && b.z_m == a.z_m &&
                             (b.at.position() - there).norm() < kRoundoff_m &&
                             std::abs(std::abs(wrap_angle(b.at.theta_rad - a.at.theta_rad)) -
                                      std::numbers::pi) < kRoundoff_m;
                    }))
        << a.name;
  }
  const World world = shapes_of(settings);
  EXPECT_EQ(unreached_m2(world, plan.size_m), 0);
  EXPECT_LT(triangles_of(world), kMostTriangles);
}

// What was measured in the office stays comparable as long as its free floor is the same.
TEST(Office, AReachOfFloorThatDoesNotChange) {
  const World world = load_world(data_root() + "/scenes/worlds/office.yaml");
  const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
  constexpr double kGrid_m2 = 0.7;  // the region's cells must be free all over
  EXPECT_NEAR(FreeRegion(obstacles, kRobotRadius_m).area_m2(), 31.9, kGrid_m2);
  EXPECT_LT(triangles_of(world), kMostTriangles);
}

// The shares over 400 places are texture_check's to measure; of a few the poorest is far from poor.
void expect_rich(const World& world) {
  constexpr int kPoses = 8;
  const Richness count = richness(world, kPoses, Rng(1));
  EXPECT_GE(count.judged, kPoses / 2);
  EXPECT_EQ(count.rich, count.judged);
}

TEST(Office, PicturesHaveManyPoints) {
  expect_rich(load_world(data_root() + "/scenes/worlds/office.yaml"));
}

TEST(GenerateOffice, PicturesHaveManyPoints) {
  OfficePlan plan;
  plan.size_m = Vec2(7, 5.5);
  plan.desks = 4;
  expect_rich(make_world(generated(plan)));
}

TEST(GenerateOffice, WithoutTextureMostPicturesHaveFewPoints) {
  OfficePlan plan;
  plan.size_m = Vec2(7, 5.5);
  plan.desks = 4;
  plan.texture = 0;
  EXPECT_LT(richness(make_world(generated(plan)), 8, Rng(1)).share(), 0.5);
}

}  // namespace
}  // namespace panoptes::sim

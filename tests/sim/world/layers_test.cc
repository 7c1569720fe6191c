// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/layers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/world/truth_layers.h"
#include "tests/sim/world/boxes.h"

namespace panoptes::sim {
namespace {

constexpr double kRoundoff_m = 1e-12;  // a few ulps at room scale
constexpr double kMast_m = 0.8;

World world_of(std::vector<Object> objects) {
  World world;
  world.objects = std::move(objects);
  return world;
}

double area_m2(const std::vector<Vec2>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& a = corners[i];
    const Vec2& b = corners[(i + 1) % corners.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

long cells_set(const TruthLayer& layer) {
  return std::accumulate(layer.cells.begin(), layer.cells.end(), 0L);
}

TEST(Outlines, ABoxGivesItsFourCornersCounterClockwise) {
  const auto found =
      outlines(world_of({{"desk", on_floor({1, 2, 0.5}), box({-0.4, -0.8, 0}, {0.4, 0.8, 0.72})}}),
               0.02, kMast_m);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].object, "desk");
  ASSERT_EQ(found[0].corners_scene.size(), 4U);
  EXPECT_NEAR(area_m2(found[0].corners_scene), 0.8 * 1.6, kRoundoff_m);
  const Vec2 corner = Pose2{1, 2, 0.5} * Vec2(0.4, 0.8);
  EXPECT_TRUE(std::any_of(found[0].corners_scene.begin(), found[0].corners_scene.end(),
                          [&corner](const Vec2& p) { return (p - corner).norm() < kRoundoff_m; }));
}

TEST(Outlines, ATaperedPartIsCutWhereItIsWidestInTheSlab) {
  std::array<Vec3, 8> p;  // half a side of 1 m on the floor, 0.5 m at z = 1
  for (std::size_t i = 0; i < 8; ++i) {
    const double half_m = i >= 4 ? 0.5 : 1.0;
    p[i] = Vec3(i % 4 == 1 || i % 4 == 2 ? half_m : -half_m, i % 4 >= 2 ? half_m : -half_m,
                i >= 4 ? 1 : 0);
  }
  const auto found = outlines(world_of({{"cone", {}, hexahedron(p)}}), 0.2, kMast_m);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(area_m2(found[0].corners_scene), std::pow(2 * 0.9, 2), kRoundoff_m);
}

TEST(Outlines, WhatEndsOnTheSlabIsNotInIt) {
  const World world = world_of({{"floor", {}, floor_sheet()},
                                {"ceiling lamp", {}, box({0, 0, 2}, {1, 1, 2.1})},
                                {"top", {}, box({0, 0, kMast_m}, {1, 1, 1})}});
  EXPECT_TRUE(outlines(world, 0, kFloorLayerTop_m).empty());
  EXPECT_TRUE(outlines(world, kFloorLayerTop_m, kMast_m).empty());
}

// Fine enough that comparing every corner with every face would take minutes.
TEST(Outlines, AFineBallIsOneCircle) {
  constexpr int kAround = 200;
  constexpr int kUp = 100;
  const auto at = [](int around, int up) {
    const double longitude = 2 * M_PI * (around % kAround) / kAround;
    const double latitude = M_PI * up / kUp - M_PI / 2;
    return Vec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                1 + std::sin(latitude));
  };
  std::vector<Triangle> ball;
  for (int up = 0; up < kUp; ++up) {
    for (int around = 0; around < kAround; ++around) {
      const Corner a{at(around, up), Vec2::Zero()};
      const Corner b{at(around + 1, up), Vec2::Zero()};
      const Corner c{at(around + 1, up + 1), Vec2::Zero()};
      const Corner d{at(around, up + 1), Vec2::Zero()};
      if (up > 0) {
        ball.push_back({{a, b, c}, 0});
      }
      if (up + 1 < kUp) {
        ball.push_back({{a, c, d}, 0});
      }
    }
  }
  const auto found = outlines(world_of({{"ball", {}, ball}}), 0.5, 1.5);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(area_m2(found[0].corners_scene), M_PI, 1e-3);  // a polygon of 200 corners
}

TEST(Outlines, EachConnectedPartHasItsOwn) {
  std::vector<Triangle> two = box({0, 0, 0}, {0.1, 0.1, 0.7});
  const std::vector<Triangle> second = box({1, 0, 0}, {1.1, 0.1, 0.7});
  two.insert(two.end(), second.begin(), second.end());
  EXPECT_EQ(outlines(world_of({{"legs", {}, two}}), 0.02, kMast_m).size(), 2U);
}

TEST(Outlines, AnUprightSheetHasTwoCorners) {
  const Corner a{{0, 0, 0}, {0, 0}};
  const Corner b{{2, 0, 0}, {1, 0}};
  const Corner c{{2, 0, 1}, {1, 1}};
  const auto found = outlines(world_of({{"pane", {}, {{{a, b, c}, 0}}}}), 0.02, kMast_m);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].corners_scene.size(), 2U);
}

// A room seen from inside is no solid: its walls are there, its inside is free.
TEST(Outlines, APartThatIsNotConvexIsTakenFaceByFace) {
  std::vector<Triangle> room = box({0, 0, 0}, {4, 3, 2.5});
  for (Triangle& t : room) {
    std::swap(t.corners[1], t.corners[2]);
  }
  const World world = world_of({{"room", {}, room}});
  for (const Outline& outline : outlines(world, 0.02, kMast_m)) {
    EXPECT_EQ(outline.corners_scene.size(), 2U);
  }
  const TruthLayer layer = occupancy(world, 0.02, kMast_m, 0.1);
  EXPECT_FALSE(layer.at({2, 1.5}));
  EXPECT_FALSE(layer.at({0.01, 1.5}));
  EXPECT_TRUE(layer.at({-0.01, 1.5}));  // what a wall bounds lies behind it
  EXPECT_TRUE(layer.at({2, 3.01}));
}

TEST(Occupancy, ABoxOnCellEdgesFillsExactlyItsCells) {
  const TruthLayer layer =
      occupancy(world_of({{"box", {}, box({0.2, -0.3, 0}, {0.5, 0.1, 1})}}), 0.02, kMast_m, 0.01);
  EXPECT_EQ(cells_set(layer), 30 * 40);
  EXPECT_TRUE(layer.at({0.205, -0.295}));
  EXPECT_FALSE(layer.at({0.195, -0.295}));
}

// The true area plus a rim: a convex outline crosses at most its length in cells along each axis,
// and those it touches lie within a cell's diagonal of it.
TEST(Occupancy, ATurnedBoxFillsItsAreaAndLessThanACellAround) {
  const double cell_m = 0.01;
  const World world =
      world_of({{"box", on_floor({0, 0, 0.4}), box({-0.5, -0.2, 0}, {0.5, 0.2, 1})}});
  const TruthLayer layer = occupancy(world, 0.02, kMast_m, cell_m);
  const double found_m2 = static_cast<double>(cells_set(layer)) * cell_m * cell_m;
  const double rim_m = std::sqrt(2.0) * cell_m;
  EXPECT_GE(found_m2, 1.0 * 0.4);
  EXPECT_LE(found_m2, (1.0 + 2 * rim_m) * (0.4 + 2 * rim_m));
  for (int row = 0; row < layer.rows; ++row) {
    for (int column = 0; column < layer.columns; ++column) {
      const Vec2 centre = layer.origin + cell_m * Vec2(column + 0.5, row + 0.5);
      const Vec2 p = Pose2{0, 0, 0.4}.inverse() * centre;
      if (std::abs(p.x()) < 0.5 && std::abs(p.y()) < 0.2) {
        ASSERT_TRUE(layer.at(centre)) << centre.transpose();
      }
    }
  }
}

TEST(Occupancy, ASheetOnAnEdgeFillsTheCellsBehindIt) {
  const Corner a{{1, 0.2, 0}, {0, 0}};
  const Corner b{{1, 0.6, 0}, {1, 0}};
  const Corner c{{1, 0.6, 1}, {1, 1}};  // it looks towards +x
  const Corner d{{1, 0.2, 1}, {0, 1}};
  const TruthLayer layer =
      occupancy(world_of({{"pane", {}, {{{a, b, c}, 0}, {{a, c, d}, 0}}}}), 0.02, kMast_m, 0.1);
  EXPECT_EQ(cells_set(layer), 4);
  EXPECT_TRUE(layer.at({0.95, 0.25}));
  EXPECT_FALSE(layer.at({1.05, 0.25}));
}

TEST(Occupancy, APillarBeyondItsOnlyFaceIsWhole) {
  World world = world_of({{"post", {}, {}}});
  const Corner a{{0, 0, 0}, {0, 0}};
  const Corner b{{1, 0, 0}, {1, 0}};
  const Corner c{{1, 0, 1}, {1, 1}};
  world.objects[0].triangles = {{{a, b, c}, 0}};
  world.objects[0].pillars = {{{{0, 0}, {1, 0}, {1, 3}, {0, 3}}, 0, 1}};
  EXPECT_EQ(cells_set(occupancy(world, 0.02, kMast_m, 0.1)), 10 * 30);
  EXPECT_EQ(cells_set(occupancy(world, 1.02, 2, 0.1)), 0);
}

TEST(Occupancy, PeopleAreLeftOut) {
  World world = world_of({{"ann", {}, box({0, 0, 0}, {0.4, 0.4, 1.7})}});
  world.objects[0].kind = Object::Kind::kPerson;
  EXPECT_EQ(cells_set(occupancy(world, 0.02, kMast_m, 0.1)), 0);
}

TEST(Occupancy, LargeWorldsHaveCoarserTruth) {
  EXPECT_EQ(truth_cell_m(world_of({{"floor", {}, box({0, 0, -0.1}, {90, 60, 0})}})), 0.01);
  EXPECT_EQ(truth_cell_m(world_of({{"floor", {}, box({0, 0, -0.1}, {300, 300, 0})}})), 0.05);
  EXPECT_EQ(truth_cell_m(World()), 0.01);
}

TEST(Occupancy, LayersSplitAtTwoCentimetres) {
  const World world = world_of(
      {{"mat", {}, box({0, 0, 0}, {1, 1, 0.015})}, {"shelf", {}, box({2, 0, 0.3}, {3, 1, 0.5})}});
  const TruthLayer floor = occupancy(world, 0, kFloorLayerTop_m, 0.05);
  const TruthLayer body = occupancy(world, kFloorLayerTop_m, kMast_m, 0.05);
  EXPECT_TRUE(floor.at({0.5, 0.5}));
  EXPECT_FALSE(body.at({0.5, 0.5}));
  EXPECT_FALSE(floor.at({2.5, 0.5}));
  EXPECT_TRUE(body.at({2.5, 0.5}));
  EXPECT_EQ(floor.columns, body.columns);
}

TEST(TruthLayers, WhatLiesOnTheFloorIsFloorAndWhatStandsOnItIsNot) {
  const World world = world_of({{"room", {}, box({0, 0, -0.1}, {3, 3, 0})},
                                {"rug", on_floor({1, 1, 0}), box({0, 0, 0}, {1, 1, 0.008})},
                                {"sill", on_floor({0.5, 0.2, 0}), box({0, 0, 0}, {1, 0.1, 0.03})}});
  const TruthLayers layers = truth_layers(world, kMast_m);
  const auto set_at = [](const TruthLayer& layer, const Vec2& p) {
    return layer(layer.column(p), layer.row(p)) != 0;
  };
  EXPECT_FALSE(set_at(layers.floor, {1.5, 1.5})) << "a rug";
  EXPECT_FALSE(set_at(layers.body, {1.5, 1.5}));
  EXPECT_TRUE(set_at(layers.floor, {1, 0.25})) << "a sill";
  EXPECT_TRUE(set_at(layers.body, {1, 0.25}));
}

}  // namespace
}  // namespace panoptes::sim

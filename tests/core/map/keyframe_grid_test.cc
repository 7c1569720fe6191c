// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/keyframe_grid.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

std::shared_ptr<const FloorProjection> office_projection() {
  return std::make_shared<FloorProjection>(project_floor(office_floor_camera(), Body{}));
}

FloorReading even_reading(const std::shared_ptr<const FloorProjection>& projection, int evidence) {
  FloorReading reading;
  reading.projection = projection;
  for (const std::int32_t s : projection->sample) {
    reading.evidence.push_back(static_cast<std::int8_t>(s >= 0 ? evidence : 0));
  }
  return reading;
}

int count(const GridCrop& crop, int value) {
  return static_cast<int>(
      std::count(crop.cells.begin(), crop.cells.end(), static_cast<std::int8_t>(value)));
}

TEST(KeyframeGrid, LeavesNoHolesAtAnyHeading) {
  const auto projection = office_projection();
  const FloorReading reading = even_reading(projection, 10);
  const auto cells = std::count_if(reading.evidence.begin(), reading.evidence.end(),
                                   [](std::int8_t e) { return e != 0; });
  for (const double theta_rad : {0.0, 0.3, 1.0, 2.0, -2.5}) {
    KeyframeGrid grid;
    grid.add(reading, {0.123, -0.456, theta_rad});
    const GridCrop crop = grid.crop();
    // an area in cells, to a cell along its outline of some 12 m
    EXPECT_NEAR(count(crop, 10), static_cast<double>(cells), 1200) << theta_rad;
    // a cell well within the raster is found wherever it was turned to
    const Pose2 T_keyframe_body{0.123, -0.456, theta_rad};
    for (int r = 2; r + 2 < projection->cell_rows; ++r) {
      for (int c = 2; c + 2 < projection->cell_columns; ++c) {
        bool within = true;
        for (int k = 0; k < 25; ++k) {
          within = within && reading.evidence[static_cast<std::size_t>(
                                 (r + k / 5 - 2) * projection->cell_columns + c + k % 5 - 2)] != 0;
        }
        const Vec2 p = T_keyframe_body * (projection->origin_view + 0.01 * Vec2(c + 0.5, r + 0.5));
        if (within) {
          ASSERT_EQ(crop.at(static_cast<int>(std::floor(p.x() / 0.01)),
                            static_cast<int>(std::floor(p.y() / 0.01))),
                    10);
        }
      }
    }
  }
}

TEST(KeyframeGrid, PutsACellWhereItLies) {
  const auto projection = office_projection();
  FloorReading reading = even_reading(projection, 0);
  const Vec2 p_body(1.205, 0.305);
  const Vec2 cell = (p_body - projection->origin_view) / projection->cell_m;
  for (int dr = -1; dr <= 1; ++dr) {
    for (int dc = -1; dc <= 1; ++dc) {
      reading.evidence[static_cast<std::size_t>((static_cast<int>(cell.y()) + dr) *
                                                    projection->cell_columns +
                                                static_cast<int>(cell.x()) + dc)] = -20;
    }
  }
  const Pose2 T_keyframe_body{0.2, 0.1, 0.7};
  KeyframeGrid grid;
  grid.add(reading, T_keyframe_body);
  const Vec2 p = T_keyframe_body * p_body;
  const GridCrop crop = grid.crop();
  EXPECT_EQ(crop.at(static_cast<int>(std::floor(p.x() / 0.01)),
                    static_cast<int>(std::floor(p.y() / 0.01))),
            -20);
  EXPECT_EQ(crop.at(static_cast<int>(std::floor(p.x() / 0.01)) + 5,
                    static_cast<int>(std::floor(p.y() / 0.01))),
            0);
}

TEST(KeyframeGrid, StandingStillMakesNothingCertain) {
  const auto projection = office_projection();
  KeyframeGrid still;
  KeyframeGrid moving;
  for (int i = 0; i < 100; ++i) {
    still.add(even_reading(projection, 6), {});
    moving.add(even_reading(projection, 6), {0.03 * i, 0, 0});
  }
  const GridCrop crop = still.crop();
  EXPECT_EQ(*std::max_element(crop.cells.begin(), crop.cells.end()), 12);
  const GridCrop moved = moving.crop();
  EXPECT_EQ(*std::max_element(moved.cells.begin(), moved.cells.end()), 100);
}

TEST(KeyframeGrid, SomethingNewIsSeenByAStandingRobot) {
  const auto projection = office_projection();
  KeyframeGrid grid;
  for (int i = 0; i < 20; ++i) {
    grid.add(even_reading(projection, 24), {0.03 * i, 0, 0});
  }
  for (int i = 0; i < 10; ++i) {
    grid.add(even_reading(projection, -24), {0.57, 0, 0});
  }
  const GridCrop crop = grid.crop();
  EXPECT_EQ(crop.at(200, 0), -48);
}

TEST(KeyframeGrid, DiscsOverruleAPicture) {
  KeyframeGrid grid;
  grid.add_free_disc(Vec2(-0.1, 0.2), 0.25);
  const GridCrop crop = grid.crop();
  const double area = 3.14159265 * 0.25 * 0.25;
  EXPECT_NEAR(count(crop, 48) * 1e-4, area, 0.01 * 2 * 3.15 * 0.25);  // a cell along the circle
  EXPECT_GT(crop.at(-10, 20), 0);
  EXPECT_EQ(crop.at(-36, 20), 0);
  grid.add_occupied_disc(Vec2(0.2, 0.2), 0.05);
  EXPECT_LT(grid.crop().at(20, 20), 0);
}

TEST(KeyframeGrid, RemembersWhereTheBodyHasBeenAndNoPlaceTwice) {
  KeyframeGrid grid;
  for (int k = 0; k < 100; ++k) {
    grid.add_body(Vec2(0.001 * k, 0), 0.25);
  }
  const GridCrop crop = grid.crop();
  EXPECT_EQ(crop.traversed.size(), 5U);  // 2 cm apart
  EXPECT_EQ(crop.body_radius_m, 0.25);
  EXPECT_EQ(crop.at(0, 0), 48);
}

// Free floor all about, but for a thing that colour has told.
GridCrop free_floor() {
  KeyframeGrid grid;
  grid.add_free_disc(Vec2(1, 0), 2);
  grid.add_occupied_disc(Vec2(1.6, 0), 0.03);
  GridCrop crop = grid.crop();
  crop.cameras = {{Vec2(0, 0), 0.6}, {Vec2(0, 0.3), 0.6}};
  return crop;
}

// How far behind a point of height z, seen at `range_m` from a height, floor is hidden.
double shadow_m(double range_m, double camera_m, double height_m) {
  return range_m * height_m / (camera_m - height_m);
}

TEST(HideBehind, TakesOutTheFloorThatCamerasLookOverAndNoOther) {
  const GridCrop before = free_floor();
  GridCrop crop = before;
  const StandingPoint point{Vec2(1.2, 0), 0.2};
  constexpr double kHalf_m = 0.05;
  EXPECT_TRUE(hide_behind(crop, std::vector<StandingPoint>{point}, kHalf_m));
  for (std::size_t r = 0; r < crop.rows.size(); ++r) {
    const int row = crop.first_row + static_cast<int>(r);
    for (int column = crop.rows[r].begin; column < crop.rows[r].end; ++column) {
      const Vec2 at = crop.cell_m * Vec2(column + 0.5, row + 0.5);
      double inside = -1;  // by how much, of the nearest shadow's edge
      for (const CameraPlace& camera : crop.cameras) {
        const Vec2 to = point.p - camera.foot;
        const Vec2 along = to.normalized();
        const double reach = shadow_m(to.norm(), camera.height_m, point.height_m);
        const double share = camera.height_m / (camera.height_m - point.height_m);
        const double ahead = (at - point.p).dot(along);
        const double aside =
            std::abs(along.x() * (at - point.p).y() - along.y() * (at - point.p).x());
        const double half = kHalf_m * (1 + (share - 1) * std::clamp(ahead / reach, 0.0, 1.0));
        inside = std::max(inside, std::min({ahead, reach - ahead, half - aside}));
      }
      const int was = before.at(column, row);
      const int is = crop.at(column, row);
      if (was < 0 || inside < -2 * crop.cell_m) {
        ASSERT_EQ(is, was) << at.transpose();
      } else if (inside > 2 * crop.cell_m) {
        ASSERT_EQ(is, 0) << at.transpose();
      }
    }
  }
  EXPECT_FALSE(hide_behind(crop, std::vector<StandingPoint>{point}, kHalf_m)) << "a second time";
}

TEST(HideBehind, WhatIsAsHighAsTheCameraHidesAllThatLiesBehind) {
  GridCrop crop = free_floor();
  EXPECT_TRUE(hide_behind(crop, std::vector<StandingPoint>{{Vec2(1.2, 0), 0.7}}));
  for (double x = 1.25; x < 2.9; x += 0.1) {
    EXPECT_LE(crop.at(static_cast<int>(x / crop.cell_m), 0), 0) << x;
  }
}

TEST(HideBehind, WhereTheBodyHasBeenNothingStands) {
  GridCrop crop = free_floor();
  crop.traversed = {Vec2(1.1, 0.05)};
  crop.body_radius_m = 0.25;
  EXPECT_FALSE(hide_behind(crop, std::vector<StandingPoint>{{Vec2(1.2, 0), 0.2}}));
}

TEST(KeyframeGrid, ObstaclesAreTakenBackAndFloorIsNot) {
  KeyframeGrid grid;
  grid.add_free_disc(Vec2(1, 0), 1);
  grid.add_occupied_disc(Vec2(1.6, 0), 0.1);
  GridCrop crop = grid.crop();
  const auto free =
      std::count_if(crop.cells.begin(), crop.cells.end(), [](int v) { return v > 0; });
  EXPECT_TRUE(forget_obstacles(crop));
  EXPECT_FALSE(forget_obstacles(crop));
  grid.forget_obstacles();
  for (const GridCrop& after : {crop, grid.crop()}) {
    EXPECT_EQ(after.at(160, 0), 0);
    EXPECT_EQ(std::count_if(after.cells.begin(), after.cells.end(), [](int v) { return v > 0; }),
              free);
    EXPECT_TRUE(std::none_of(after.cells.begin(), after.cells.end(), [](int v) { return v < 0; }));
  }
}

TEST(KeyframeGrid, PaintIsNoObstacleButWhatStandsNearByIs) {
  KeyframeGrid grid;
  grid.add_free_disc(Vec2(1, 0), 1);
  grid.add_occupied_disc(Vec2(1.2, 0), 0.05);
  grid.add_occupied_disc(Vec2(1.6, 0), 0.05);
  grid.add_standing({Vec2(1.6, 0.08), 0.3});
  for (const double x : {1.2, 1.201, 1.6}) {
    grid.add_proved_floor(Vec2(x, 0));
  }
  GridCrop crop = grid.crop();
  EXPECT_EQ(crop.proved_floor.size(), 2U) << "one a place";
  EXPECT_TRUE(forget_obstacles_on(crop, crop.proved_floor));
  EXPECT_EQ(crop.at(120, 0), 0);
  EXPECT_EQ(crop.at(122, 2), 0);
  EXPECT_LT(crop.at(124, 0), 0);
  EXPECT_LT(crop.at(160, 0), 0);
  EXPECT_GT(crop.at(100, 0), 0);
  EXPECT_FALSE(forget_obstacles_on(crop, crop.proved_floor));
  const std::vector<Vec2> outside = {Vec2(100, 100)};
  EXPECT_FALSE(forget_obstacles_on(crop, outside));
}

TEST(KeyframeGrid, AnEmptyGridCropsToNothing) {
  const GridCrop crop = KeyframeGrid().crop();
  EXPECT_TRUE(crop.rows.empty());
  EXPECT_EQ(crop.at(0, 0), 0);
}

}  // namespace
}  // namespace panoptes

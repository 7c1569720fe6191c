// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/fusion.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/rng.h"

namespace panoptes {
namespace {

// A crop whose cells are `of(x, y)` over [low, high).
template <class Of>
std::shared_ptr<const GridCrop> crop_of(const Vec2& low, const Vec2& high, const Of& of) {
  GridCrop crop;
  crop.first_row = static_cast<int>(std::lround(low.y() / crop.cell_m));
  const int begin = static_cast<int>(std::lround(low.x() / crop.cell_m));
  const int end = static_cast<int>(std::lround(high.x() / crop.cell_m));
  for (int row = crop.first_row; row < std::lround(high.y() / crop.cell_m); ++row) {
    crop.rows.push_back({begin, end, crop.cells.size()});
    for (int column = begin; column < end; ++column) {
      crop.cells.push_back(
          static_cast<std::int8_t>(of((column + 0.5) * crop.cell_m, (row + 0.5) * crop.cell_m)));
    }
  }
  return std::make_shared<GridCrop>(std::move(crop));
}

std::shared_ptr<const GridCrop> random_crop(Rng& rng) {
  const double x = rng.uniform(-0.5, 0.5);
  const double y = rng.uniform(-0.5, 0.5);
  return crop_of(Vec2(std::floor(x * 100) / 100, std::floor(y * 100) / 100),
                 Vec2(std::floor(x * 100) / 100 + 0.8, std::floor(y * 100) / 100 + 0.6),
                 [&](double, double) { return rng.index(200) - 100; });
}

Pose2 random_pose(Rng& rng) { return {rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-3, 3)}; }

TEST(Fusion, AMapThatNoMemoryHoldsIsRefused) {
  const auto crop = crop_of(Vec2(0, 0), Vec2(1, 1), [](double, double) { return 50; });
  for (const double far_m : {1e6, 1e9, 1e15}) {  // in 32 bits of cells, and beyond them
    GlobalMap global(0.05);
    global.add(crop, {});
    EXPECT_THROW(global.add(crop, {far_m, far_m, 0}), ConfigError) << far_m;
  }
  GlobalMap alone(0.05);
  EXPECT_THROW(alone.add(crop, {1e15, 0, 0}), ConfigError);
}

TEST(Fusion, AFinishedMapThatIsTooFineForItsSizeIsMadeCoarser) {
  const auto crop = crop_of(Vec2(0, 0), Vec2(1, 1), [](double, double) { return 50; });
  const OccupancyMap map = fuse(std::vector<PlacedGrid>{{crop, {}}, {crop, {200, 200, 0}}}, 0.01);
  EXPECT_EQ(map.cell_m, 0.02);
  EXPECT_EQ(map.at(Vec2(0.5, 0.5)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(200.5, 200.5)), Cell::kFree);
}

class EveryCellSize : public testing::TestWithParam<double> {};

TEST_P(EveryCellSize, MovedKeyframesFuseToTheBitAsFromScratch) {
  Rng rng(1);
  GlobalMap global(GetParam());
  std::vector<Pose2> poses;
  std::vector<PlacedGrid> placed;
  for (int i = 0; i < 20; ++i) {
    placed.push_back({random_crop(rng), random_pose(rng)});
    poses.push_back(placed.back().T_map_keyframe);
    EXPECT_EQ(global.add(placed.back().grid, placed.back().T_map_keyframe), i);
  }
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < poses.size(); i += 2) {
      poses[i] = random_pose(rng);
      placed[i].T_map_keyframe = poses[i];
    }
    global.move(poses);
    EXPECT_EQ(global.waiting(), 10);
    EXPECT_EQ(global.refuse(7), 3);
    EXPECT_EQ(global.refuse(7), 0);
  }
  const OccupancyMap moved = global.map();
  const OccupancyMap scratch = fuse(placed, GetParam());
  ASSERT_EQ(moved.columns, scratch.columns);
  ASSERT_EQ(moved.rows, scratch.rows);
  EXPECT_EQ(moved.origin, scratch.origin);
  EXPECT_EQ(moved.cells, scratch.cells);
}

TEST_P(EveryCellSize, AThinWallNeitherVanishesNorLeaks) {
  // free floor on both sides of a wall two grid cells thick, seen at several headings
  for (const double theta_rad : {0.0, 0.4, 0.785, 1.9}) {
    const auto crop = crop_of(Vec2(0, 0), Vec2(2, 1),
                              [](double x, double) { return std::abs(x - 1) < 0.01 ? -60 : 60; });
    const Pose2 T{0.013, -0.021, theta_rad};
    const OccupancyMap map = fuse(std::vector<PlacedGrid>{{crop, T}}, GetParam());
    // free floor on one side is not joined to that on the other
    std::vector<std::pair<int, int>> open;
    std::vector<std::uint8_t> met(map.cells.size(), 0);
    const auto visit = [&](int column, int row) {
      if (map.at(column, row) == Cell::kFree) {
        std::uint8_t& m = met[static_cast<std::size_t>(row * map.columns + column)];
        if (m == 0) {
          m = 1;
          open.emplace_back(column, row);
        }
      }
    };
    const auto cell_of = [&](const Vec2& p) {
      const Vec2 at = (p - map.origin) / map.cell_m;
      return std::pair(static_cast<int>(at.x()), static_cast<int>(at.y()));
    };
    const auto [column, row] = cell_of(T * Vec2(0.5, 0.5));
    visit(column, row);
    while (!open.empty()) {
      const auto [c, r] = open.back();
      open.pop_back();
      visit(c + 1, r);
      visit(c - 1, r);
      visit(c, r + 1);
      visit(c, r - 1);
    }
    // away from the wall by more than a cell's diagonal the floor is free
    const double away = 1.5 * GetParam() + 0.01;
    for (double y = 0.2; y < 0.8; y += 0.01) {
      const auto [c0, r0] = cell_of(T * Vec2(1 - away, y));
      const auto [c1, r1] = cell_of(T * Vec2(1 + away, y));
      EXPECT_EQ(met[static_cast<std::size_t>(r0 * map.columns + c0)], 1);
      EXPECT_EQ(map.at(c1, r1), Cell::kFree);
      EXPECT_EQ(met[static_cast<std::size_t>(r1 * map.columns + c1)], 0);
    }
  }
}

TEST_P(EveryCellSize, LeavesNoHoles) {
  const auto crop = crop_of(Vec2(0, 0), Vec2(2, 1), [](double, double) { return 50; });
  const Pose2 T{0.3, 0.2, 0.5};
  const OccupancyMap map = fuse(std::vector<PlacedGrid>{{crop, T}}, GetParam());
  const double inset = GetParam();
  for (double x = inset; x < 2 - inset; x += 0.01) {
    for (double y = inset; y < 1 - inset; y += 0.01) {
      ASSERT_EQ(map.at(T * Vec2(x, y)), Cell::kFree);
    }
  }
  EXPECT_NEAR(map.area_m2(Cell::kFree), 2, 6 * GetParam());  // a cell along the outline
}

// A wall across the way that the body takes along x, from -0.2 to 0.2 m.
std::shared_ptr<const GridCrop> driven_through_a_wall() {
  auto crop = std::make_shared<GridCrop>(
      *crop_of(Vec2(-1, -1), Vec2(1, 1), [](double x, double) { return x < 0.1 ? 60 : -100; }));
  crop->body_radius_m = 0.25;
  for (int k = -10; k <= 10; ++k) {
    crop->traversed.emplace_back(0.02 * k, 0);
  }
  return crop;
}

TEST_P(EveryCellSize, WhatTheBodyHasDrivenThroughIsFreeAndNothingBesideIt) {
  const auto wall = crop_of(Vec2(-1, -1), Vec2(1, 1), [](double, double) { return -100; });
  const Pose2 T{0.013, -0.021, 0.7};
  const auto crop = driven_through_a_wall();
  // five other keyframes saw nothing but walls there, before and after
  const OccupancyMap map = fuse(
      std::vector<PlacedGrid>{{wall, T}, {wall, T}, {crop, T}, {wall, T}, {wall, T}, {wall, T}},
      GetParam());
  const double cell_m = 1.5 * GetParam();
  for (double x = -0.5; x <= 0.5; x += 0.01) {
    for (double y = -0.5; y <= 0.5; y += 0.01) {
      const double distance_m = (Vec2(x, y) - Vec2(std::clamp(x, -0.2, 0.2), 0)).norm();
      if (distance_m < crop->body_radius_m - cell_m) {
        ASSERT_EQ(map.at(T * Vec2(x, y)), Cell::kFree) << x << " " << y;
      } else if (distance_m > crop->body_radius_m) {
        ASSERT_EQ(map.at(T * Vec2(x, y)), Cell::kOccupied) << x << " " << y;
      }
    }
  }
}

TEST_P(EveryCellSize, WhatWasDrivenThroughMovesToTheBitAsFromScratch) {
  Rng rng(3);
  GlobalMap global(GetParam());
  std::vector<PlacedGrid> placed;
  std::vector<Pose2> poses;
  for (int i = 0; i < 8; ++i) {
    auto crop = std::make_shared<GridCrop>(*random_crop(rng));
    crop->body_radius_m = 0.25;
    for (int k = 0; k < 5; ++k) {  // beyond what was seen as well
      crop->traversed.emplace_back(rng.uniform(-1, 1), rng.uniform(-1, 1));
    }
    placed.push_back({crop, random_pose(rng)});
    global.add(crop, placed.back().T_map_keyframe);
  }
  for (PlacedGrid& grid : placed) {
    grid.T_map_keyframe = random_pose(rng);
    poses.push_back(grid.T_map_keyframe);
  }
  global.move(poses);
  global.refuse(8);
  const OccupancyMap moved = global.map();
  const OccupancyMap scratch = fuse(placed, GetParam());
  EXPECT_EQ(moved.origin, scratch.origin);
  EXPECT_EQ(moved.columns, scratch.columns);
  EXPECT_EQ(moved.cells, scratch.cells);
}

INSTANTIATE_TEST_SUITE_P(Metres, EveryCellSize, testing::Values(0.01, 0.02, 0.05, 0.1));

TEST_P(EveryCellSize, AReplacedGridFusesToTheBitAsFromScratch) {
  Rng rng(29);
  GlobalMap global(GetParam());
  std::vector<PlacedGrid> placed;
  for (int i = 0; i < 12; ++i) {
    placed.push_back({random_crop(rng), random_pose(rng)});
    global.add(placed.back().grid, placed.back().T_map_keyframe);
  }
  for (const int k : {3, 7, 3}) {
    placed[static_cast<std::size_t>(k)].grid = random_crop(rng);
    global.replace(k, placed[static_cast<std::size_t>(k)].grid);
  }
  const PlacedGrid open{random_crop(rng), random_pose(rng)};
  const OccupancyMap replaced = global.map_with(open);
  placed.push_back(open);
  const OccupancyMap fresh = fuse(placed, GetParam());
  EXPECT_EQ(replaced.origin, fresh.origin);
  EXPECT_EQ(replaced.cells, fresh.cells);
}

TEST(GlobalMap, LeavesAloneWhatMovedByLessThanHalfACell) {
  Rng rng(2);
  GlobalMap global(0.05);
  global.add(random_crop(rng), {1, 2, 0.5});
  global.move(std::vector<Pose2>{{1.02, 2, 0.5}});
  EXPECT_EQ(global.waiting(), 0);
  global.move(std::vector<Pose2>{{1.03, 2, 0.5}});
  EXPECT_EQ(global.waiting(), 1);
  global.move(std::vector<Pose2>{{1, 2, 0.55}});  // the far edge moves by more than half a cell
  EXPECT_EQ(global.waiting(), 1);
}

TEST(GlobalMap, ANearerLookWinsOverAnEarlierFarOne) {
  GlobalMap global(0.05);
  const auto far = crop_of(Vec2(0, 0), Vec2(0.5, 0.5), [](double, double) { return -20; });
  const auto near = crop_of(Vec2(0, 0), Vec2(0.5, 0.5), [](double, double) { return 100; });
  global.add(far, {});
  EXPECT_EQ(global.map().at(Vec2(0.25, 0.25)), Cell::kOccupied);
  global.add(near, {});
  global.add(near, {});
  EXPECT_EQ(global.map().at(Vec2(0.25, 0.25)), Cell::kFree);
}

TEST(LocalMap, KeepsTheLastFewAndTheOpenOne) {
  LocalMap local(0.02, 3.5, 2);
  const auto patch = crop_of(Vec2(0, 0), Vec2(0.2, 0.2), [](double, double) { return 50; });
  for (int i = 0; i < 3; ++i) {
    local.close(patch, {1.0 * i, 0, 0});
  }
  KeyframeGrid open;
  open.add_free_disc(Vec2::Zero(), 0.2);
  const OccupancyMap map = local.map(open, {3, 0, 0}, Vec2(2, 0));
  EXPECT_EQ(map.at(Vec2(0.1, 0.1)), Cell::kUnknown);
  EXPECT_EQ(map.at(Vec2(1.1, 0.1)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(2.1, 0.1)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(3.1, 0.1)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(3.5, 0.1)), Cell::kUnknown);
  EXPECT_EQ(map.columns, 350);
  EXPECT_EQ(map.rows, 350);
  // asked again it says the same: the open keyframe leaves nothing behind
  EXPECT_EQ(local.map(open, {3, 0, 0}, Vec2(2, 0)).cells, map.cells);
}

TEST(LocalMap, WhoStepsInBehindTheBodyIsSeenThere) {
  LocalMap local(0.02, 3.5, 2);
  local.close(driven_through_a_wall(), {});
  const OccupancyMap map = local.map(KeyframeGrid(), {}, Vec2(0, 0));
  EXPECT_EQ(map.at(Vec2(0.15, 0.01)), Cell::kOccupied);
  EXPECT_EQ(map.at(Vec2(-0.15, 0.01)), Cell::kFree);
}

TEST(Fuse, OfNothingIsEmpty) {
  EXPECT_EQ(fuse({}, 0.01).columns, 0);
  EXPECT_EQ(GlobalMap(0.01).map().rows, 0);
}

}  // namespace
}  // namespace panoptes

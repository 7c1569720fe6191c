// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/shadows.h"

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

/// All that lies within 3 m of (1.5, 0) is free to a camera over the origin that looks along x.
PlacedGrid free_floor(const Pose2& T_map_keyframe,
                      const std::vector<StandingPoint>& standing = {}) {
  KeyframeGrid grid;
  grid.add_free_disc(Vec2(1.5, 0), 1.4);
  auto crop = std::make_shared<GridCrop>(grid.crop());
  crop->cameras = {{Vec2(0, 0), 0.6, 0, 1}};
  crop->standing = standing;
  return {crop, T_map_keyframe};
}

int at(const PlacedGrid& grid, const Vec2& p) {
  const double cell_m = grid.grid->cell_m;
  return grid.grid->at(static_cast<int>(std::floor(p.x() / cell_m)),
                       static_cast<int>(std::floor(p.y() / cell_m)));
}

const StandingPoint kPost{Vec2(1.5, 0), 0.5};

TEST(Shadows, WhatTwoSightingsAgreeOnHidesTheFloorFromEveryKeyframe) {
  // The second keyframe, a metre to the left, looks across; the third found the post.
  const Pose2 T_map_second{1.5, -1.5, deg_to_rad(90)};
  const std::vector<PlacedGrid> grids = {free_floor({}), free_floor(T_map_second),
                                         free_floor({}, {kPost, kPost})};
  const std::vector<PlacedGrid> out = without_shadows(grids);
  ASSERT_EQ(out.size(), 3U);
  EXPECT_GT(at(out[0], Vec2(1.45, 0)), 0) << "before it";
  EXPECT_EQ(at(out[0], Vec2(1.7, 0)), 0) << "behind it";
  EXPECT_GT(at(out[0], Vec2(1.7, 0.2)), 0) << "beside it";
  EXPECT_EQ(at(out[1], Vec2(1.7, 0)), 0) << "in its own frame as well";
  EXPECT_GT(at(grids[0], Vec2(1.7, 0)), 0) << "the grids themselves stay";
}

TEST(Shadows, OneSightingHidesNothing) {
  const std::vector<PlacedGrid> out =
      without_shadows(std::vector<PlacedGrid>{free_floor({}, {kPost}), free_floor({})});
  EXPECT_GT(at(out[1], Vec2(1.7, 0)), 0);
}

TEST(Shadows, NothingStandsWhereTheBodyHasBeenSinceOrBefore) {
  PlacedGrid driven = free_floor({});
  auto crop = std::make_shared<GridCrop>(*driven.grid);
  crop->traversed = {Vec2(1.4, 0.1)};
  crop->body_radius_m = 0.25;
  driven.grid = crop;
  const std::vector<PlacedGrid> out =
      without_shadows(std::vector<PlacedGrid>{free_floor({}, {kPost, kPost}), driven});
  EXPECT_GT(at(out[0], Vec2(1.7, 0)), 0);
}

TEST(Shadows, NoGridsMakeNone) { EXPECT_TRUE(without_shadows({}).empty()); }

}  // namespace
}  // namespace panoptes

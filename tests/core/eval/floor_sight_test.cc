// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/floor_sight.h"

#include <numeric>

#include <gtest/gtest.h>

#include "core/map/floor_projection.h"

namespace panoptes {
namespace {

constexpr CameraSet kFirst = camera_bit(0);
constexpr double kResolution_m = 1e-3;

Rig floor_rig(double height_m, double ahead_m, double tilt_deg, FloorView view = {}) {
  RigCamera camera;
  camera.roles = {"floor"};
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera({ahead_m, 0, height_m}, 0, deg_to_rad(tilt_deg));
  camera.floor = view;
  Rig rig;
  rig.cameras["floor"] = camera;
  return rig;
}

// Table 7.1's tilts. The rig that the thesis's near and far ranges, gaps and areas fit: both
// cameras level with the axis, the lower half of the picture mapped, up to 4.5 m away.
TEST(FloorSight, HasTheGapsAndAreasOfTheThesisRig) {
  constexpr double kTilts_deg[] = {0, 5, 10, 15, 20, 25, 30};
  constexpr double kGap_m[] = {1.00, 0.78, 0.61, 0.47, 0.35, 0.25, 0.15};
  constexpr double kSeen_m2[] = {12.8, 13.5, 14.0, 7.5, 4.2, 2.7, 1.9};
  constexpr double kWithin = 0.1;
  for (int i = 0; i < 7; ++i) {
    FloorView view;
    view.rows = FloorView::Rows::kLowerHalf;
    view.near_m = 0;
    view.far_m = 10;
    const RigSight sight(floor_rig(0.78, 0, kTilts_deg[i], view), Body());
    const auto gap_m = first_seen_m(sight, kFirst, true, 0, 4.5);
    ASSERT_TRUE(gap_m.has_value()) << kTilts_deg[i];
    EXPECT_NEAR(*gap_m, kGap_m[i], kWithin * kGap_m[i]) << kTilts_deg[i];
    const FloorSight floor = floor_sight({4.5, 0.03}, sight);
    EXPECT_NEAR(area_m2(floor, floor.mapped, kFirst), kSeen_m2[i], kWithin * kSeen_m2[i])
        << kTilts_deg[i];
  }
}

TEST(FloorSight, IsWhatTheMapperMaps) {
  for (const double tilt_deg : {20.0, 28.0, 45.0}) {
    const Rig rig = floor_rig(0.75, 0.02, tilt_deg);
    const FloorProjection mapper = project_floor(rig.cameras.at("floor"), Body());
    const auto cells = std::count_if(mapper.sample.begin(), mapper.sample.end(),
                                     [](std::int32_t sample) { return sample >= 0; });
    const double mapper_m2 = static_cast<double>(cells) * mapper.cell_m * mapper.cell_m;
    const RigSight sight(rig, Body());
    const FloorSight floor = floor_sight({6, 0.05}, sight);
    EXPECT_NEAR(area_m2(floor, floor.mapped, kFirst), mapper_m2, 0.03 * mapper_m2) << tilt_deg;
    EXPECT_NEAR(first_seen_m(sight, kFirst, true, 0, 6).value_or(0), mapper.blind_zone_m,
                mapper.cell_m)
        << tilt_deg;
  }
}

TEST(FloorSight, HasTheAreaOfATrapezoid) {
  Body low;
  low.hull_height_m = 0;  // the picture's lower edge is all that bounds it
  const RigSight sight(floor_rig(0.75, 0.02, 30), low);
  const double f_px = pinhole(320, 240, deg_to_rad(80)).fx_px;
  const double half_down = std::atan(120 / f_px);
  const double near_m = 0.75 / std::tan(deg_to_rad(30) + half_down);
  const auto width_m = [&](double x) {  // of the picture, at a distance from the camera's foot
    return 2 * (160 / f_px) * (x * std::cos(deg_to_rad(30)) + 0.75 * std::sin(deg_to_rad(30)));
  };
  const double far_m = 2.5;
  double expected_m2 = (far_m - near_m) * (width_m(near_m) + width_m(far_m)) / 2;
  FloorSight floor = floor_sight({6, 0.02}, sight);
  for (int row = 0; row < floor.side; ++row) {
    for (int column = 0; column < floor.side; ++column) {
      if (floor.centre(column, row).x() > far_m + 0.02) {
        floor.seen[static_cast<std::size_t>(row * floor.side + column)] = 0;
      }
    }
  }
  EXPECT_NEAR(area_m2(floor, floor.seen, kFirst), expected_m2, 0.01 * expected_m2);
}

TEST(FloorSight, HidesTheFloorBehindTheHull) {
  Body body;
  const Rig rig = floor_rig(0.45, 0, 60, {FloorView::Rows::kAll, 0, 3, {}, {}});
  const RigSight sight(rig, body);
  // the line over the hull's edge: 0.25 m out, 0.24 m up, from 0.45 m
  const double edge_m = 0.25 * 0.45 / (0.45 - 0.24) - 0.25;
  EXPECT_NEAR(first_seen_m(sight, kFirst, false, 0, 4).value_or(0), edge_m, kResolution_m);
  body.hull_height_m = 0.1;
  const RigSight over(rig, body);
  EXPECT_LT(first_seen_m(over, kFirst, false, 0, 4).value_or(9), edge_m);
}

TEST(FloorSight, OfMoreCamerasIsNeverLess) {
  Rig rig = floor_rig(0.75, 0.02, 28);
  const RigSight one(rig, Body());
  rig.cameras["left"] = rig.cameras["floor"];
  rig.cameras["left"].T_body_camera = mounted_camera({0, 0.2, 0.6}, deg_to_rad(90), 0.5);
  const RigSight two(rig, Body());
  const FloorSight before = floor_sight({}, one);
  const FloorSight after = floor_sight({}, two);
  EXPECT_GT(area_m2(after, after.seen, ~CameraSet{0}), area_m2(before, before.seen, kFirst));
  EXPECT_EQ(area_m2(after, after.seen, kFirst), area_m2(before, before.seen, kFirst));
  for (const double height_m : {0.0, 0.24, 0.8}) {
    EXPECT_LE(blind_spot(two, height_m, 2, 4.5).share, blind_spot(one, height_m, 2, 4.5).share);
  }
}

TEST(FloorSight, SumsUpItsRings) {
  const RigSight sight(floor_rig(0.75, 0.02, 28), Body());
  const FloorSight floor = floor_sight({}, sight);
  const double radius_m = Body().radius_m;
  double sum_m2 = 0;
  double from_m = 0;
  for (const double to_m : {1.0, 2.0, 4.25}) {
    const double ring_m2 = M_PI * (std::pow(radius_m + to_m, 2) - std::pow(radius_m + from_m, 2));
    sum_m2 += ring_share(floor, floor.seen, kFirst, radius_m, from_m, to_m) * ring_m2;
    from_m = to_m;
  }
  const double all_m2 = area_m2(floor, floor.seen, kFirst);
  EXPECT_NEAR(sum_m2, all_m2, 0.02 * all_m2);
}

TEST(SamplingAt, IsCoarserFartherAway) {
  const RigSight sight(floor_rig(0.75, 0.02, 28), Body());
  double before_m = 0;
  for (const double distance_m : {0.5, 1.0, 2.0, 2.9}) {
    const SamplingAt at = sampling_at(sight, kFirst, true, distance_m);
    ASSERT_TRUE(at.median_m && at.worst_m);
    EXPECT_GT(*at.median_m, before_m);
    EXPECT_GE(*at.worst_m, *at.median_m);
    before_m = *at.worst_m;
  }
  const SamplingAt beyond = sampling_at(sight, kFirst, true, 4.5);
  EXPECT_EQ(beyond.seen_share, 0);
  EXPECT_FALSE(beyond.median_m.has_value());
}

TEST(SmallestObstacle, CoversItsPixels) {
  const RigSight sight(floor_rig(0.75, 0.25, 30), Body());
  const Intrinsics lens = pinhole(320, 240, deg_to_rad(80));
  const double distance_m = 1.0;
  const double size_m = smallest_obstacle_m(sight, distance_m, 3).value_or(0);
  ASSERT_GT(size_m, 0);
  const CameraSight& camera = sight.cameras()[0];
  const auto px = [&](double y, double z) {
    return lens.project(camera.in_camera({0.25 + distance_m, y, z}));
  };
  const double wide_px = std::abs(px(size_m / 2, 0).x() - px(-size_m / 2, 0).x());
  const double high_px = std::abs(px(0, size_m).y() - px(0, 0).y());
  EXPECT_NEAR(std::min(wide_px, high_px), 3, 0.1);  // it is not infinitely small
  EXPECT_FALSE(smallest_obstacle_m(sight, 5, 3).has_value());
  EXPECT_FALSE(smallest_obstacle_m(sight, 0.1, 3).has_value());
}

TEST(BlindAhead, OverTheWidthIsNoShorter) {
  // It looks past the right side of the body.
  Rig rig = floor_rig(0.75, 0.1, 40, {FloorView::Rows::kAll, 0, 3, {}, {}});
  rig.cameras["floor"].T_body_camera =
      mounted_camera({0.1, 0, 0.75}, deg_to_rad(-25), deg_to_rad(40));
  const RigSight sight(rig, Body());
  const double ahead_m = first_seen_m(sight, kFirst, false, 0, 4.5).value_or(0);
  const double over_width_m = first_seen_over_width_m(sight, kFirst, false, 4.5).value_or(0);
  EXPECT_GT(over_width_m, ahead_m + 0.05);
  rig.cameras["floor"].T_body_camera = mounted_camera({0.1, 0, 0.75}, deg_to_rad(180), 0.5);
  EXPECT_FALSE(first_seen_over_width_m(RigSight(rig, Body()), kFirst, false, 4.5).has_value());
}

TEST(LastSeen, IsWhereTheMappedPartEnds) {
  const RigSight sight(floor_rig(0.75, 0.02, 28), Body());
  EXPECT_NEAR(last_seen_m(sight, kFirst, true, 4.5).value_or(0), 3.0, kResolution_m);
  EXPECT_NEAR(last_seen_m(sight, kFirst, false, 4.5).value_or(0), 4.25, kResolution_m);
}

}  // namespace
}  // namespace panoptes

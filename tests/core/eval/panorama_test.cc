// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/panorama.h"

#include <numbers>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr CameraSet kAll = ~CameraSet{0};
constexpr int kOpposite = PanoramaSight::kHeadings / 2;

Rig rig_of(const std::vector<std::pair<double, double>>& yaws_and_tilts_deg) {
  Rig rig;
  for (const auto& [yaw_deg, tilt_deg] : yaws_and_tilts_deg) {
    const double height_m = 0.5 + 0.05 * static_cast<double>(rig.cameras.size());
    RigCamera& camera = rig.cameras["camera" + std::to_string(rig.cameras.size())];
    camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
    camera.T_body_camera =
        mounted_camera({0, 0, height_m}, deg_to_rad(yaw_deg), deg_to_rad(tilt_deg));
  }
  return rig;
}

PanoramaSight panorama_of(const Rig& rig) { return panorama_sight(RigSight(rig, Body())); }

TEST(Panorama, OfFrontAndBackIsTheSameTurnedRound) {
  const PanoramaSight both = panorama_of(rig_of({{0, 0}, {180, 0}}));
  const double seen = common_share(both, kAll, 0);
  EXPECT_GT(seen, 0.2);
  EXPECT_DOUBLE_EQ(common_share(both, kAll, kOpposite), seen);
  EXPECT_LT(common_share(both, kAll, kOpposite / 2), 0.1 * seen);
  const PanoramaSight front = panorama_of(rig_of({{0, 0}}));
  EXPECT_NEAR(common_share(front, kAll, 0), seen / 2, 1e-3);
  EXPECT_EQ(common_share(front, kAll, kOpposite), 0);
}

TEST(Panorama, HasAsMuchInCommonEitherWayRound) {
  const PanoramaSight odd = panorama_of(rig_of({{0, 5}, {110, -10}, {200, 0}}));
  for (int turned = 1; turned < PanoramaSight::kHeadings; ++turned) {
    EXPECT_DOUBLE_EQ(common_share(odd, kAll, turned),
                     common_share(odd, kAll, PanoramaSight::kHeadings - turned));
  }
}

TEST(Panorama, IsLessOfACameraThatLooksAtTheFloor) {
  double before = 1;
  for (const double tilt_deg : {0.0, 10.0, 20.0, 30.0}) {
    const double seen =
        common_share(panorama_of(rig_of({{0, tilt_deg}, {180, tilt_deg}})), kAll, kOpposite);
    EXPECT_LT(seen, before) << tilt_deg;
    before = seen;
  }
}

TEST(Panorama, OfACameraThatLooksUpIsTheSameAtAnyHeading) {
  Rig rig = rig_of({{0, -90}});
  rig.cameras.begin()->second.intrinsics = lens_of_view(320, 320, deg_to_rad(150), Equidistant());
  const PanoramaSight up = panorama_of(rig);
  const double seen = common_share(up, kAll, 0);
  EXPECT_DOUBLE_EQ(common_share(up, kAll, kOpposite), seen);
  for (int turned = 0; turned < PanoramaSight::kHeadings; ++turned) {
    EXPECT_GT(common_share(up, kAll, turned), 0.85 * seen);  // but for the picture's corners
  }
}

TEST(Overlap, HasTheSolidAngleOfAPinhole) {
  const Rig rig = rig_of({{0, -10}});
  const Intrinsics& lens = rig.cameras.begin()->second.intrinsics;
  const double a = std::atan(160 / lens.fx_px);
  const double b = std::atan(120 / lens.fy_px);
  const double share = 4 * std::asin(std::sin(a) * std::sin(b)) / (4 * std::numbers::pi);
  constexpr double kDirections = 4000;
  EXPECT_NEAR(overlap_sight(RigSight(rig, Body())).seen_share, share, 20 / kDirections);
}

TEST(Overlap, IsOfCamerasThatLookTheSameWay) {
  const OverlapSight apart = overlap_sight(RigSight(rig_of({{0, 0}, {180, 0}}), Body()));
  EXPECT_TRUE(apart.overlaps.empty());
  EXPECT_EQ(apart.twice_share, 0);
  const OverlapSight same = overlap_sight(RigSight(rig_of({{0, 0}, {0, 0}}), Body()));
  ASSERT_EQ(same.overlaps.size(), 1U);
  EXPECT_GT(same.overlaps[0].share, 0.9);  // the hull is not at the same place in both
  const OverlapSight some = overlap_sight(RigSight(rig_of({{0, 0}, {40, 0}}), Body()));
  ASSERT_EQ(some.overlaps.size(), 1U);
  EXPECT_NEAR(some.overlaps[0].share, 0.5, 0.1);
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_sight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

RigCamera camera_at(const Vec3& eye_body, double yaw_deg, double tilt_deg) {
  RigCamera camera;
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera(eye_body, deg_to_rad(yaw_deg), deg_to_rad(tilt_deg));
  return camera;
}

RigCamera floor_camera(double tilt_deg) {
  RigCamera camera = camera_at({0.02, 0, 0.75}, 0, tilt_deg);
  camera.roles = {"floor"};
  camera.floor.emplace();
  return camera;
}

TEST(HiddenByHull, IsWhatALineThroughTheCylinderIs) {
  const Body body;
  Rng rng(3);
  constexpr int kSteps = 2000;
  constexpr double kGrazing_m = 2e-3;  // what the steps may miss
  int hidden = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 a(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0, 1));
    const Vec3 b(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0, 1));
    double deepest_m = -1;
    for (int k = 0; k <= kSteps; ++k) {
      const Vec3 p = a + (b - a) * (static_cast<double>(k) / kSteps);
      deepest_m = std::max(
          deepest_m, std::min(body.radius_m - p.head<2>().norm(), body.hull_height_m - p.z()));
    }
    if (std::abs(deepest_m) > kGrazing_m) {
      EXPECT_EQ(hidden_by_hull(body, a, b), deepest_m > 0) << a.transpose() << " " << b.transpose();
      EXPECT_EQ(hidden_by_hull(body, b, a), hidden_by_hull(body, a, b));
      hidden += deepest_m > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(hidden, 30);
}

TEST(CameraSight, DoesNotSeeThroughItsOwnRobot) {
  Body body;
  const CameraSight behind(camera_at({0, 0, 0.5}, 0, 60), body);
  // From the axis, half a metre up, the line over the hull's edge meets the floor 0.48 m out.
  EXPECT_FALSE(behind.sees({0.47, 0, 0}));
  EXPECT_TRUE(behind.sees({0.49, 0, 0}));
  EXPECT_GT(behind.hull_share(), 0.1);
  body.hull_height_m = 0;
  const CameraSight free(camera_at({0, 0, 0.5}, 0, 60), body);
  EXPECT_TRUE(free.sees({0.47, 0, 0}));
  EXPECT_EQ(free.hull_share(), 0);
}

TEST(CameraSight, MapsTheLowerHalfWhereItSaysSo) {
  RigCamera camera = floor_camera(20);
  camera.floor->far_m = 10;
  const CameraSight whole(camera, Body());
  camera.floor->rows = FloorView::Rows::kLowerHalf;
  const CameraSight half(camera, Body());
  const double axis_m = 0.02 + 0.75 / std::tan(deg_to_rad(20));
  EXPECT_TRUE(half.maps({axis_m - 0.05, 0}));
  EXPECT_FALSE(half.maps({axis_m + 0.05, 0}));
  EXPECT_TRUE(whole.maps({axis_m + 0.05, 0}));
}

TEST(CameraSight, MapsOfABentPictureWhatIsLeftOfItStraightened) {
  RigCamera camera = floor_camera(40);
  camera.intrinsics = lens_of_view(320, 240, deg_to_rad(150), Equidistant());
  const CameraSight fisheye(camera, Body());
  const Vec2 aside(0.3, 1.5);  // more than 55 degrees off the axis
  EXPECT_TRUE(fisheye.sees({aside.x(), aside.y(), 0}));
  EXPECT_FALSE(fisheye.maps(aside));
  EXPECT_TRUE(fisheye.maps({0.9, 0}));
}

TEST(CameraSight, SamplesTheFloorAsAPinholeDoes) {
  RigCamera camera = camera_at({0, 0, 0.8}, 0, 0);
  const CameraSight sight(camera, Body());
  const double f_px = camera.intrinsics.fx_px;
  constexpr double kDifference = 1e-3;  // of a step of 0.1 mm, relative
  for (const double x : {1.5, 2.0, 3.0, 4.0}) {
    EXPECT_NEAR(sight.sampling_m({x, 0}), x * x / (f_px * 0.8), kDifference * x);
  }
}

TEST(PlacementFaults, AreToldForEachCamera) {
  Rig rig;
  rig.cameras["a_inside"] = camera_at({0.1, 0, 0.2}, 0, 0);
  rig.cameras["b_below"] = camera_at({0.3, 0, -0.05}, 0, 0);
  rig.cameras["c_down"] = camera_at({0, 0, 0.3}, 0, 90);
  rig.cameras["d_sky"] = floor_camera(-60);
  rig.cameras["e_good"] = camera_at({0.1, 0, 0.6}, 0, 0);
  rig.cameras["f_twice"] = camera_at({0.11, 0, 0.6}, 90, 0);
  rig.cameras["g_high"] = camera_at({0, 0, 1.5}, 0, 0);
  rig.cameras["h_out"] = camera_at({0.8, 0, 0.5}, 0, 0);
  rig.cameras["c_down"].intrinsics = pinhole(320, 240, deg_to_rad(40));
  EXPECT_THAT(
      placement_faults(rig, Body()),
      ElementsAre(
          "cameras.a_inside: is mounted inside the robot, whose hull is 0.240 m high and reaches "
          "0.250 m from its middle; mount it above or farther out",
          "cameras.b_below: is mounted 0.050 m below the floor; mount it above",
          "cameras.c_down: sees nothing but the robot's own hull; turn it outwards or mount it "
          "nearer to the edge",
          "cameras.d_sky: has the role floor and sees no floor from 0.2 to 3 m before the body; "
          "tilt it down, or correct floor.near_m and floor.far_m",
          "cameras.f_twice: has its centre 10 mm from that of e_good, in whose housing it would "
          "be; mount them 20 mm apart or more",
          HasSubstr("cameras.g_high: is mounted 1.500 m high"),
          HasSubstr("cameras.h_out: is mounted 0.800 m from the robot's middle")));
  EXPECT_THAT(placement_faults(Rig(), Body()), ElementsAre("cameras: must have one at least"));
}

TEST(PlacementFaults, AreNoneOfAUsualRig) {
  Rig rig;
  rig.cameras["front"] = camera_at({0, 0, 0.79}, 0, 0);
  rig.cameras["back"] = camera_at({0, 0, 0.71}, 180, 0);
  rig.cameras["floor"] = floor_camera(28);
  EXPECT_THAT(placement_faults(rig, Body()), IsEmpty());
}

}  // namespace
}  // namespace panoptes

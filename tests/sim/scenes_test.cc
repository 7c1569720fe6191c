// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/config/geometry_fields.h"
#include "sim/sensors/floor_pixels.h"

namespace panoptes::sim {
namespace {

const std::string kScenes = PANOPTES_SOURCE_DIR "/scenes/";

TEST(Scenes, ThePioneersRigHasTheGeometryOfItsComments) {
  const Body body = read_settings<Body>(kScenes + "robots/pioneer3dx.yaml");
  const Rig rig = read_settings<Rig>(kScenes + "rigs/front-back-floor.yaml");
  EXPECT_EQ(rig.with_role("loop_front"), "front");
  EXPECT_EQ(rig.with_role("loop_back"), "back");
  EXPECT_EQ(rig.with_role("floor"), "floor");
  for (const auto& [name, camera] : rig.cameras) {
    EXPECT_LE(camera.T_body_camera.translation.z(), body.height_m) << name;
  }
  const Vec3 back_axis = rig.cameras.at("back").T_body_camera.rotation * Vec3::UnitZ();
  EXPECT_NEAR(back_axis.x(), -1, 1e-12);

  const RigCamera& floor = rig.cameras.at("floor");
  constexpr double kWritten_m = 0.005;  // to as many digits
  const auto ahead_m = [&](double row_px) {
    return floor_under(floor, {floor.intrinsics.cx_px, row_px})->x() - body.radius_m;
  };
  const double gap_m = ahead_m(floor.intrinsics.height_px - 0.5);
  EXPECT_NEAR(gap_m, 0.20, kWritten_m);
  EXPECT_LT(body.radius_m + gap_m + 0.10, 0.7) << "what is assumed free lies in what is clear";
  EXPECT_LT(ahead_m(69), floor.floor->far_m);
  EXPECT_GT(ahead_m(68), floor.floor->far_m);
}

TEST(Scenes, TheRigOnTheEdgesHasTheGeometryOfItsComments) {
  const Body body = read_settings<Body>(kScenes + "robots/pioneer3dx.yaml");
  const Rig rig = read_settings<Rig>(kScenes + "rigs/front-back-edges.yaml");
  EXPECT_EQ(rig.with_role("loop_front"), "front");
  EXPECT_EQ(rig.with_role("loop_back"), "back");
  EXPECT_EQ(rig.with_role("floor"), "floor");
  for (const auto& [name, camera] : rig.cameras) {
    const Vec3& eye_body = camera.T_body_camera.translation;
    EXPECT_LE(eye_body.z(), body.height_m) << name;
    EXPECT_GE(eye_body.z(), body.hull_height_m) << name;
    EXPECT_NEAR(std::abs(eye_body.x()), 0.2, 1e-12) << name;
  }
  const RigCamera& floor = rig.cameras.at("floor");
  constexpr double kWritten_m = 0.005;  // to as many digits
  const auto ahead_m = [&](double row_px) {
    return floor_under(floor, {floor.intrinsics.cx_px, row_px})->x() - body.radius_m;
  };
  EXPECT_NEAR(ahead_m(floor.intrinsics.height_px - 0.5), 0.19, kWritten_m);
  EXPECT_LE(ahead_m(floor.intrinsics.height_px - 0.5), floor.floor->near_m);
  EXPECT_LT(ahead_m(32), floor.floor->far_m);
  EXPECT_GT(ahead_m(31), floor.floor->far_m);
}

TEST(Scenes, TheRigThatLooksAsideHasACameraOnEitherSide) {
  const Rig rig = read_settings<Rig>(kScenes + "rigs/left-right-floor.yaml");
  const Pose3& left = rig.cameras.at(rig.with_role("loop_left")).T_body_camera;
  const Pose3& right = rig.cameras.at(rig.with_role("loop_right")).T_body_camera;
  EXPECT_NEAR((left.rotation * Vec3::UnitZ()).y(), 1, 1e-12);
  EXPECT_NEAR((right.rotation * Vec3::UnitZ()).y(), -1, 1e-12);
  EXPECT_EQ(left.translation.y(), -right.translation.y());
  EXPECT_FALSE(rig.with_role("floor").empty());
}

TEST(Scenes, RigsOfOneCameraAndOfFourAreOutsideOfTheBody) {
  const Body body = read_settings<Body>(kScenes + "robots/pioneer3dx.yaml");
  for (const auto& [file, cameras] :
       {std::pair("front-alone", 1), std::pair("fisheye-up", 1), std::pair("four-corners", 4)}) {
    const Rig rig = read_settings<Rig>(kScenes + "rigs/" + file + ".yaml");
    EXPECT_FALSE(rig.with_role("floor").empty()) << file;
    int loop = 0;
    for (const auto& [name, camera] : rig.cameras) {
      loop += camera.is_loop() ? 1 : 0;
      const Vec3& eye_body = camera.T_body_camera.translation;
      EXPECT_LE(eye_body.z(), body.height_m) << file << " " << name;
      EXPECT_GE(eye_body.z(), body.hull_height_m) << file << " " << name;
    }
    EXPECT_EQ(loop, cameras) << file;
  }
}

TEST(Scenes, TheRigOfFourAroundSeesNothingTwiceAtOnce) {
  const Body body = read_settings<Body>(kScenes + "robots/pioneer3dx.yaml");
  const Rig rig = read_settings<Rig>(kScenes + "rigs/four-around.yaml");
  ASSERT_EQ(rig.cameras.size(), 4U);
  EXPECT_TRUE(rig.with_role("floor").empty());
  std::vector<double> yaw_rad;
  for (const auto& [name, camera] : rig.cameras) {
    const Vec3 axis = camera.T_body_camera.rotation * Vec3::UnitZ();
    yaw_rad.push_back(std::atan2(axis.y(), axis.x()));
    EXPECT_NEAR(camera.T_body_camera.translation.head<2>().norm(), 0.15, 0.002) << name;
    EXPECT_LE(camera.T_body_camera.translation.z(), body.height_m) << name;
    // at the edge lines bend by much more than a pixel
    Intrinsics pinhole = camera.intrinsics;
    pinhole.distortion = NoDistortion();
    const Vec2 corner(0, 0);
    EXPECT_GT((pinhole.project(camera.intrinsics.ray(corner)) - corner).norm(), 20) << name;
  }
  std::sort(yaw_rad.begin(), yaw_rad.end());
  for (std::size_t i = 0; i < yaw_rad.size(); ++i) {
    const double next_rad =
        i + 1 < yaw_rad.size() ? yaw_rad[i + 1] : yaw_rad[0] + 2 * std::numbers::pi;
    EXPECT_GT(next_rad - yaw_rad[i], deg_to_rad(80));  // as wide as each sees
  }
}

}  // namespace
}  // namespace panoptes::sim

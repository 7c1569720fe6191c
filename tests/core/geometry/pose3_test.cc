// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/pose3.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_m = 1e-12;  // a few ulps at room scale

Pose3 random_pose(Rng& rng) {
  const Eigen::Quaterniond q(rng.normal(), rng.normal(), rng.normal(), rng.normal());
  return {q.normalized(), Vec3(rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-5, 5))};
}

TEST(Pose3, InverseUndoesTheTransform) {
  Rng rng(7);
  for (int i = 0; i < 100; ++i) {
    const Pose3 T_map_camera = random_pose(rng);
    const Vec3 p_camera(rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-5, 5));
    EXPECT_NEAR((T_map_camera.inverse() * (T_map_camera * p_camera) - p_camera).norm(), 0,
                kRoundoff_m);
  }
}

TEST(Pose3, CompositionIsTheTransformOfTransforms) {
  Rng rng(8);
  for (int i = 0; i < 100; ++i) {
    const Pose3 T_a_b = random_pose(rng);
    const Pose3 T_b_c = random_pose(rng);
    const Vec3 p_c(rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-5, 5));
    EXPECT_NEAR(((T_a_b * T_b_c) * p_c - T_a_b * (T_b_c * p_c)).norm(), 0, kRoundoff_m);
  }
}

TEST(Pose3, LiftsAPoseOffTheFloor) {
  const Pose2 T_map_body{1, 2, 0.5};
  const Vec2 p_body(0.3, -0.4);
  const Vec3 lifted = on_floor(T_map_body) * Vec3(0.3, -0.4, 0.7);
  EXPECT_NEAR((lifted.head<2>() - T_map_body * p_body).norm(), 0, kRoundoff_m);
  EXPECT_NEAR(lifted.z(), 0.7, kRoundoff_m);
}

TEST(Pose3, AMountedCameraLooksWhereItIsTurned) {
  const Pose3 ahead = mounted_camera(Vec3(0.1, 0, 0.8), 0, 0);
  EXPECT_NEAR((ahead.rotation * Vec3(0, 0, 1) - Vec3(1, 0, 0)).norm(), 0, kRoundoff_m);
  EXPECT_NEAR((ahead.rotation * Vec3(1, 0, 0) - Vec3(0, -1, 0)).norm(), 0, kRoundoff_m);
  EXPECT_NEAR((ahead.rotation * Vec3(0, 1, 0) - Vec3(0, 0, -1)).norm(), 0, kRoundoff_m);
  const Pose3 down = mounted_camera(Vec3::Zero(), 0, std::numbers::pi / 2);
  EXPECT_NEAR((down.rotation * Vec3(0, 0, 1) - Vec3(0, 0, -1)).norm(), 0, kRoundoff_m);
  const Pose3 left = mounted_camera(Vec3::Zero(), std::numbers::pi / 2, 0);
  EXPECT_NEAR((left.rotation * Vec3(0, 0, 1) - Vec3(0, 1, 0)).norm(), 0, kRoundoff_m);
}

}  // namespace
}  // namespace panoptes

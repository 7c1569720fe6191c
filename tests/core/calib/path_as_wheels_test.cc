// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/path_as_wheels.h"

#include <gtest/gtest.h>

#include "tests/support/driven_camera.h"

namespace panoptes {
namespace {

constexpr double kMetre_m = 1.7;
/// In a map that lies askew.
std::vector<StampedCamera> path_of_drive(const DrivenRose& drive, const RigCamera& camera) {
  return driven_camera_path(drive, camera, {turned_by({0.7, -0.4, 1.1}), Vec3(3, 2, 1)}, kMetre_m);
}

void expect_same(const Pose2& a, const Pose2& b, double within) {
  EXPECT_LT((a.position() - b.position()).norm(), within);
  EXPECT_LT(std::abs(wrap_angle(a.theta_rad - b.theta_rad)), within);
}

TEST(PathAsWheels, TellsHowTheBodyMoves) {
  const DrivenRose drive({}, Rng(1));
  const RigCamera camera = driven_camera();
  const WheelReadings wheels = path_as_wheels(path_of_drive(drive, camera), camera, kMetre_m);
  for (std::size_t i = 0; i + 1 < drive.instants(); i += 7) {
    const std::optional<Odometry> told = wheels(drive.instant(i));
    ASSERT_TRUE(told);
    expect_same(told->T_odom_body, drive.T_start_body(i), 1e-6);
    const Time later = drive.instant(i) + (drive.instant(i + 1) - drive.instant(i)) / 2;
    expect_same(wheels(later)->T_odom_body, drive.T_start_body(later), 2e-3);
  }
}

TEST(PathAsWheels, IsEmptyWhereThereIsNoPath) {
  const DrivenRose drive({}, Rng(1));
  const RigCamera camera = driven_camera();
  std::vector<StampedCamera> path = path_of_drive(drive, camera);
  path.erase(path.begin() + 40, path.begin() + 50);
  const WheelReadings wheels = path_as_wheels(path, camera, kMetre_m);
  EXPECT_FALSE(wheels(drive.instant(0) - from_seconds(0.01)));
  EXPECT_TRUE(wheels(drive.instant(38)));
  EXPECT_FALSE(wheels(drive.instant(45)));
  EXPECT_TRUE(wheels(drive.instant(51)));
  EXPECT_FALSE(wheels(drive.instant(drive.instants() - 1) + from_seconds(0.01)));
}

TEST(PathAsWheels, AnotherMetreAndMountingAreTheSameMotionOfAnotherBody) {
  const DrivenRose drive({}, Rng(1));
  const RigCamera camera = driven_camera();
  RigCamera off = camera;
  off.T_body_camera.translation += Vec3(0.05, -0.03, 0.1);
  off.T_body_camera.rotation = (turned_by({0, 0, 0.1}) * off.T_body_camera.rotation).normalized();
  const WheelReadings wheels = path_as_wheels(path_of_drive(drive, camera), off, 2 * kMetre_m);
  // By both metres: where the other body is, in this one.
  Pose3 T_body_camera = camera.T_body_camera;
  T_body_camera.translation *= 2;
  const Pose3 T_body_other = T_body_camera * off.T_body_camera.inverse();
  const auto other_at = [&](std::size_t i) {
    Pose3 T = on_floor(drive.T_start_body(i));
    T.translation *= 2;
    return T * T_body_other;
  };
  for (std::size_t i = 0; i + 1 < drive.instants(); i += 7) {
    const Pose3 moved = other_at(0).inverse() * other_at(i);
    const Pose3 told = on_floor(wheels(drive.instant(i))->T_odom_body);
    EXPECT_LT((moved.translation - told.translation).norm(), 1e-6);
    EXPECT_LT(moved.rotation.angularDistance(told.rotation), 1e-6);
  }
}

}  // namespace
}  // namespace panoptes

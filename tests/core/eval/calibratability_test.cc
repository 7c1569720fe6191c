// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/calibratability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

Rig rig_of(int width_px, int height_px) {
  Rig rig;
  for (const double yaw_deg : {0.0, 30.0}) {
    RigCamera& camera = rig.cameras[yaw_deg == 0 ? "ahead" : "aside"];
    camera.rate_hz = 5;
    camera.intrinsics = pinhole(width_px, height_px, deg_to_rad(80));
    camera.T_body_camera = mounted_camera({0.1, 0.05 * yaw_deg / 30, 0.7}, deg_to_rad(yaw_deg), 0);
  }
  return rig;
}

TEST(Calibratability, IsBetterOfFinerPictures) {
  const Calibratability coarse = calibratability({}, rig_of(160, 120), Body());
  const Calibratability fine = calibratability({}, rig_of(640, 480), Body());
  ASSERT_EQ(fine.cameras.size(), 2U);
  EXPECT_EQ(fine.cameras[0].camera, "ahead");
  EXPECT_LT(fine.rotation_rad, coarse.rotation_rad);
  EXPECT_LT(fine.rotation_rad, deg_to_rad(1));
  EXPECT_GT(fine.rotation_rad, deg_to_rad(0.001));
}

TEST(Calibratability, SaysWhatTheMotionDoesNotShow) {
  const Calibratability rose = calibratability({}, rig_of(320, 240), Body());
  // A level drive never tells how high the whole rig is.
  EXPECT_FALSE(rose.all_observable);
  EXPECT_THAT(rose.cameras[0].unobservable, testing::Contains(testing::HasSubstr("height")));
  EXPECT_LT(rose.position_m, 0.02);
  // So cameras are known to be as high as one another, and no better than before.
  const JointCovariance& left = *rose.left.covariance;
  EXPECT_GT(correlations(left, {"ahead.position_z_m", "aside.position_z_m"})(0, 1), 0.9);
  EXPECT_EQ(correlations(left, {"ahead.position_z_m", "ahead.fx_px"})(0, 1), 0);
  EXPECT_GT(rose.left.cameras.at("ahead").sigma.position_m.z(), 0.005);
  EXPECT_LT(rose.left.cameras.at("ahead").sigma.rotation_rad.maxCoeff(), deg_to_rad(0.2));
  EXPECT_EQ(rose.left.cameras.at("ahead").sigma.focal_ratio, CameraSigmas().focal_ratio);
}

}  // namespace
}  // namespace panoptes

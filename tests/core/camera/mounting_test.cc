// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/mounting.h"

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-12;  // a few ulps, in radians and metres

MountingOffset drawn(Rng& rng) {
  MountingOffset offset;
  for (int i = 0; i < 3; ++i) {
    offset.rotation_rad[i] = rng.uniform(-1, 1);
    offset.shift_m[i] = rng.uniform(-1, 1);
  }
  return offset;
}

TEST(Mounting, AnOffsetIsWhatLeadsFromOneToTheOther) {
  Rng rng(5);
  for (int i = 0; i < 100; ++i) {
    const Pose3 T_body_camera =
        mounted_camera({rng.uniform(-1, 1), rng.uniform(-1, 1), 0.5}, rng.uniform(-3, 3), 0.4);
    const MountingOffset offset = drawn(rng);
    const MountingOffset found = mounting_offset(T_body_camera, displaced(T_body_camera, offset));
    EXPECT_LT((found.rotation_rad - offset.rotation_rad).norm(), kRoundoff);
    EXPECT_LT((found.shift_m - offset.shift_m).norm(), kRoundoff);
  }
}

TEST(Mounting, NoOffsetLeavesTheBits) {
  const Pose3 T = mounted_camera({0.1, 0.2, 0.7}, 0.3, 0.2);
  const Pose3 same = displaced(T, {});
  EXPECT_EQ(same.rotation.coeffs(), T.rotation.coeffs());
  EXPECT_EQ(same.translation, T.translation);
}

TEST(Mounting, EachTurnIsAboutItsAxisOfTheBody) {
  const auto axis_body = [](double yaw_rad, const MountingOffset& by) {
    return Vec3(displaced(mounted_camera({0, 0, 1}, yaw_rad, 0), by).rotation * Vec3::UnitZ());
  };
  MountingOffset yaw;
  yaw.rotation_rad.z() = 0.1;
  EXPECT_GT(axis_body(0, yaw).y(), 0.09);  // to the left
  MountingOffset pitch;
  pitch.rotation_rad.y() = 0.1;
  EXPECT_LT(axis_body(0, pitch).z(), -0.09);  // ahead: down
  EXPECT_GT(axis_body(deg_to_rad(180), pitch).z(), 0.09);
  MountingOffset roll;
  roll.rotation_rad.x() = 0.1;
  EXPECT_NEAR(axis_body(0, roll).x(), 1, kRoundoff);
  EXPECT_GT(axis_body(deg_to_rad(90), roll).z(), 0.09);  // its left side up
}

TEST(Mounting, IsWrittenInDegreesAndMetres) {
  const auto offset = read_settings_text<MountingOffset>(
      "{roll_deg: 1, pitch_deg: -2, yaw_deg: 3, x_m: 0.1, z_m: -0.3}", "m.yaml");
  EXPECT_EQ(offset.rotation_rad, Vec3(deg_to_rad(1), deg_to_rad(-2), deg_to_rad(3)));
  EXPECT_EQ(offset.shift_m, Vec3(0.1, 0, -0.3));
  const auto back = read_settings_text<MountingOffset>(write_settings(offset), "m.yaml");
  EXPECT_EQ(back.rotation_rad, offset.rotation_rad);
  EXPECT_EQ(back.shift_m, offset.shift_m);
}

}  // namespace
}  // namespace panoptes

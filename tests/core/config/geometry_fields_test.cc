// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/geometry_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/rng.h"

namespace panoptes {
namespace {

TEST(GeometryFields, PoseReadsDegreesAndWritesRadiansThatReadBackToTheSameBits) {
  const auto pose = read_settings_text<Pose2>("{x_m: 2, y_m: 3.5, theta_deg: 90}", "p.yaml");
  EXPECT_EQ(pose.x_m, 2);
  EXPECT_EQ(pose.y_m, 3.5);
  EXPECT_EQ(pose.theta_rad, deg_to_rad(90));
  EXPECT_EQ(write_settings(pose), "x_m: 2\ny_m: 3.5\ntheta_rad: 1.5707963267948966\n");
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 drawn{rng.normal(), rng.normal() * 1e-9, rng.uniform(-3, 3)};
    EXPECT_TRUE(read_settings_text<Pose2>(write_settings(drawn), "p.yaml") == drawn);
  }
}

TEST(GeometryFields, PoseInSpaceRoundTripsToTheBitAndRefusesWhatIsNoRotation) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Pose3 T_body_camera =
        mounted_camera({rng.normal(), rng.normal(), rng.normal()}, rng.normal(), rng.normal());
    const auto read = read_settings_text<Pose3>(write_settings(T_body_camera), "p.yaml");
    EXPECT_EQ(read.rotation.coeffs(), T_body_camera.rotation.coeffs());
    EXPECT_EQ(read.translation, T_body_camera.translation);
  }
  try {
    read_settings_text<Pose3>("{rotation_wxyz: [1, 1, 0, 0]}", "p.yaml");
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "p.yaml:1:17: rotation_wxyz: must be a unit quaternion [w, x, y, z]");
  }
}

TEST(GeometryFields, BodyKeepsItsRules) {
  try {
    read_settings_text<Body>("radius_m: -1\nticks_per_turn: 0\nmax_sped_mps: 1\n", "robot.yaml");
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.lines(),
                testing::ElementsAre(
                    "robot.yaml:1:11: radius_m: must be from 0.01 to 5, got -1",
                    "robot.yaml:2:17: ticks_per_turn: must be >= 1, got 0",
                    "robot.yaml:3:1: max_sped_mps: unknown key; did you mean max_speed_mps?"));
  }
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/platform_figures.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-9;

Rig believed() {
  Rig rig;
  RigCamera& front = rig.cameras["front"];
  front.intrinsics = pinhole(320, 240, deg_to_rad(80));
  front.T_body_camera = mounted_camera({0.2, 0, 0.5}, 0.4, 0.1);
  front.clock_offset_s = 0.002;
  rig.cameras["unknown"] = front;
  return rig;
}

TEST(PlatformFigures, AreTruthLessBelief) {
  Rig truth = believed();
  truth.cameras.erase("unknown");
  RigCamera& front = truth.cameras["front"];
  const MountingOffset off{{deg_to_rad(0.3), deg_to_rad(-0.2), deg_to_rad(1)}, {0.01, -0.02, 0.03}};
  front.T_body_camera = displaced(front.T_body_camera, off);
  front.intrinsics.fx_px *= 1.01;
  front.intrinsics.fy_px *= 1.01;
  front.intrinsics.cx_px += 1;
  front.intrinsics.cy_px -= 2;
  front.intrinsics.distortion = BrownConrady{0.02, 0, 0, 0, 0};
  front.clock_offset_s = 0.012;
  const auto errors = camera_errors(truth, believed());
  EXPECT_EQ(errors.size(), 1U);
  const auto& one = errors["front"];
  EXPECT_NEAR(one["roll_error_deg"], 0.3, kRoundoff);
  EXPECT_NEAR(one["pitch_error_deg"], -0.2, kRoundoff);
  EXPECT_NEAR(one["yaw_error_deg"], 1, kRoundoff);
  EXPECT_NEAR(one["x_error_m"], 0.01, kRoundoff);
  EXPECT_NEAR(one["y_error_m"], -0.02, kRoundoff);
  EXPECT_NEAR(one["z_error_m"], 0.03, kRoundoff);
  EXPECT_NEAR(one["focal_error_percent"], 1, kRoundoff);
  EXPECT_NEAR(one["centre_error_px"][0], 1, kRoundoff);
  EXPECT_NEAR(one["centre_error_px"][1], -2, kRoundoff);
  EXPECT_NEAR(one["distortion_error"], 0.02, kRoundoff);
  EXPECT_NEAR(one["clock_error_s"], 0.01, kRoundoff);
}

TEST(PlatformFigures, LensesOfTwoKindsHaveNoDistortionToCompare) {
  Rig truth = believed();
  truth.cameras["front"].intrinsics.distortion = Equidistant{0.01, 0, 0, 0};
  EXPECT_FALSE(camera_errors(truth, believed())["front"].contains("distortion_error"));
  Rig rig = truth;
  rig.cameras["front"].intrinsics.distortion = Equidistant{0.03, 0, 0, 0};
  EXPECT_NEAR(camera_errors(truth, rig)["front"]["distortion_error"], -0.02, kRoundoff);
}

TEST(PlatformFigures, OfWheelsAreRelative) {
  const Body body;
  const auto errors = wheel_errors(
      {body.wheel_radius_m * 1.02 * (1 + 0.0025 / 1.00125 / 2),
       body.wheel_radius_m * 1.02 * (1 - 0.0025 / 1.00125 / 2), body.wheel_base_m * 0.99},
      body);
  EXPECT_NEAR(errors["radius_error_percent"], 2, kRoundoff);
  EXPECT_NEAR(errors["radius_ratio_error_percent"], 0.25, kRoundoff);
  EXPECT_NEAR(errors["base_error_percent"], -1, kRoundoff);
}

TEST(PlatformFigures, OfLearnedWheelsHaveTheErrorsOfTheLastTruth) {
  LearnedWheels learned;
  learned.base_m = LearnedValue{0.331, 0.001, std::nullopt};
  auto wheels = wheels_json(learned);
  EXPECT_EQ(wheels["base_sigma"], 0.001);
  put_wheel_errors(wheels, {0.1, 0.1, 0.330});
  put_wheel_errors(wheels, {0.1, 0.1, 0.329});
  EXPECT_NEAR(wheels["base_error"], 0.002, kRoundoff);
  EXPECT_FALSE(wheels.contains("radius_ratio_error"));
}

TEST(PlatformFigures, OfACameraOfWhichNothingWasLearnedAreNone) {
  LearnedCamera front;
  front.yaw_rad = LearnedValue{deg_to_rad(1), deg_to_rad(0.1), std::nullopt};
  const auto rig = rig_json({{"front", front}, {"back", LearnedCamera()}});
  EXPECT_EQ(rig.size(), 1U);
  EXPECT_EQ(rig["front"].size(), 2U);
  EXPECT_NEAR(rig["front"]["yaw_correction_deg"], 1, kRoundoff);
  EXPECT_NEAR(rig["front"]["yaw_correction_deg_sigma"], 0.1, kRoundoff);
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/camera.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "sim/sensors/floor_pixels.h"

namespace panoptes::sim {
namespace {

RigCamera floor_camera() {
  RigCamera camera;
  camera.roles = {"floor"};
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28));
  camera.floor = FloorView{};
  return camera;
}

TEST(SurveyFloor, LaysFourMarksSpreadOverTheMappedPart) {
  const RigCamera camera = floor_camera();
  const Body body;
  const auto marks = survey_floor("floor", camera, body, {0, 0}, Rng(1));
  ASSERT_EQ(marks.size(), 4U);
  for (const FloorMark& mark : marks) {
    EXPECT_TRUE(in_mapped_range(camera, body, mark.p_body));
    const Vec3 p_camera =
        camera.T_body_camera.inverse() * Vec3(mark.p_body.x(), mark.p_body.y(), 0);
    constexpr double kRoundoff_px = 1e-9;
    EXPECT_NEAR((camera.intrinsics.project(p_camera) - mark.px).norm(), 0, kRoundoff_px);
  }
  EXPECT_GT(marks[0].p_body.y(), 0.3);  // near left, near right, far left, far right
  EXPECT_LT(marks[1].p_body.y(), -0.3);
  EXPECT_LT(marks[0].p_body.x(), 0.6);
  EXPECT_GT(marks[2].p_body.x(), 3);
  EXPECT_GT(marks[2].p_body.y(), 1.5);
  EXPECT_LT(marks[3].p_body.y(), -1.5);
}

TEST(SurveyFloor, HasTheErrorsOfTapeAndPicture) {
  const RigCamera camera = floor_camera();
  const auto exact = survey_floor("floor", camera, Body{}, {0, 0}, Rng(1));
  constexpr int kDraws = 100;
  double floor2 = 0;
  double pixel2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const auto marks =
        survey_floor("floor", camera, Body{}, {}, Rng(static_cast<std::uint64_t>(i)));
    for (std::size_t k = 0; k < 4; ++k) {
      floor2 += (marks[k].p_body - exact[k].p_body).squaredNorm();
      pixel2 += (marks[k].px - exact[k].px).squaredNorm();
    }
  }
  constexpr double kNumbers = 8.0 * kDraws;
  const double three_sigma = 3 * std::sqrt(2 / kNumbers);
  EXPECT_NEAR(floor2 / kNumbers / (0.002 * 0.002), 1, three_sigma);
  EXPECT_NEAR(pixel2 / kNumbers / (0.3 * 0.3), 1, three_sigma);
}

TEST(SurveyFloor, RefusesACameraWithoutFloor) {
  RigCamera camera = floor_camera();
  camera.T_body_camera = mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(-35));
  try {
    survey_floor("floor", camera, Body{}, {}, Rng(1));
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "rig.cameras.floor.floor: too little of the floor from near_m to far_m is in this "
                 "camera's picture to lay four marks on it; tilt it down or widen the range");
  }
}

}  // namespace
}  // namespace panoptes::sim

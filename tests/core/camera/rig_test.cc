// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/rig.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_px = 1e-9;

TEST(Intrinsics, ARayProjectsToItsPixel) {
  const Intrinsics camera = pinhole(320, 240, deg_to_rad(80));
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Vec2 px(rng.uniform(0, 319), rng.uniform(0, 239));
    EXPECT_LT((camera.project(camera.ray(px) * rng.uniform(0.1, 10)) - px).norm(), kRoundoff_px);
  }
}

TEST(Intrinsics, TheFieldOfViewEndsAtThePicturesEdges) {
  const Intrinsics camera = pinhole(320, 240, deg_to_rad(80));
  const Vec2 px = camera.project({std::tan(deg_to_rad(40)), 0, 1});
  EXPECT_NEAR(px.x(), 319.5, kRoundoff_px);  // the outer edge of the last pixel
  EXPECT_NEAR(px.y(), 119.5, kRoundoff_px);
}

TEST(Rig, FindsTheFirstCameraWithARole) {
  Rig rig;
  rig.cameras["b"].roles = {"loop_back"};
  rig.cameras["a"].roles = {"loop_front", "floor"};
  EXPECT_EQ(rig.with_role("floor"), "a");
  EXPECT_EQ(rig.with_role("loop_back"), "b");
  EXPECT_EQ(rig.with_role("stereo_left"), "");
}

}  // namespace
}  // namespace panoptes

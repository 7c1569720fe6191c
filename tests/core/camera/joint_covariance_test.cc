// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/joint_covariance.h"

#include <gmock/gmock.h>

#include "core/camera/rig.h"

namespace panoptes {
namespace {

using testing::ElementsAre;

TEST(JointCovariance, EachCamerasLensIsNamed) {
  Intrinsics lens = pinhole(320, 240, 1.2);
  lens.distortion = Equidistant{};
  EXPECT_THAT(
      joint_parameters("up", lens),
      ElementsAre("up.rotation_x_rad", "up.rotation_y_rad", "up.rotation_z_rad", "up.position_x_m",
                  "up.position_y_m", "up.position_z_m", "up.fx_px", "up.fy_px", "up.cx_px",
                  "up.cy_px", "up.k1", "up.k2", "up.k3", "up.k4", "up.clock_s"));
}

TEST(JointCovariance, TellsHowParametersGoTogether) {
  JointCovariance joint{{"a.x", "a.y", "b.x"}, Mat3::Zero()};
  joint.covariance << 4, 0, -3,  //
      0, 0, 0,                   //
      -3, 0, 9;
  Eigen::Matrix4d expected = Eigen::Matrix4d::Identity();
  expected(0, 2) = expected(2, 0) = -0.5;
  EXPECT_EQ(correlations(joint, {"b.x", "unknown", "a.x", "a.y"}), expected);
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/make_odometry.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace panoptes {
namespace {

struct Settings {
  OdometryOptions odometry;
};
void bind(Fields& f, Settings& o) { f.choice("odometry", o.odometry); }

TEST(MakeOdometry, IsByTheWheelsUnlessTheSettingsSayOtherwise) {
  const Settings chosen;
  const WheelNoise noise{.step_sigma_m = 0.01};
  Body body;
  body.wheel_base_m = 0.33;
  const Rig rig;
  const std::unique_ptr<OdometrySource> source = make_odometry({chosen.odometry, noise, body, rig});
  const Pose2 T_from_to{0.25, 0.01, 0.1};
  EXPECT_EQ(source->covariance(time_at(1), time_at(2), T_from_to),
            wheel_covariance(noise, body.wheel_base_m, T_from_to));
  Observation broken;
  broken.odometry.T_odom_body.x_m = std::nan("");
  EXPECT_FALSE(source->at(broken));
  EXPECT_EQ(source->fault(), "the wheels tell no number");
  EXPECT_EQ(write_settings(chosen), "odometry:\n  kind: wheels\n");
}

TEST(MakeOdometry, RefusesASourceThatNobodyHasMade) {
  try {
    read_settings_text<Settings>("odometry: stars\n", "m.yaml");
    FAIL() << "it was taken";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.lines(), testing::ElementsAre("m.yaml:1:11: odometry: must be one of "
                                                    "wheels, got stars"));
  }
}

}  // namespace
}  // namespace panoptes

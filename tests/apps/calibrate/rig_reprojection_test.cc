// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_reprojection.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/calibrated_rig.h"

namespace panoptes {
namespace {

double rms_of_all_px(const CalibratedRig& rig, const RigBundleState& state) {
  double squared = 0;
  int all = 0;
  for (std::size_t c = 0; c < rig.calibration.cameras.size(); ++c) {
    const ReprojectionRms rms =
        reprojection_rms(rig.calibration.tracks, state, rig.calibration.wheels, c);
    squared += rms.own * rms.own_px * rms.own_px + rms.other * rms.other_px * rms.other_px;
    all += rms.own + rms.other;
  }
  EXPECT_EQ(all, rig.calibration.bundle.observations);
  return std::sqrt(squared / all);
}

TEST(RigReprojection, IsWhatTheAdjustmentSaysOfIt) {
  const CalibratedRig rig({});
  constexpr double kClock_px = 1e-3;  // a camera's clock moves it on along an arc or a line
  EXPECT_NEAR(rms_of_all_px(rig, rig.calibration.bundle.state), rig.calibration.bundle.rms_after_px,
              kClock_px);
}

TEST(RigReprojection, IsLessAfterThanBefore) {
  const CalibratedRig rig({});
  EXPECT_LT(5 * rms_of_all_px(rig, rig.calibration.bundle.state),
            rms_of_all_px(rig, rig.calibration.before));
}

TEST(RigReprojection, IsNotToldOfWhatLiesBehindTheCamera) {
  CalibratedRig rig({});
  const RigSeen& seen = rig.calibration.tracks.seen.front();
  RigBundleState state = rig.calibration.bundle.state;
  EXPECT_TRUE(drawn_px(rig.calibration.tracks, state, rig.calibration.wheels, seen));
  state.points_start[seen.point] *= -100;
  EXPECT_FALSE(drawn_px(rig.calibration.tracks, state, rig.calibration.wheels, seen));
}

}  // namespace
}  // namespace panoptes

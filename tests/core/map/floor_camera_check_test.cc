// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_camera_check.h"

#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr int kFirstMinute = 100;  // steps
constexpr double kKnock_rad = deg_to_rad(1.5);
constexpr double kKnock_m = 0.02;

// What one step shows, one sigma: of driving little of how far ahead or aside the camera sits.
FloorState step_sigma() {
  FloorState sigma;
  sigma << deg_to_rad(0.15), deg_to_rad(0.15), deg_to_rad(0.4), 0.005, 0.005, 0.03, 0.02;
  return sigma;
}

/// What steps show of a camera, each with noise of its own.
class Steps {
 public:
  explicit Steps(Rng rng, double noise_factor = 1)
      : rng_(std::move(rng)), noise_factor_(noise_factor) {}

  void knock(int state, double by) { truth_[state] += by; }
  void show(const FloorState& sigma) { sigma_ = sigma; }

  /// The next step, which the check is told of.
  std::optional<FloorKnock> next(FloorCameraCheck& check) {
    FloorEvidence evidence;
    FloorState seen = truth_;
    for (int state = 0; state < kFloorStates; ++state) {
      seen[state] += rng_.normal(0, noise_factor_ * sigma_[state]);
    }
    evidence.information = sigma_.cwiseAbs2().cwiseInverse().asDiagonal();
    evidence.vector = evidence.information * seen;
    return check.add(evidence);
  }

 private:
  Rng rng_;
  double noise_factor_;
  FloorState truth_ = FloorState::Zero();
  FloorState sigma_ = step_sigma();
};

// Steps until a knock is found.
int found_after(FloorCameraCheck& check, Steps& steps, int most, std::optional<FloorKnock>& knock) {
  int after = 0;
  while (!knock && after < most) {
    knock = steps.next(check);
    ++after;
  }
  return after;
}

void drive(FloorCameraCheck& check, Steps& steps, int count) {
  for (int k = 0; k < count; ++k) {
    ASSERT_FALSE(steps.next(check)) << k;
  }
}

TEST(FloorCameraCheck, FindsNoneWhereThereIsNone) {
  for (int run = 0; run < 20; ++run) {
    FloorCameraCheck check;
    Steps steps{Rng(100 + run)};
    drive(check, steps, 1000);
  }
}

TEST(FloorCameraCheck, LearnsByHowMuchMoreStepsDisagreeThanTheyClaim) {
  for (int run = 0; run < 20; ++run) {
    FloorCameraCheck check;
    Steps steps(Rng(200 + run), 4);
    drive(check, steps, 1000);
  }
}

TEST(FloorCameraCheck, WhatIsOffFromTheBeginningIsNoKnock) {
  FloorCameraCheck check;
  Steps steps{Rng(1)};
  for (const int state : {kFloorRoll, kFloorPitch, kFloorYaw}) {
    steps.knock(state, deg_to_rad(2));
  }
  steps.knock(kFloorShift, 0.02);
  steps.knock(kFloorShift + 1, -0.02);
  drive(check, steps, 400);
}

TEST(FloorCameraCheck, ACameraThatIsTurnedIsFoundWithinAFewStretches) {
  for (const int state : {kFloorRoll, kFloorPitch, kFloorYaw}) {
    FloorCameraCheck check;
    Steps steps(Rng(10 + state));
    drive(check, steps, kFirstMinute);
    steps.knock(state, kKnock_rad);
    std::optional<FloorKnock> knock;
    EXPECT_LE(found_after(check, steps, 40, knock), 24) << state;
    ASSERT_TRUE(knock) << state;
    EXPECT_NEAR(knock->turned_rad[state], kKnock_rad, kKnock_rad / 3);
  }
}

TEST(FloorCameraCheck, ACameraThatIsShiftedIsFoundWithinAWindow) {
  for (const int axis : {0, 1}) {
    FloorCameraCheck check;
    Steps steps(Rng(20 + axis));
    drive(check, steps, kFirstMinute);
    steps.knock(kFloorShift + axis, kKnock_m);
    std::optional<FloorKnock> knock;
    found_after(check, steps, 60, knock);
    ASSERT_TRUE(knock) << axis;
    EXPECT_NEAR(knock->shifted_m[axis], kKnock_m, kKnock_m / 3);
  }
}

// As one in which somebody walks through the picture.
TEST(FloorCameraCheck, OneOddStretchIsNoKnock) {
  FloorCameraCheck check;
  Steps steps{Rng(30)};
  drive(check, steps, kFirstMinute);
  steps.knock(kFloorRoll, deg_to_rad(6));
  drive(check, steps, 4);
  steps.knock(kFloorRoll, -deg_to_rad(6));
  drive(check, steps, kFirstMinute);
}

TEST(FloorCameraCheck, WheelsThatSlipLookLikeAnotherHeightAndAreNoKnock) {
  FloorCameraCheck check;
  Steps steps{Rng(31)};
  drive(check, steps, kFirstMinute);
  steps.knock(kFloorShift + 2, 0.03);
  drive(check, steps, kFirstMinute);
}

TEST(FloorCameraCheck, WhatTheFloorDoesNotShowIsNoKnock) {
  FloorCameraCheck check;
  Steps steps{Rng(32)};
  steps.show(FloorState::Constant(10));
  drive(check, steps, 200);
  steps.knock(kFloorYaw, kKnock_rad);
  drive(check, steps, 200);
}

}  // namespace
}  // namespace panoptes

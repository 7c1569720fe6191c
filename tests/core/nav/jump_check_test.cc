// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/jump_check.h"

#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/geometry/pose2.h"

namespace panoptes {
namespace {

constexpr int kCameras = 2;
constexpr int kStates = kCameras * kMountingStates;
constexpr double kShown_rad = deg_to_rad(0.05);  // one sigma, of one look
constexpr double kShown_m = 0.003;

/// What keyframes show of a camera that jumps, each time with noise of its own.
class Drive {
 public:
  explicit Drive(Rng rng) : rng_(std::move(rng)) {
    Eigen::VectorXd sigma(kStates);
    for (int camera = 0; camera < kCameras; ++camera) {
      sigma.segment<kMountingStates>(camera * kMountingStates) << kShown_rad, kShown_rad,
          kShown_rad, kShown_m, kShown_m, kShown_m;
    }
    information_ = sigma.cwiseAbs2().cwiseInverse();
  }

  void knock(int camera, int state, double by, int keyframe) {
    change_[camera * kMountingStates + state] = by;
    knocked_at_ = keyframe;
  }

  double noisier = 1;    // times more than it claims, in sigmas
  int only_third = -1;   // of the picture shows the jump
  double fitting = 0.8;  // share of what the second camera shows

  /// Drives on until a knock is found.
  std::optional<Knock> run(JumpCheck& check, int keyframes) {
    for (int newest = 0; newest < keyframes; ++newest) {
      const auto shows = [&](int at, int /*before*/, int /*most*/,
                             const std::optional<KeyframeOdometry::PictureThird>& without) {
        return shown(at, without);
      };
      check.look(newest, shows);
      while (check.to_judge(newest)) {
        if (const std::optional<Knock> knock = check.judge(newest, shows)) {
          found_at = newest;
          return knock;
        }
      }
    }
    return std::nullopt;
  }

  int found_at = -1;

 private:
  MountingJump shown(int at, const std::optional<KeyframeOdometry::PictureThird>& without) {
    Eigen::VectorXd seen = Eigen::VectorXd::Zero(kStates);
    if (at == knocked_at_ && (!without || without->third != only_third)) {
      seen = change_;
    }
    for (int k = 0; k < kStates; ++k) {
      seen[k] += rng_.normal(0, noisier / std::sqrt(information_[k]));
    }
    MountingJump jump;
    jump.information = information_.asDiagonal();
    jump.scatter = noisier * noisier * jump.information;
    jump.pull = information_.cwiseProduct(seen);
    jump.crossing = {100, 100};
    jump.fitting = {80, static_cast<int>(100 * fitting)};
    return jump;
  }

  Rng rng_;
  Eigen::VectorXd information_;
  Eigen::VectorXd change_ = Eigen::VectorXd::Zero(kStates);
  int knocked_at_ = -1;
};

constexpr int kAt = 70;
constexpr int kLong = 120;

TEST(JumpCheck, FindsNoneWhereThereIsNone) {
  for (int run = 0; run < 10; ++run) {
    JumpCheck check;
    EXPECT_FALSE(Drive(Rng(100 + run)).run(check, 1000)) << run;
  }
}

TEST(JumpCheck, ACameraThatIsTurnedOrShiftedIsNamed) {
  for (int camera = 0; camera < kCameras; ++camera) {
    for (int state = kRotation; state < kHeight; ++state) {
      const bool turned = state < kPosition;
      const double by = turned ? deg_to_rad(1.5) : -0.02;
      JumpCheck check;
      Drive drive(Rng(10 * state + camera));
      drive.knock(camera, state, by, kAt);
      const std::optional<Knock> knock = drive.run(check, kLong);
      ASSERT_TRUE(knock) << camera << state;
      EXPECT_EQ(knock->camera, camera);
      EXPECT_EQ(knock->begin, kAt - 1);
      EXPECT_EQ(knock->end, kAt);
      EXPECT_LE(drive.found_at, kAt + 20);
      EXPECT_NEAR(knock->change[state], by, 4 * (turned ? kShown_rad : kShown_m));
    }
  }
}

TEST(JumpCheck, NoiseThatTracksShowIsBelieved) {
  for (int run = 0; run < 10; ++run) {
    JumpCheck check;
    Drive drive(Rng(200 + run));
    drive.noisier = 5;
    EXPECT_FALSE(drive.run(check, 500)) << run;
  }
}

// Somebody walks by.
TEST(JumpCheck, WhatAPartOfThePictureShowsIsNoKnock) {
  JumpCheck check;
  Drive drive(Rng(3));
  drive.knock(0, kRotation + 2, deg_to_rad(1.5), kAt);
  drive.only_third = 1;
  EXPECT_FALSE(drive.run(check, kLong));
}

TEST(JumpCheck, WhereMostOfWhatACameraShowsDoesNotFitNothingIsSaid) {
  JumpCheck check;
  Drive drive(Rng(4));
  drive.knock(0, kRotation + 2, deg_to_rad(1.5), kAt);
  drive.fitting = 0.3;
  EXPECT_FALSE(drive.run(check, kLong));
}

TEST(JumpCheck, AChangeOfHeightAloneIsNoKnock) {
  JumpCheck check;
  Drive drive(Rng(5));
  drive.knock(1, kHeight, 0.02, kAt);
  EXPECT_FALSE(drive.run(check, kLong));
}

TEST(JumpCheck, AJumpThatIsKnownIsNotFoundAgain) {
  JumpCheck check;
  Drive drive(Rng(6));
  drive.knock(0, kRotation, deg_to_rad(1.5), kAt);
  check.begin_anew(kAt);
  EXPECT_FALSE(drive.run(check, kLong));
}

}  // namespace
}  // namespace panoptes

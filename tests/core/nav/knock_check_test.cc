// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/knock_check.h"

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
constexpr double kShown_rad = deg_to_rad(0.25);  // one sigma, of one bundle
constexpr double kShown_m = 0.004;

/// What bundles show of a rig, each with noise of its own, and what is known of it by then.
class Bundles {
 public:
  explicit Bundles(Rng rng) : rng_(std::move(rng)) {
    Eigen::VectorXd sigma = Eigen::VectorXd::Constant(truth_.size(), 1e-6);
    for (int camera = 0; camera < kCameras; ++camera) {
      sigma.segment<3>(camera_state(camera) + kRotation).setConstant(deg_to_rad(0.2));
      sigma.segment<2>(camera_state(camera) + kPosition).setConstant(0.003);
      shown_.segment<3>(camera_state(camera) + kRotation).setConstant(kShown_rad);
      shown_.segment<2>(camera_state(camera) + kPosition).setConstant(kShown_m);
    }
    information_ = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  }

  void knock(int camera, int state, double by) { truth_[camera_state(camera) + state] += by; }

  int made() const { return made_; }

  /// The next bundle, which the check is told of.
  std::optional<Knock> next(KnockCheck& check) {
    Eigen::VectorXd seen = truth_;
    for (Eigen::Index k = 0; k < seen.size(); ++k) {
      seen[k] += shown_[k] > 0 ? rng_.normal(0, shown_[k]) : 0;
    }
    const Eigen::VectorXd weight =
        shown_.unaryExpr([](double sigma) { return sigma > 0 ? 1 / (sigma * sigma) : 0; });
    JointEdge bundle{made_++, {Pose2{}}, state_, {}, {}};  // over one keyframe
    bundle.information = Eigen::MatrixXd::Identity(3 + state_.size(), 3 + state_.size());
    bundle.information.bottomRightCorner(state_.size(), state_.size()) = weight.asDiagonal();
    bundle.gradient = Eigen::VectorXd::Zero(3 + state_.size());
    bundle.gradient.tail(state_.size()) = weight.cwiseProduct(state_ - seen);
    const std::optional<Knock> knock =
        check.add(bundle, state_, information_.inverse(), kAsTheyClaim);
    const Eigen::VectorXd pulled = information_ * state_ + weight.cwiseProduct(seen);
    information_ += weight.asDiagonal();
    state_ = information_.ldlt().solve(pulled);
    return knock;
  }

 private:
  static constexpr double kAsTheyClaim = 1;
  int made_ = 0;

  Rng rng_;
  RigState truth_ = RigState::Zero(rig_states(kCameras));
  RigState state_ = truth_;
  Eigen::VectorXd shown_ = Eigen::VectorXd::Zero(truth_.size());
  Eigen::MatrixXd information_;
};

TEST(KnockCheck, FindsNoneWhereThereIsNone) {
  for (int run = 0; run < 20; ++run) {
    KnockCheck check;
    Bundles bundles(Rng(100 + run));
    for (int k = 0; k < 100; ++k) {
      ASSERT_FALSE(bundles.next(check)) << run << ", bundle " << k;
    }
  }
}

TEST(KnockCheck, ACameraThatIsTurnedIsNamedWithinAFewBundles) {
  const double by_rad = deg_to_rad(1.5);
  for (int axis = 0; axis < 3; ++axis) {
    for (int camera = 0; camera < kCameras; ++camera) {
      KnockCheck check;
      Bundles bundles(Rng(10 * axis + camera));
      for (int k = 0; k < 30; ++k) {
        ASSERT_FALSE(bundles.next(check));
      }
      bundles.knock(camera, kRotation + axis, by_rad);
      std::optional<Knock> knock;
      int since = 0;
      for (; !knock && since < 5; ++since) {
        knock = bundles.next(check);
      }
      ASSERT_TRUE(knock) << axis << camera;
      EXPECT_EQ(knock->camera, camera);
      EXPECT_NEAR(bundles.made() - knock->end + 1, since, 1);
      EXPECT_LT(knock->begin, knock->end);
      EXPECT_LE(knock->begin, bundles.made() - since);  // it was knocked after that
      EXPECT_NEAR(knock->change[kRotation + axis], by_rad,
                  4 * kShown_rad / std::sqrt(static_cast<double>(since)));
    }
  }
}

TEST(KnockCheck, ACameraThatIsShiftedIsNamedWithinAWindow) {
  constexpr double kBy_m = 0.015;
  KnockCheck check;
  Bundles bundles(Rng(7));
  for (int k = 0; k < 30; ++k) {
    ASSERT_FALSE(bundles.next(check));
  }
  bundles.knock(1, kPosition, kBy_m);
  std::optional<Knock> knock;
  for (int k = 0; !knock && k < 12; ++k) {
    knock = bundles.next(check);
  }
  ASSERT_TRUE(knock);
  EXPECT_EQ(knock->camera, 1);
  EXPECT_NEAR(knock->change[kPosition], kBy_m, 0.006);
}

// As one during which somebody stands before the camera.
TEST(KnockCheck, OneOddBundleIsNoKnock) {
  KnockCheck check;
  Bundles bundles(Rng(8));
  for (int k = 0; k < 60; ++k) {
    const double odd_rad = k == 30 ? deg_to_rad(5) : k == 31 ? -deg_to_rad(5) : 0;
    bundles.knock(0, kRotation + 2, odd_rad);
    ASSERT_FALSE(bundles.next(check)) << k;
  }
}

TEST(KnockCheck, ANewRigIsJudgedByItself) {
  KnockCheck check;
  Bundles before(Rng(9));
  for (int k = 0; k < 30; ++k) {
    ASSERT_FALSE(before.next(check));
  }
  check.begin_anew();
  Bundles after(Rng(10));
  after.knock(0, kRotation + 2, deg_to_rad(0.3));  // as its own prior has it
  for (int k = 0; k < 60; ++k) {
    ASSERT_FALSE(after.next(check)) << k;
  }
}

}  // namespace
}  // namespace panoptes

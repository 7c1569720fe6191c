// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/pose_block.h"

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

Pose3 random_pose(Rng& rng) {
  return {Eigen::Quaterniond(rng.normal(), rng.normal(), rng.normal(), rng.normal()).normalized(),
          Vec3(rng.normal(), rng.normal(), rng.normal())};
}

TEST(PoseBlock, GoesThereAndBack) {
  Rng rng(1);
  const Pose3 T = random_pose(rng);
  const Pose3 again = from_block(to_block(T).data());
  EXPECT_EQ(again.rotation.coeffs(), T.rotation.coeffs());
  EXPECT_EQ(again.translation, T.translation);
}

TEST(PoseBlock, JacobiansAreDifferences) {
  Rng rng(2);
  constexpr double kStep = 1e-6;
  constexpr double kCurvature = 1e-8;
  for (int i = 0; i < 20; ++i) {
    const Pose3 T = random_pose(rng);
    const Vec3 p(rng.normal(), rng.normal(), rng.normal());
    const Eigen::Matrix<double, 3, 6> J = moved_by_pose(T, p);
    for (int n = 0; n < 6; ++n) {
      const Eigen::Matrix<double, 6, 1> step = kStep * Eigen::Matrix<double, 6, 1>::Unit(n);
      const Vec3 difference = (moved(T, step) * p - moved(T, -step) * p) / (2 * kStep);
      EXPECT_LT((J.col(n) - difference).norm(), kCurvature);
    }
  }
}

TEST(PoseBlock, TheSolverUndoesWhatItDid) {
  Rng rng(3);
  PoseBlock block = to_block(random_pose(rng));
  ceres::Problem problem;
  add_pose(problem, block);
  const ceres::Manifold* manifold = problem.GetManifold(block.data());
  const std::array<double, 6> delta{0.1, -0.2, 0.3, 1, 2, -3};
  PoseBlock there;
  std::array<double, 6> back;
  ASSERT_TRUE(manifold->Plus(block.data(), delta.data(), there.data()));
  ASSERT_TRUE(manifold->Minus(there.data(), block.data(), back.data()));
  constexpr double kRoundoff = 1e-12;
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(back[i], delta[i], kRoundoff);
  }
}

}  // namespace
}  // namespace panoptes

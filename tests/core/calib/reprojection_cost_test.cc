// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/reprojection_cost.h"

#include <array>
#include <memory>

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/calib/pose_block.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

const Intrinsics kLens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
const Vec2 kSeen_px(300, 200);
constexpr double kSigma_px = 0.5;

TEST(ReprojectionCost, IsTheSameWhetherThePointIsABlockOrKnown) {
  Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const Vec3 p(rng.normal(), rng.normal(), 4 + rng.normal());
    const Pose3 T{turned_by(0.1 * Vec3(rng.normal(), rng.normal(), rng.normal())),
                  0.1 * Vec3(rng.normal(), rng.normal(), rng.normal())};
    const Eigen::VectorXd lens = lens_parameters(kLens);
    const PoseBlock pose = to_block(T);
    const std::unique_ptr<ceres::CostFunction> free(reprojection_cost(kLens, kSeen_px, kSigma_px));
    const std::unique_ptr<ceres::CostFunction> known(
        reprojection_cost(kLens, kSeen_px, kSigma_px, p));
    const std::array<const double*, 3> blocks{lens.data(), pose.data(), p.data()};
    Vec2 of_free;
    Vec2 of_known;
    ASSERT_TRUE(free->Evaluate(blocks.data(), of_free.data(), nullptr));
    ASSERT_TRUE(known->Evaluate(blocks.data(), of_known.data(), nullptr));
    EXPECT_EQ(of_free, of_known);
    EXPECT_EQ(of_free, Vec2((kLens.project(T * p) - kSeen_px) / kSigma_px));
  }
}

TEST(ReprojectionCost, ItsSlopesByThePointAreDifferences) {
  const Pose3 T{turned_by(Vec3(0.1, -0.2, 0.05)), Vec3(0.1, 0.2, -0.1)};
  const Eigen::VectorXd lens = lens_parameters(kLens);
  const PoseBlock pose = to_block(T);
  const std::unique_ptr<ceres::CostFunction> cost(reprojection_cost(kLens, kSeen_px, kSigma_px));
  const auto at = [&](const Vec3& p, double* slopes) {
    const std::array<const double*, 3> blocks{lens.data(), pose.data(), p.data()};
    std::array<double*, 3> jacobians{nullptr, nullptr, slopes};
    Vec2 residual;
    EXPECT_TRUE(cost->Evaluate(blocks.data(), residual.data(), jacobians.data()));
    return residual;
  };
  const Vec3 p(0.3, -0.4, 2);
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> slopes;
  at(p, slopes.data());
  constexpr double kStep_m = 1e-6;
  constexpr double kCurvature = 1e-4;  // of slopes of some hundreds
  for (int n = 0; n < 3; ++n) {
    const Vec3 step = kStep_m * Vec3::Unit(n);
    const Vec2 difference = (at(p + step, nullptr) - at(p - step, nullptr)) / (2 * kStep_m);
    EXPECT_LT((slopes.col(n) - difference).norm(), kCurvature);
  }
}

TEST(ReprojectionCost, RefusesWhatLiesBehind) {
  const Eigen::VectorXd lens = lens_parameters(kLens);
  const PoseBlock pose = to_block({});
  const Vec3 p(0.1, 0.1, -1);
  const std::array<const double*, 3> blocks{lens.data(), pose.data(), p.data()};
  const std::unique_ptr<ceres::CostFunction> cost(reprojection_cost(kLens, kSeen_px, kSigma_px));
  Vec2 residual;
  EXPECT_FALSE(cost->Evaluate(blocks.data(), residual.data(), nullptr));
}

}  // namespace
}  // namespace panoptes

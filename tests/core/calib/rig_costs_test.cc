// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_costs.h"

#include <memory>
#include <vector>

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include "core/calib/pose_block.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

using Block = std::vector<double>;

Block pose(const Pose3& T) {
  const PoseBlock block = to_block(T);
  return {block.begin(), block.end()};
}

Block moved_block(const Block& block, Eigen::Index column, double step) {
  if (block.size() != 7) {
    Block out = block;
    out[static_cast<std::size_t>(column)] += step;
    return out;
  }
  Eigen::Matrix<double, 6, 1> by = Eigen::Matrix<double, 6, 1>::Zero();
  by[column] = step;
  return pose(moved(from_block(block.data()), by));
}

Eigen::VectorXd residuals(const ceres::CostFunction& cost, const std::vector<Block>& blocks) {
  std::vector<const double*> all;
  for (const Block& block : blocks) {
    all.push_back(block.data());
  }
  Eigen::VectorXd r(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(all.data(), r.data(), nullptr));
  return r;
}

/// Its derivatives, against those by small steps.
void expect_derivatives(const ceres::CostFunction& cost, const std::vector<Block>& blocks,
                        double share) {
  std::vector<const double*> all;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J;
  for (const Block& block : blocks) {
    all.push_back(block.data());
    J.emplace_back(cost.num_residuals(), static_cast<Eigen::Index>(block.size()));
  }
  std::vector<double*> told;
  for (auto& each : J) {
    told.push_back(each.data());
  }
  Eigen::VectorXd r(cost.num_residuals());
  ASSERT_TRUE(cost.Evaluate(all.data(), r.data(), told.data()));
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Eigen::Index moves =
        blocks[b].size() == 7 ? 6 : static_cast<Eigen::Index>(blocks[b].size());
    for (Eigen::Index column = 0; column < moves; ++column) {
      const double step =
          1e-6 * std::max(1.0, std::abs(blocks[b][static_cast<std::size_t>(column)]));
      std::vector<Block> up = blocks;
      std::vector<Block> down = blocks;
      up[b] = moved_block(blocks[b], column, step);
      down[b] = moved_block(blocks[b], column, -step);
      const Eigen::VectorXd by_steps = (residuals(cost, up) - residuals(cost, down)) / (2 * step);
      EXPECT_LT((J[b].col(column) - by_steps).norm(), share * (1 + by_steps.norm()))
          << "block " << b << ", column " << column;
    }
  }
}

const Pose3 kBodyStart = on_floor(Pose2{0.4, -0.2, 0.7}).inverse();

/// As a view may have them.
BySlides some_slides() {
  BySlides by_slides(3, kSlides);
  by_slides << 0.1, 0.02, -0.08, 0, 0.05, -0.1, 0.03, 0.1, -0.02, 0.07, 0.1, -0.04;
  return by_slides;
}

TEST(RigCosts, ReprojectionHasItsDerivatives) {
  Intrinsics lens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
  const Pose3 T_camera_body = mounted_camera({0.1, 0.05, 0.7}, 0.3, 0.1).inverse();
  const BodyMoved moved{exp_twist({0.3, 0.4}, 0.05), {0.3, 0.4}, 0.01};
  const Vec3 p_start = (T_camera_body * kBodyStart).inverse() * Vec3(0.4, -0.3, 2);
  const Eigen::VectorXd numbers = lens_parameters(lens);
  const std::unique_ptr<ceres::CostFunction> cost(
      rig_reprojection_cost(lens, {300, 200}, 0.5, moved));
  const std::unique_ptr<ceres::CostFunction> slides(
      rig_reprojection_cost(lens, {300, 200}, 0.5, moved, some_slides()));
  for (const double w : {1.0, 0.3, 0.0, -0.01}) {  // also of a direction, and of one beyond it
    const Vec3 x = w > 0 ? Vec3(w * p_start) : p_start;
    std::vector<Block> blocks{Block(numbers.data(), numbers.data() + numbers.size()),
                              pose(T_camera_body),
                              pose(kBodyStart),
                              {0.013},
                              {0.01, -0.02, 0.03},
                              {x.x(), x.y(), x.z(), w}};
    expect_derivatives(*cost, blocks, 1e-5);
    blocks.back().insert(blocks.back().end(), {0.001, -0.002, 0.003, 0.001});
    expect_derivatives(*slides, blocks, 1e-3);
  }
}

TEST(RigCosts, SlidesTellNoScale) {
  const Intrinsics lens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
  const Eigen::VectorXd numbers = lens_parameters(lens);
  const std::unique_ptr<ceres::CostFunction> cost(
      rig_reprojection_cost(lens, {300, 200}, 0.5, {}, some_slides()));
  const auto seen = [&](double metre) {
    Pose3 T_camera_body = mounted_camera({0.1, 0.05, 0.7}, 0.3, 0.1).inverse();
    Pose3 T_body_start = kBodyStart;
    const Vec3 p = metre * ((T_camera_body * T_body_start).inverse() * Vec3(0.4, -0.3, 2));
    T_camera_body.translation *= metre;
    T_body_start.translation *= metre;
    const Eigen::Vector4d h = p.homogeneous().normalized();
    return residuals(*cost, {Block(numbers.data(), numbers.data() + numbers.size()),
                             pose(T_camera_body),
                             pose(T_body_start),
                             {0},
                             {0, 0, 0},
                             {h[0], h[1], h[2], h[3], 0.1, -0.2, 0.3, 0.1}});
  };
  EXPECT_LT((seen(1) - seen(1.7)).norm(), 1e-9 * seen(1).norm());
}

TEST(RigCosts, WheelsHaveTheirDerivativesAndAgreeWithTheArcThatWasDriven) {
  const Pose2 driven = exp_twist({0.3, 0.5}, 1);
  const Pose3 now = (kBodyStart.inverse() * on_floor(driven)).inverse();
  const std::unique_ptr<ceres::CostFunction> cost(wheels_cost(driven, {0.01, 0.02, 0.03}));
  EXPECT_LT(residuals(*cost, {pose(kBodyStart), pose(now), {0, 0, 0}}).norm(), 1e-9);
  expect_derivatives(*cost, {pose(kBodyStart), pose(now), {0.01, -0.02, 0.03}}, 1e-5);
  // Wheels that say too little of the turn, by as much as their error is said to be.
  const std::unique_ptr<ceres::CostFunction> slips(
      wheels_cost(exp_twist({0.3, 0.5 / 1.04}, 1), {0.01, 0.02, 0.03}));
  EXPECT_LT(residuals(*slips, {pose(kBodyStart), pose(now), {0, 0.04, 0}}).norm(), 0.05);
}

TEST(RigCosts, LevelFloorHasItsDerivatives) {
  const std::unique_ptr<ceres::CostFunction> cost(level_cost(0.01, 0.02));
  EXPECT_LT(residuals(*cost, {pose(kBodyStart), {0, 0, 0}}).norm(), 1e-9);
  Pose3 tilted = kBodyStart;
  tilted.rotation = (turned_by({0.02, -0.03, 0}) * tilted.rotation).normalized();
  tilted.translation.z() += 0.05;
  expect_derivatives(*cost, {pose(tilted), {0.01, -0.02, 0.03}}, 1e-5);
}

TEST(RigCosts, KnownMountingHasItsDerivatives) {
  const Pose3 believed = mounted_camera({0.1, 0.05, 0.7}, 0.3, 0.1);
  const std::unique_ptr<ceres::CostFunction> cost(
      mounting_known_cost(believed, 0.02, Vec3(0.01, 0.02, 0.03)));
  EXPECT_LT(residuals(*cost, {pose(believed.inverse())}).norm(), 1e-9);
  Eigen::Matrix<double, 6, 1> by;
  by << 1e-4, -2e-4, 1e-4, 0.02, 0.01, -0.03;
  expect_derivatives(*cost, {pose(moved(believed.inverse(), by))}, 1e-3);
}

TEST(RigCosts, KeptMountingsHaveTheirDerivatives) {
  const std::vector<Pose3> kept{mounted_camera({0.1, 0.05, 0.7}, 0.3, 0.1),
                                mounted_camera({-0.1, 0.02, 0.6}, 2.9, 0.05)};
  const Eigen::MatrixXd directions = Eigen::MatrixXd::NullaryExpr(
      2, 12,
      [](Eigen::Index i, Eigen::Index j) { return std::sin(static_cast<double>(5 * i + j)); });
  const std::unique_ptr<ceres::CostFunction> cost(mountings_kept_cost(kept, directions));
  EXPECT_LT(residuals(*cost, {pose(kept[0].inverse()), pose(kept[1].inverse())}).norm(), 1e-9);
  Eigen::Matrix<double, 6, 1> by;
  by << 1e-4, -2e-4, 1e-4, 0.02, 0.01, -0.03;
  expect_derivatives(*cost, {pose(moved(kept[0].inverse(), by)), pose(kept[1].inverse())}, 1e-3);
}

TEST(RigCosts, WhatIsKnownTogetherHasItsDerivatives) {
  Eigen::MatrixXd weight(2, 3);
  weight << 4, 1, 0.5, 0, -2, 3;
  const std::vector<Eigen::VectorXd> values{Eigen::VectorXd::Constant(1, 0.1),
                                            Eigen::Vector2d(0.2, -0.3)};
  const std::unique_ptr<ceres::CostFunction> cost(known_together_cost(values, weight));
  EXPECT_NEAR(residuals(*cost, {{0.1}, {0.2, -0.3}}).norm(), 0, 1e-12);
  EXPECT_NEAR(residuals(*cost, {{0.2}, {-0.2, -0.3}})[0], 0, 1e-12);
  EXPECT_NEAR(residuals(*cost, {{0.2}, {-0.2, -0.3}})[1], 0.8, 1e-12);
  expect_derivatives(*cost, {{0.3}, {0.1, -0.1}}, 1e-6);
}

TEST(RigCosts, AwayHasItsDerivatives) {
  const Vec3 p_body(0.2, -0.1, 0.7);
  const std::unique_ptr<ceres::CostFunction> cost(away_cost(p_body, 0.3, 0.01));
  const Pose3 T_start_body = kBodyStart.inverse();
  EXPECT_NEAR(residuals(*cost, {pose(kBodyStart)})[0],
              ((T_start_body * p_body - p_body).norm() - 0.3) / 0.01, 1e-9);
  expect_derivatives(*cost, {pose(kBodyStart)}, 1e-6);
}

}  // namespace
}  // namespace panoptes

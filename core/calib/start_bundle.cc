// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/start_bundle.h"

#include <cstddef>
#include <memory>
#include <numeric>

#include <ceres/ceres.h>

#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

constexpr double kHuberSigmas = 2;
constexpr int kMostIterations = 50;

/// A point on a ray of the first picture, against where a later one shows it. Blocks:
/// T_camera_first, inverse depth.
class RayCost : public ceres::SizedCostFunction<2, 7, 1> {
 public:
  RayCost(const Intrinsics& lens, const Vec3& ray_first, const Vec2& seen_px, double sigma_px)
      : lens_(lens), ray_first_(ray_first), seen_px_(seen_px), sigma_px_(sigma_px) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose3 T_camera_first = from_block(blocks[0]);
    const double per_m = blocks[1][0];
    // What is drawn is the same at any distance.
    const Vec3 p = T_camera_first.rotation * ray_first_ + per_m * T_camera_first.translation;
    if (!can_draw(lens_, p)) {
      return false;
    }
    const Projection drawn = project_with_jacobian(lens_, p);
    Eigen::Map<Vec2> r(residuals);
    r = (drawn.px - seen_px_) / sigma_px_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Matrix<double, 3, 6> by_pose = moved_by_pose(T_camera_first, ray_first_);
      by_pose.rightCols<3>() *= per_m;
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> J(jacobians[0]);
      J.leftCols<6>() = drawn.px_by_point * by_pose / sigma_px_;
      J.col(6).setZero();
    }
    if (jacobians != nullptr && jacobians[1] != nullptr) {
      Eigen::Map<Vec2> J(jacobians[1]);
      J = drawn.px_by_point * T_camera_first.translation / sigma_px_;
    }
    return true;
  }

 private:
  Intrinsics lens_;
  Vec3 ray_first_;
  Vec2 seen_px_;
  double sigma_px_;
};

/// What is known of an inverse depth before.
class InverseDepthPrior : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit InverseDepthPrior(const StartBundleOptions& options) : options_(options) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residuals[0] = (blocks[0][0] - options_.inverse_depth_per_m) / options_.inverse_depth_sigma;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      jacobians[0][0] = 1 / options_.inverse_depth_sigma;
    }
    return true;
  }

 private:
  StartBundleOptions options_;
};

}  // namespace

std::optional<std::map<int, double>> start_inverse_depths(const StartBundleOptions& options,
                                                          const Intrinsics& lens,
                                                          const std::map<int, Vec2>& first_px,
                                                          const std::vector<StartView>& views) {
  ceres::Problem problem;
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  // The solver orders what it eliminates by addresses: neighbours keep their order.
  std::vector<double> per_m(first_px.size(), options.inverse_depth_per_m);
  std::vector<PoseBlock> T_camera_first;
  T_camera_first.reserve(views.size());
  for (const StartView& view : views) {
    T_camera_first.push_back(to_block(view.T_first_camera.inverse()));
    add_pose(problem, T_camera_first.back());
    order->AddElementToGroup(T_camera_first.back().data(), 1);
  }
  std::size_t next = 0;
  for (const auto& [number, px] : first_px) {
    double& inverse_depth = per_m[next++];
    const std::optional<Vec3> ray = lens.direction(px);
    if (!ray) {
      continue;
    }
    problem.AddResidualBlock(new InverseDepthPrior(options), nullptr, &inverse_depth);
    order->AddElementToGroup(&inverse_depth, 0);
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (const auto seen = views[i].seen_px.find(number); seen != views[i].seen_px.end()) {
        problem.AddResidualBlock(new RayCost(lens, *ray, seen->second, options.sigma_px),
                                 new ceres::HuberLoss(kHuberSigmas), T_camera_first[i].data(),
                                 &inverse_depth);
      }
    }
  }
  ceres::Solver::Options how;
  how.linear_solver_type = ceres::DENSE_SCHUR;
  how.linear_solver_ordering = order;
  how.max_num_iterations = kMostIterations;
  how.logging_type = ceres::SILENT;
  how.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(how, &problem, &summary);
  const double sum = std::accumulate(per_m.begin(), per_m.end(), 0.0);
  if (!summary.IsSolutionUsable() || sum <= 0) {
    return std::nullopt;
  }
  const double scale = options.inverse_depth_per_m * static_cast<double>(per_m.size()) / sum;
  std::map<int, double> by_number;
  next = 0;
  for (const auto& [number, px] : first_px) {
    by_number[number] = scale * per_m[next++];
  }
  return by_number;
}

}  // namespace panoptes

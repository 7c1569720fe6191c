// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/reprojection_cost.h"

#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include <ceres/cost_function.h>

#include "core/base/median.h"
#include "core/calib/pose_block.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

class ReprojectionCost : public ceres::CostFunction {
 public:
  ReprojectionCost(const Intrinsics& lens, const Vec2& seen_px, double sigma_px,
                   const std::optional<Vec3>& known_p_map)
      : lens_(lens), seen_px_(seen_px), sigma_px_(sigma_px), known_p_map_(known_p_map) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {static_cast<int>(lens_parameters(lens).size()), 7};
    if (!known_p_map) {
      mutable_parameter_block_sizes()->push_back(3);
    }
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Index count = parameter_block_sizes()[0];
    const Intrinsics lens =
        with_parameters(lens_, Eigen::Map<const Eigen::VectorXd>(blocks[0], count));
    const Pose3 T_camera_map = from_block(blocks[1]);
    const Vec3 p_map = known_p_map_ ? *known_p_map_ : Vec3(Eigen::Map<const Vec3>(blocks[2]));
    const Vec3 p = T_camera_map * p_map;
    if (!can_draw(lens, p)) {
      return false;
    }
    const Projection drawn = project_with_jacobian(lens, p);
    Eigen::Map<Vec2> r(residuals);
    r = (drawn.px - seen_px_) / sigma_px_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], 2, count) = drawn.px_by_lens / sigma_px_;
    }
    if (jacobians != nullptr && jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> J(jacobians[1]);
      J.leftCols<6>() = drawn.px_by_point * moved_by_pose(T_camera_map, p_map) / sigma_px_;
      J.col(6).setZero();
    }
    if (jacobians != nullptr && !known_p_map_ && jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J(jacobians[2]);
      J = drawn.px_by_point * T_camera_map.rotation.toRotationMatrix() / sigma_px_;
    }
    return true;
  }

 private:
  Intrinsics lens_;
  Vec2 seen_px_;
  double sigma_px_;
  std::optional<Vec3> known_p_map_;
};

}  // namespace

bool can_draw(const Intrinsics& lens, const Vec3& p_camera) {
  constexpr double kNearest_m = 1e-6;
  return std::holds_alternative<Equidistant>(lens.distortion)
             ? p_camera.z() > 0 || p_camera.head<2>().norm() > kNearest_m
             : p_camera.z() > kNearest_m;
}

double sigma_by_median(std::vector<double> squared_px) {
  const double median_of_chi2 = 2 * std::log(2);  // of two numbers
  return std::sqrt(median(std::move(squared_px)) / median_of_chi2);
}

ceres::CostFunction* reprojection_cost(const Intrinsics& lens, const Vec2& seen_px,
                                       double sigma_px) {
  return new ReprojectionCost(lens, seen_px, sigma_px, std::nullopt);
}

ceres::CostFunction* reprojection_cost(const Intrinsics& lens, const Vec2& seen_px, double sigma_px,
                                       const Vec3& p_map) {
  return new ReprojectionCost(lens, seen_px, sigma_px, p_map);
}

}  // namespace panoptes

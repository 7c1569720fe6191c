// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/kept_distance_cost.h"

#include <ceres/sized_cost_function.h>

#include "core/calib/pose_block.h"

namespace panoptes {
namespace {

class DistanceKept : public ceres::SizedCostFunction<1, 7, 7> {
 public:
  explicit DistanceKept(double distance_m) : distance_m_(distance_m) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    constexpr double kSigma = 1e-3;  // as a share
    const Pose3 a = from_block(blocks[0]);
    const Pose3 b = from_block(blocks[1]);
    const Vec3 apart = b.inverse().translation - a.inverse().translation;
    const double weight = 1 / (kSigma * distance_m_);
    residuals[0] = weight * (apart.norm() - distance_m_);
    for (int i = 0; i < 2 && jacobians != nullptr; ++i) {
      if (jacobians[i] != nullptr) {
        // The camera is at -R^T t, which only a shift of t and a turn of R move.
        const Pose3& T = i == 0 ? a : b;
        const Vec3 along = (i == 0 ? -weight : weight) * (T.rotation * apart.normalized());
        Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[i]);
        J << T.translation.cross(along).transpose(), -along.transpose(), 0;
      }
    }
    return true;
  }

 private:
  double distance_m_;
};

}  // namespace

ceres::CostFunction* kept_distance_cost(double distance_m) { return new DistanceKept(distance_m); }

}  // namespace panoptes

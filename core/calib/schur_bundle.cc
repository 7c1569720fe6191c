// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/schur_bundle.h"

#include <exception>

#include <ceres/ceres.h>

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

/// Nothing is thrown through the solver.
class EachStep : public ceres::IterationCallback {
 public:
  explicit EachStep(const std::function<void()>& what) : what_(what) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*step*/) override {
    try {
      if (what_) {
        what_();
      }
    } catch (...) {
      thrown_ = std::current_exception();
      return ceres::SOLVER_ABORT;
    }
    return ceres::SOLVER_CONTINUE;
  }
  void rethrow() const {
    if (thrown_) {
      std::rethrow_exception(thrown_);
    }
  }

 private:
  const std::function<void()>& what_;
  std::exception_ptr thrown_;
};

}  // namespace

ceres::LossFunction* made(Loss loss) {
  constexpr double kSigmas = 2;
  return loss == Loss::kHuber    ? static_cast<ceres::LossFunction*>(new ceres::HuberLoss(kSigmas))
         : loss == Loss::kCauchy ? new ceres::CauchyLoss(kSigmas)
                                 : nullptr;
}

bool keep_gauge(ceres::Problem& problem, const std::vector<PoseBlock*>& T_camera_map) {
  PoseBlock* farthest = nullptr;
  double far = 0;
  for (PoseBlock* block : T_camera_map) {
    const double apart = (from_block(block->data()).inverse().translation -
                          from_block(T_camera_map.front()->data()).inverse().translation)
                             .norm();
    if (apart > far) {
      far = apart;
      farthest = block;
    }
  }
  if (farthest == nullptr) {
    return false;
  }
  problem.SetParameterBlockConstant(T_camera_map.front()->data());
  problem.AddResidualBlock(new DistanceKept(far), nullptr, T_camera_map.front()->data(),
                           farthest->data());
  return true;
}

bool solve_by_schur(ceres::Problem& problem,
                    const std::shared_ptr<ceres::ParameterBlockOrdering>& ordering,
                    const SchurOptions& options, const std::function<void()>& each_step) {
  ceres::Solver::Options how;
  EachStep calls(each_step);
  how.callbacks.push_back(&calls);
  how.linear_solver_type = ceres::SPARSE_SCHUR;
  how.linear_solver_ordering = ordering;
  how.max_num_iterations = options.iterations;
  how.function_tolerance = options.function_tolerance;
  how.max_trust_region_radius = options.largest_radius;
  how.logging_type = ceres::SILENT;
  how.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(how, &problem, &summary);
  calls.rethrow();
  return summary.termination_type == ceres::CONVERGENCE;
}

}  // namespace panoptes

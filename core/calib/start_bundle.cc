// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/start_bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <ceres/ceres.h>
#include <ceres/crs_matrix.h>

#include "core/base/median.h"
#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

constexpr double kCauchySigmas = 2;
constexpr int kMostIterations = 100;

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

/// Their mean is the map's metre.
class MeanKept : public ceres::CostFunction {
 public:
  MeanKept(std::size_t count, double mean) : mean_(mean) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->assign(count, 1);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    constexpr double kSigma = 1e-3;  // as a share
    const std::size_t count = parameter_block_sizes().size();
    const double weight = 1 / (kSigma * mean_ * static_cast<double>(count));
    residuals[0] = -mean_ * weight * static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
      residuals[0] += weight * blocks[i][0];
      if (jacobians != nullptr && jacobians[i] != nullptr) {
        jacobians[i][0] = weight;
      }
    }
    return true;
  }

 private:
  double mean_;
};

struct SeenTwice {
  Vec3 ray_first;
  Vec3 ray_now;
  Vec2 px;
  double off_px = 1;
};

/// The turn that explains best what a camera sees that has gone `shift_m` from the first picture,
/// were all at one distance, and what it leaves of it: the median. By distances, not by their
/// squares: what is false shall not pull (Kabsch 1976, reweighted).
struct BestTurn {
  Eigen::Quaterniond R_camera_first = Eigen::Quaterniond::Identity();
  double off_px = 0;
};

BestTurn best_turn(const StartBundleOptions& options, const Intrinsics& lens,
                   std::vector<SeenTwice> seen, const Vec3& shift_m) {
  if (seen.empty()) {
    return {};
  }
  for (SeenTwice& s : seen) {
    s.ray_first = (s.ray_first / options.inverse_depth_per_m - shift_m).normalized();
  }
  Mat3 turn = Mat3::Identity();
  constexpr int kTimes = 20;
  for (int i = 0; i < kTimes; ++i) {
    Mat3 sum = Mat3::Zero();
    for (const SeenTwice& s : seen) {
      sum += s.ray_now * s.ray_first.transpose() / std::max(options.sigma_px, s.off_px);
    }
    const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double mirrored = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    turn = svd.matrixU() * Vec3(1, 1, mirrored).asDiagonal() * svd.matrixV().transpose();
    for (SeenTwice& s : seen) {
      s.off_px = (lens.project(turn * s.ray_first) - s.px).norm();
    }
  }
  std::vector<double> off_px;
  for (const SeenTwice& s : seen) {
    off_px.push_back(s.off_px);
  }
  return {Eigen::Quaterniond(turn), median(off_px)};
}

std::vector<SeenTwice> seen_twice(const Intrinsics& lens, const std::map<int, Vec2>& first_px,
                                  const StartView& view) {
  std::vector<SeenTwice> seen;
  for (const auto& [number, px] : view.seen_px) {
    const std::optional<Vec3> first = lens.direction(first_px.at(number));
    const std::optional<Vec3> now = lens.direction(px);
    if (first && now) {
      seen.push_back({*first, *now, px});
    }
  }
  return seen;
}

/// What is adjusted. The solver orders by addresses: neighbours keep their order.
struct Start {
  std::vector<PoseBlock> T_camera_first;
  std::vector<double> per_m;
  double cost = std::numeric_limits<double>::infinity();
};

/// All costs of a start. It holds on to the start's numbers.
class StartProblem {
 public:
  StartProblem(const StartBundleOptions& options, double sigma_px, const Intrinsics& lens,
               const std::map<int, Vec2>& first_px, const std::vector<StartView>& views,
               Start& start)
      : start_(start) {
    for (PoseBlock& block : start.T_camera_first) {
      add_pose(problem_, block);
    }
    for (const auto& [number, px] : first_px) {
      double* inverse_depth = &start.per_m[inverse_depths_.size()];
      inverse_depths_.push_back(inverse_depth);
      problem_.AddResidualBlock(new InverseDepthPrior(options), nullptr, inverse_depth);
      const std::optional<Vec3> ray = lens.direction(px);
      for (std::size_t i = 0; ray && i < views.size(); ++i) {
        if (const auto seen = views[i].seen_px.find(number); seen != views[i].seen_px.end()) {
          seen_.push_back(problem_.AddResidualBlock(new RayCost(lens, *ray, seen->second, sigma_px),
                                                    new ceres::CauchyLoss(kCauchySigmas),
                                                    start.T_camera_first[i].data(), inverse_depth));
        }
      }
    }
    problem_.AddResidualBlock(new MeanKept(inverse_depths_.size(), options.inverse_depth_per_m),
                              nullptr, inverse_depths_);
  }

  bool solve() {
    ceres::Solver::Options how;
    how.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    how.max_num_iterations = kMostIterations;
    how.logging_type = ceres::SILENT;
    how.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(how, &problem_, &summary);
    start_.cost = summary.final_cost;
    return summary.IsSolutionUsable();
  }

  /// By the median of what is left over, in sigmas.
  double noise() {
    std::vector<double> squares;
    for (const ceres::ResidualBlockId& id : seen_) {
      double cost = 0;
      std::array<double, 2> off{};
      problem_.EvaluateResidualBlock(id, false, &cost, off.data(), nullptr);
      squares.push_back(off[0] * off[0] + off[1] * off[1]);
    }
    return sigma_by_median(squares);
  }

  /// Of the inverse depths, as shares of them: the median sigma. Empty where they have none.
  std::optional<double> known_ratio() {
    ceres::Problem::EvaluateOptions how;
    how.num_threads = 1;
    how.parameter_blocks = inverse_depths_;
    for (PoseBlock& block : start_.T_camera_first) {
      how.parameter_blocks.push_back(block.data());
    }
    ceres::CRSMatrix J;
    if (!problem_.Evaluate(how, nullptr, nullptr, nullptr, &J)) {
      return std::nullopt;
    }
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(J.num_cols, J.num_cols);
    for (std::size_t row = 0; row + 1 < J.rows.size(); ++row) {
      const auto from = static_cast<std::size_t>(J.rows[row]);
      const auto to = static_cast<std::size_t>(J.rows[row + 1]);
      for (std::size_t i = from; i < to; ++i) {
        for (std::size_t k = from; k < to; ++k) {
          information(J.cols[i], J.cols[k]) += J.values[i] * J.values[k];
        }
      }
    }
    constexpr double kDamped = 1e-9;  // what nothing is known of is known hardly at all
    information.diagonal().array() += kDamped * information.diagonal().maxCoeff();
    const Eigen::LLT<Eigen::MatrixXd> factor(information);
    if (factor.info() != Eigen::Success) {
      return std::nullopt;
    }
    const Eigen::MatrixXd covariance =
        factor.solve(Eigen::MatrixXd::Identity(J.num_cols, J.num_cols));
    std::vector<double> ratios;
    for (std::size_t i = 0; i < inverse_depths_.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      ratios.push_back(std::sqrt(covariance(at, at)) /
                       std::max(1e-9, std::abs(*inverse_depths_[i])));
    }
    return median(ratios);
  }

 private:
  Start& start_;
  ceres::Problem problem_;
  std::vector<double*> inverse_depths_;
  std::vector<ceres::ResidualBlockId> seen_;
};

}  // namespace

std::optional<StartDepths> start_depths(const StartBundleOptions& options, const Intrinsics& lens,
                                        const std::map<int, Vec2>& first_px,
                                        const std::vector<StartView>& views) {
  const bool sees = std::any_of(views.begin(), views.end(),
                                [](const StartView& view) { return !view.seen_px.empty(); });
  if (first_px.empty() || !sees) {
    return std::nullopt;
  }
  StartDepths depths;
  std::vector<std::vector<SeenTwice>> seen;
  std::vector<double> parallax_px;
  for (const StartView& view : views) {
    seen.push_back(seen_twice(lens, first_px, view));
    parallax_px.push_back(best_turn(options, lens, seen.back(), Vec3::Zero()).off_px);
  }
  depths.parallax_px = *std::max_element(parallax_px.begin(), parallax_px.end());
  // A little shift and a little turn look alike but for their second order: whichever way it goes
  // is tried.
  Start best;
  for (const Vec3& way : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0),
                          Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    Start start;
    start.per_m.assign(first_px.size(), options.inverse_depth_per_m);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const Vec3 shift_m = parallax_px[i] / (lens.fx_px * options.inverse_depth_per_m) * way;
      const Eigen::Quaterniond R = best_turn(options, lens, seen[i], shift_m).R_camera_first;
      start.T_camera_first.push_back(to_block({R, -(R * shift_m)}));
    }
    if (StartProblem(options, options.sigma_px, lens, first_px, views, start).solve() &&
        start.cost < best.cost) {
      best = std::move(start);
    }
  }
  if (best.per_m.empty()) {
    return std::nullopt;
  }
  // Points are seen as well as what is left over says.
  constexpr double kLeastNoise = 0.2;
  double sigma_px = options.sigma_px;
  sigma_px *=
      std::max(kLeastNoise, StartProblem(options, sigma_px, lens, first_px, views, best).noise());
  StartProblem problem(options, sigma_px, lens, first_px, views, best);
  const bool is_usable = problem.solve();
  const std::optional<double> known_ratio = problem.known_ratio();
  if (!is_usable || !known_ratio) {
    return std::nullopt;
  }
  depths.known_ratio = *known_ratio * std::max(1.0, problem.noise());
  std::size_t next = 0;
  for (const auto& [number, px] : first_px) {
    depths.inverse_depth_per_m[number] = best.per_m[next++];
  }
  return depths;
}

}  // namespace panoptes

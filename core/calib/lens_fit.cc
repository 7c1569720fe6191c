// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/lens_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/median.h"
#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

constexpr int kFewestBoards = 5;     // with fewer the corners' scatter tells nothing of the lens
constexpr double kHopeless = 10;     // times what is asked: no number is told
constexpr double kSigmas = 2;        // by which the field is as good as asked, 95 of 100 times
constexpr double kOfBoard = 0.5;     // of what is asked of the field: what the board may leave open
constexpr double kLeastHalf = 0.35;  // use of each half of the picture: a lens is not told by one

using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

double square(double x) { return x * x; }

/// One lens, one board and where it was each time, as they are at a stage of the fit.
struct Estimate {
  Intrinsics lens;
  BoardShape shape;
  std::vector<Vec3> corners;                         ///< in the board's frame, by its shape
  std::vector<std::optional<Pose3>> T_camera_board;  ///< empty for pictures that take no part
};

/// A picture's corners, and which of them count: what was taken for a corner may be none.
struct View {
  BoardCorners px;
  std::vector<bool> counts;

  int counted() const { return static_cast<int>(std::count(counts.begin(), counts.end(), true)); }
};

/// The pose of a board from its corners' directions: the homography in homogeneous directions, of
/// which a pinhole's is the case z = 1 (Zhang 2000). Empty where the corners are no board's.
std::optional<Pose3> pose_by_directions(const Board& board, const std::vector<Vec3>& directions) {
  Eigen::Matrix<double, 9, 9> A = Eigen::Matrix<double, 9, 9>::Zero();
  const double scale = 1 / (board.square_m * std::max(board.columns, board.rows));
  for (int i = 0; i < board.corners(); ++i) {
    const Vec3 p = board.corner_board(i) * scale;
    const Vec3 on_board(p.x(), p.y(), 1);
    const Vec3& d = directions[i];
    Eigen::Matrix<double, 3, 9> rows = Eigen::Matrix<double, 3, 9>::Zero();
    rows.block<1, 3>(0, 3) = -d.z() * on_board.transpose();
    rows.block<1, 3>(0, 6) = d.y() * on_board.transpose();
    rows.block<1, 3>(1, 0) = d.z() * on_board.transpose();
    rows.block<1, 3>(1, 6) = -d.x() * on_board.transpose();
    rows.block<1, 3>(2, 0) = -d.y() * on_board.transpose();
    rows.block<1, 3>(2, 3) = d.x() * on_board.transpose();
    A += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(A);
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Mat3 H;
  H << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(), h.segment<3>(6).transpose();
  double along = 0;
  for (int i = 0; i < board.corners(); ++i) {
    const Vec3 p = board.corner_board(i) * scale;
    along += directions[i].dot(H * Vec3(p.x(), p.y(), 1));
  }
  const double size = 0.5 * (H.col(0).norm() + H.col(1).norm());
  if (!(size > 0) || !std::isfinite(along)) {
    return std::nullopt;
  }
  H *= (along < 0 ? -1 : 1) / size;
  Mat3 R;
  R << H.col(0), H.col(1), H.col(0).cross(H.col(1));
  const Eigen::JacobiSVD<Mat3> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0) {
    return std::nullopt;
  }
  return Pose3{Eigen::Quaterniond(R), H.col(2) / scale};
}

double squared_error(const Estimate& at, const View& view, const Pose3& T_camera_board) {
  double sum = 0;
  for (std::size_t i = 0; i < at.corners.size(); ++i) {
    if (!view.counts[i]) {
      continue;
    }
    const Vec3 p = T_camera_board * at.corners[i];
    if (!can_draw(at.lens, p)) {
      return std::numeric_limits<double>::infinity();
    }
    sum += (at.lens.project(p) - view.px[i]).squaredNorm();
  }
  return sum;
}

double rms_px(const Estimate& at, const View& view, const Pose3& T_camera_board) {
  return std::sqrt(squared_error(at, view, T_camera_board) / view.counted());
}

Estimate posed(const Intrinsics& lens, const BoardShape& shape, const Board& board,
               const std::vector<View>& views) {
  Estimate at{lens, shape, corners_board(board, shape), {}};
  for (const View& view : views) {
    std::vector<Vec3> directions;
    for (const Vec2& px : view.px) {
      if (const std::optional<Vec3> d = lens.direction(px)) {
        directions.push_back(*d);
      }
    }
    std::optional<Pose3> T;
    if (static_cast<int>(directions.size()) == board.corners()) {
      T = pose_by_directions(board, directions);
    }
    if (T && !std::isfinite(squared_error(at, view, *T))) {
      T.reset();
    }
    at.T_camera_board.push_back(T);
  }
  return at;
}

/// By the pictures in the middle: what fits none does not decide.
double typical_rms_px(const Estimate& at, const std::vector<View>& views) {
  std::vector<double> all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    all.push_back(at.T_camera_board[i] ? rms_px(at, views[i], *at.T_camera_board[i])
                                       : std::numeric_limits<double>::infinity());
  }
  return all.empty() ? std::numeric_limits<double>::infinity() : median(std::move(all));
}

/// A corner of the board as reprojection_cost has it, with the board's shape in the place of the
/// corner's point.
class CornerCost : public ceres::CostFunction {
 public:
  CornerCost(const Intrinsics& lens, const Vec2& seen_px, double sigma_px, const Board& board,
             int index)
      : by_point_(reprojection_cost(lens, seen_px, sigma_px)),
        flat_(board.corner_board(index)),
        by_shape_(corner_by_shape(board, index)) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = by_point_->parameter_block_sizes();
    mutable_parameter_block_sizes()->back() = ShapeNumbers::SizeAtCompileTime;
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Vec3 p_board = flat_ + by_shape_ * Eigen::Map<const ShapeNumbers>(blocks[2]);
    const std::array<const double*, 3> with_point{blocks[0], blocks[1], p_board.data()};
    if (jacobians == nullptr) {
      return by_point_->Evaluate(with_point.data(), residuals, nullptr);
    }
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
    std::array<double*, 3> with_slopes{jacobians[0], jacobians[1], by_point.data()};
    if (!by_point_->Evaluate(with_point.data(), residuals, with_slopes.data())) {
      return false;
    }
    if (jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 5, Eigen::RowMajor>> by_shape(jacobians[2]);
      by_shape = by_point * by_shape_;
    }
    return true;
  }

 private:
  std::unique_ptr<ceres::CostFunction> by_point_;
  Vec3 flat_;
  Eigen::Matrix<double, 3, 5> by_shape_;
};

/// Lens, shape and poses moved to where the corners fit best, each by its picture's standard
/// deviation; `robust` bounds what a corner may weigh.
void adjust(Estimate& at, const Board& board, const std::vector<View>& views,
            const std::vector<double>& sigma_px, bool robust, int most_iterations) {
  Eigen::VectorXd lens = lens_parameters(at.lens);
  ShapeNumbers shape = shape_numbers(at.shape);
  std::vector<PoseBlock> poses(views.size());
  ceres::Problem problem;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!at.T_camera_board[i]) {
      continue;
    }
    poses[i] = to_block(*at.T_camera_board[i]);
    add_pose(problem, poses[i]);
    for (int k = 0; k < board.corners(); ++k) {
      if (views[i].counts[k]) {
        problem.AddResidualBlock(new CornerCost(at.lens, views[i].px[k], sigma_px[i], board, k),
                                 robust ? new ceres::CauchyLoss(3) : nullptr, lens.data(),
                                 poses[i].data(), shape.data());
      }
    }
  }
  if (problem.NumResidualBlocks() == 0) {
    return;
  }
  const ShapeNumbers usual = shape_numbers(usual_shape(board));
  problem.AddResidualBlock(new ceres::NormalPrior(ceres::Matrix(usual.cwiseInverse().asDiagonal()),
                                                  ceres::Vector::Zero(usual.size())),
                           nullptr, shape.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = most_iterations;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (at.T_camera_board[i]) {
      order->AddElementToGroup(poses[i].data(), 0);
    }
  }
  order->AddElementToGroup(lens.data(), 1);
  order->AddElementToGroup(shape.data(), 1);
  options.linear_solver_ordering = order;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  at.lens = with_parameters(at.lens, lens);
  at.shape = shape_of(shape);
  at.corners = corners_board(board, at.shape);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (at.T_camera_board[i]) {
      at.T_camera_board[i] = from_block(poses[i].data());
    }
  }
}

Intrinsics guess(LensModel model, int width_px, int height_px, double f_px) {
  const Distortion distortion =
      model == LensModel::kEquidistant ? Distortion(Equidistant{}) : Distortion(BrownConrady{});
  return {width_px, height_px, f_px, f_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0, distortion};
}

/// From several focal lengths, those first with which the boards are most like boards.
std::optional<Estimate> first_estimate(const Board& board, const std::vector<View>& views,
                                       int width_px, int height_px, LensModel model) {
  constexpr double kShortest = 0.2;  // in widths of the picture: 185 degrees of a fisheye are 0.31
  constexpr double kLongest = 6;
  constexpr double kStep = 1.25;
  constexpr int kTried = 3;
  std::vector<std::pair<double, Estimate>> starts;
  for (double f = kShortest; f <= kLongest; f *= kStep) {
    Estimate at = posed(guess(model, width_px, height_px, f * width_px), {}, board, views);
    const double rms = typical_rms_px(at, views);
    if (std::isfinite(rms)) {
      starts.emplace_back(rms, std::move(at));
    }
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::optional<Estimate> best;
  double least_px = std::numeric_limits<double>::infinity();
  const std::vector<double> even(views.size(), 1.0);
  for (std::size_t i = 0; i < starts.size() && i < kTried; ++i) {
    Estimate at = starts[i].second;
    adjust(at, board, views, even, true, 50);
    const double rms = typical_rms_px(at, views);
    if (rms < least_px && at.lens.fx_px > 0 && at.lens.fy_px > 0) {
      least_px = rms;
      best = std::move(at);
    }
  }
  return best;
}

/// Poses anew by the lens as it is now, where they are better or were missing.
void pose_again(Estimate& at, const Board& board, const std::vector<View>& views) {
  Estimate fresh = posed(at.lens, at.shape, board, views);
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::optional<Pose3>& now = at.T_camera_board[i];
    const std::optional<Pose3>& other = fresh.T_camera_board[i];
    if (other &&
        (!now || squared_error(at, views[i], *other) < squared_error(at, views[i], *now))) {
      now = other;
    }
  }
}

/// What takes part from now on, and how sharp each picture is. What is far off the rest of its
/// picture was no corner; a picture that fits far worse than most, or has few corners left, shows
/// another board.
void weigh(Estimate& at, std::vector<View>& views, std::vector<double>& sigma_px) {
  constexpr double kMisfit = 4;    // times what is usual
  constexpr double kNoCorner = 5;  // standard deviations
  constexpr double kKept = 0.8;    // of a picture's corners
  constexpr double kUsualWeight = 10;
  std::vector<double> off_px;
  const std::size_t corners = at.corners.size();
  const auto corner_off_px = [&](std::size_t i, std::size_t k) {
    const Vec3 p = *at.T_camera_board[i] * at.corners[k];
    return can_draw(at.lens, p) ? (at.lens.project(p) - views[i].px[k]).norm()
                                : std::numeric_limits<double>::infinity();
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t k = 0; at.T_camera_board[i] && k < corners; ++k) {
      off_px.push_back(corner_off_px(i, k));
    }
  }
  if (off_px.empty()) {
    return;
  }
  constexpr double kMedianOfTwo = 1.1774;  // of the length of two normal numbers
  const double usual_px = std::max(median(off_px) / kMedianOfTwo, 1e-9);
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::optional<Pose3>& T = at.T_camera_board[i];
    if (!T) {
      continue;
    }
    std::vector<double> of_view;
    for (std::size_t k = 0; k < corners; ++k) {
      of_view.push_back(corner_off_px(i, k));
    }
    const double here_px = std::max(median(of_view) / kMedianOfTwo, usual_px);
    for (std::size_t k = 0; k < corners; ++k) {
      views[i].counts[k] = of_view[k] <= kNoCorner * here_px;
    }
    const int counted = views[i].counted();
    if (here_px > kMisfit * usual_px || counted < kKept * static_cast<double>(corners)) {
      T.reset();
      continue;
    }
    sigma_px[i] = std::sqrt((squared_error(at, views[i], *T) + kUsualWeight * square(usual_px)) /
                            (2.0 * counted - 6 + kUsualWeight));
  }
}

/// What the corners tell, the boards' poses taken out (Schur): of the lens' numbers and the
/// shape's, and of where each corner of the board is off that shape.
struct Information {
  Eigen::MatrixXd all;
  std::vector<Mat3> corner;                ///< the rest of it known
  std::vector<Vec3> corner_off;            ///< times the information of it
  std::vector<Eigen::MatrixX3d> together;  ///< of all, and of a corner
};

Information information(const Estimate& at, const Board& board, const std::vector<View>& views,
                        const std::vector<double>& sigma_px) {
  const Eigen::Index of_lens = lens_parameters(at.lens).size();
  const Eigen::Index count = of_lens + ShapeNumbers::SizeAtCompileTime;
  const std::size_t corners = at.corners.size();
  Information told{Eigen::MatrixXd::Zero(count, count), std::vector<Mat3>(corners, Mat3::Zero()),
                   std::vector<Vec3>(corners, Vec3::Zero()),
                   std::vector<Eigen::MatrixX3d>(corners, Eigen::MatrixX3d::Zero(count, 3))};
  for (std::size_t i = 0; i < at.T_camera_board.size(); ++i) {
    if (!at.T_camera_board[i]) {
      continue;
    }
    const Pose3& T_camera_board = *at.T_camera_board[i];
    Eigen::MatrixXd by_all = Eigen::MatrixXd::Zero(2 * corners, count);
    Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(2 * corners, 6);
    Eigen::MatrixX3d by_corner = Eigen::MatrixX3d::Zero(2 * corners, 3);
    Eigen::VectorXd off_px = Eigen::VectorXd::Zero(2 * corners);
    for (std::size_t k = 0; k < corners; ++k) {
      if (!views[i].counts[k]) {
        continue;
      }
      const Projection drawn = project_with_jacobian(at.lens, T_camera_board * at.corners[k]);
      const Matrix23 by_point = drawn.px_by_point * T_camera_board.rotation.toRotationMatrix();
      by_all.block(2 * k, 0, 2, of_lens) = drawn.px_by_lens;
      by_all.block<2, 5>(2 * k, of_lens) = by_point * corner_by_shape(board, static_cast<int>(k));
      by_pose.middleRows<2>(2 * k) =
          drawn.px_by_point * moved_by_pose(T_camera_board, at.corners[k]);
      by_corner.middleRows<2>(2 * k) = by_point;
      off_px.segment<2>(2 * k) = views[i].px[k] - drawn.px;
    }
    by_all -= by_pose * (by_pose.transpose() * by_pose).ldlt().solve(by_pose.transpose() * by_all);
    const double weight = 1 / square(sigma_px[i]);
    told.all += weight * by_all.transpose() * by_all;
    for (std::size_t k = 0; k < corners; ++k) {
      const auto of_corner = by_corner.middleRows<2>(2 * k);
      told.corner[k] += weight * of_corner.transpose() * of_corner;
      told.corner_off[k] += weight * of_corner.transpose() * off_px.segment<2>(2 * k);
      told.together[k] += weight * by_all.middleRows<2>(2 * k).transpose() * of_corner;
    }
  }
  return told;
}

/// How the corners of the board are off its shape, all pictures together.
struct Pattern {
  double spread_m = 0;    ///< standard deviation of a corner, each way, without what noise explains
  double alike = 0;       ///< correlation of neighbours: 0 where each is off by itself
  bool by_chance = true;  ///< noise alone may look like it
};

/// `scatter` is the variance of what `told` weighs. The corners' offsets, made even by what is
/// known of each (standard normal, were there but noise), against chance, and each with its
/// neighbours.
Pattern pattern(const Information& told, const Board& board, double scatter) {
  constexpr double kTaken = 12;  // by poses, size and shape
  constexpr double kChance = 4;  // standard deviations
  std::vector<Vec3> even;
  double squared = 0;
  double known = 0;  // a square metre's worth of offset, in the same measure
  for (std::size_t k = 0; k < told.corner.size(); ++k) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(told.corner[k]);
    constexpr double kNothing = 1e-12;  // of a corner that no picture counts: its offset is zero
    const Vec3 known_by = solver.eigenvalues().cwiseMax(kNothing);
    even.push_back(solver.eigenvectors() * known_by.cwiseSqrt().cwiseInverse().asDiagonal() *
                   solver.eigenvectors().transpose() * told.corner_off[k] / std::sqrt(scatter));
    squared += even.back().squaredNorm();
    known += told.corner[k].trace() / scatter;
  }
  const double numbers = 3 * static_cast<double>(even.size()) - kTaken;
  const double beyond_noise = squared - numbers;
  if (!(beyond_noise > 0)) {
    return {};
  }
  double product = 0;
  int pairs = 0;
  for (int k = 0; k < board.corners(); ++k) {
    if (k % board.columns + 1 < board.columns) {
      product += even[k].dot(even[k + 1]);
      ++pairs;
    }
    if (k + board.columns < board.corners()) {
      product += even[k].dot(even[k + board.columns]);
      ++pairs;
    }
  }
  const double alike = product / (3 * pairs) / (beyond_noise / numbers);
  return {std::sqrt(beyond_noise / known), product > kChance * std::sqrt(3 * pairs) ? alike : 0,
          beyond_noise < kChance * std::sqrt(2 * numbers)};
}

/// What such a pattern does to lens and shape: the corners are off at random, by a bell of their
/// distance alike. `covariance` is of both, by noise alone.
Eigen::MatrixXd by_pattern(const Pattern& pattern, const Information& told, const Board& board,
                           double scatter, const Eigen::MatrixXd& covariance) {
  constexpr double kMostAlike = 0.97;  // over 4 squares: more is the shape's
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(covariance.rows(), covariance.cols());
  const double by_square = std::log(std::min(pattern.alike, kMostAlike));
  for (int k = 0; k < board.corners(); ++k) {
    Eigen::MatrixX3d alike = told.together[k];
    for (int other = 0; pattern.alike > 0 && other < board.corners(); ++other) {
      const Vec3 apart = (board.corner_board(k) - board.corner_board(other)) / board.square_m;
      if (other != k) {
        alike += std::exp(by_square * apart.squaredNorm()) * told.together[other];
      }
    }
    all += told.together[k] * alike.transpose();
  }
  return square(pattern.spread_m / scatter) * covariance * all * covariance;
}

/// Empty where something of the lens is not told at all.
std::optional<Eigen::MatrixXd> inverted(const Eigen::MatrixXd& information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt();
  if (!scale.allFinite() || scale.minCoeff() <= 0) {
    return std::nullopt;
  }
  const Eigen::VectorXd by = scale.cwiseInverse();
  const Eigen::MatrixXd even = by.asDiagonal() * information * by.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(even);
  constexpr double kLeast = 1e-11;  // beyond it roundoff tells the rest
  if (!(solver.eigenvalues().minCoeff() > kLeast)) {
    return std::nullopt;
  }
  return by.asDiagonal() *
         (solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() *
          solver.eigenvectors().transpose()) *
         by.asDiagonal();
}

/// Pixels all over the picture, where the lens sees something.
std::vector<std::pair<Vec2, Vec3>> seen_all_over(const Intrinsics& lens) {
  constexpr int kAcross = 16;
  constexpr int kDown = 12;
  std::vector<std::pair<Vec2, Vec3>> all;
  for (int row = 0; row <= kDown; ++row) {
    for (int column = 0; column <= kAcross; ++column) {
      const Vec2 px(column * (lens.width_px - 1.0) / kAcross, row * (lens.height_px - 1.0) / kDown);
      if (const std::optional<Vec3> d = lens.direction(px)) {
        all.emplace_back(px, *d);
      }
    }
  }
  return all;
}

/// How a pixel moves when all directions turn a little.
Eigen::Matrix<double, 2, 3> by_turn(const Projection& drawn, const Vec3& direction) {
  return drawn.px_by_point * moved_by_pose(Pose3(), direction).leftCols<3>();
}

/// The uncertainty of where the lens draws directions, less what a turn of all explains: rms over
/// the picture, and where it is worst.
FieldDifference field_sigma(const Intrinsics& lens, const Eigen::MatrixXd& covariance) {
  const auto seen = seen_all_over(lens);
  Eigen::MatrixXd J(2 * seen.size(), covariance.cols());
  Eigen::MatrixXd B(2 * seen.size(), 3);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Projection drawn = project_with_jacobian(lens, seen[i].second);
    J.middleRows<2>(2 * i) = drawn.px_by_lens;
    B.middleRows<2>(2 * i) = by_turn(drawn, seen[i].second);
  }
  const Eigen::MatrixXd left = J - B * (B.transpose() * B).ldlt().solve(B.transpose() * J);
  double sum = 0;
  double most = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto rows = left.middleRows<2>(2 * i);
    const double variance = (rows * covariance * rows.transpose()).trace() / 2;  // each way
    sum += variance;
    most = std::max(most, variance);
  }
  return {std::sqrt(sum / static_cast<double>(seen.size())), std::sqrt(most)};
}

void fail(LensFit& fit, std::string reason) {
  fit.verdict = Verdict::kFailed;
  fit.reasons = {std::move(reason)};
}

/// The parts of the picture with corners in them, row by row.
std::vector<bool> used_parts(const std::vector<BoardCorners>& views, int width_px, int height_px) {
  std::vector<bool> used(kPartsAcross * kPartsDown, false);
  for (const BoardCorners& corners : views) {
    for (const Vec2& px : corners) {
      const int column = static_cast<int>((px.x() + 0.5) * kPartsAcross / width_px);
      const int row = static_cast<int>((px.y() + 0.5) * kPartsDown / height_px);
      used[std::clamp(row, 0, kPartsDown - 1) * kPartsAcross +
           std::clamp(column, 0, kPartsAcross - 1)] = true;
    }
  }
  return used;
}

struct Half {
  std::string_view name;
  double use = 0;
};

std::array<Half, 4> use_of_halves(const std::vector<bool>& used, const std::vector<bool>& lit) {
  std::array<Half, 4> halves{{{"left"}, {"right"}, {"upper"}, {"lower"}}};
  std::array<int, 4> parts{};
  for (int row = 0; row < kPartsDown; ++row) {
    for (int column = 0; column < kPartsAcross; ++column) {
      const int part = row * kPartsAcross + column;
      if (!lit.empty() && !lit[part]) {
        continue;
      }
      for (const int half : {column < kPartsAcross / 2 ? 0 : 1, row < kPartsDown / 2 ? 2 : 3}) {
        ++parts[half];
        halves[half].use += used[part];
      }
    }
  }
  for (int half = 0; half < 4; ++half) {
    halves[half].use /= std::max(1, parts[half]);
  }
  return halves;
}

/// A figure against what is asked of it, and the words for one that is not reached: with the
/// figure, or, where there is no lens, without.
struct Asked {
  double figure = 0;
  double most = 0;
  std::string known;
  std::string unknown;
  std::string advice;
  double sigmas = 1;  ///< of the figure that must be within
};

/// Whether most of what is open about the worse focal length hangs on whether the board is
/// stretched.
bool stretch_is_open(const Eigen::MatrixXd& covariance, const Intrinsics& lens) {
  const Eigen::Index stretch = covariance.cols() - ShapeNumbers::SizeAtCompileTime;
  const Eigen::Index f =
      covariance(0, 0) / square(lens.fx_px) > covariance(1, 1) / square(lens.fy_px) ? 0 : 1;
  return square(covariance(f, stretch)) > 0.5 * covariance(f, f) * covariance(stretch, stretch);
}

/// Whether each figure is what is asked, or hopeless; in words. `covariance` is of lens and shape,
/// `board_px` what the board's corners leave open of the field.
void judge(LensFit& fit, const LensFitOptions& asked, const std::array<Half, 4>& halves,
           const Eigen::MatrixXd& covariance, double board_px) {
  const Eigen::VectorXd sigma = fit.covariance.diagonal().cwiseSqrt();
  const double focal = std::max(sigma[0] / fit.lens.fx_px, sigma[1] / fit.lens.fy_px);
  const double centre_px = std::max(sigma[2], sigma[3]);
  const std::vector<Asked> figures{
      {fit.noise_px, asked.noise_px,
       fmt::format("corners scatter by {:.2f} px (at most {:.2f})", fit.noise_px, asked.noise_px),
       "corners scatter too much",
       "the pictures are blurred or the board is not flat; hold it still, more light, a stiff "
       "board"},
      {focal, asked.focal_sigma_ratio,
       fmt::format("the focal length is known to {:.2f} % (at most {:.2f})", 100 * focal,
                   100 * asked.focal_sigma_ratio),
       "the focal length is hardly known",
       stretch_is_open(covariance, fit.lens)
           ? "the board may be longer one way than it is declared; turn it by a quarter turn "
             "in some of the pictures"
           : "hold the board slanted by 30 to 45 degrees, each way, and near enough to fill "
             "the picture"},
      {centre_px, asked.centre_sigma_px,
       fmt::format("the principal point is known to {:.2f} px (at most {:.2f})", centre_px,
                   asked.centre_sigma_px),
       "the principal point is hardly known",
       "slant the board both ways, left, right, up and down"},
      {fit.field_sigma_rms_px, asked.field_px,
       fmt::format("over the picture directions are known to {:.2f} px ({:g} sigma, at most "
                   "{:.2f}), where it is worst to {:.2f} px",
                   kSigmas * fit.field_sigma_rms_px, kSigmas, asked.field_px,
                   kSigmas * fit.field_sigma_most_px),
       "directions are hardly known over the picture", "more boards near its edges and corners",
       kSigmas}};
  bool hopeless = false;
  for (const Asked& of : figures) {
    hopeless = hopeless || !(of.figure <= kHopeless * of.most);
  }
  for (const Half& half : halves) {
    hopeless = hopeless || half.use < kLeastHalf;
  }
  const std::string fault = lens_fault(fit.lens);
  hopeless = hopeless || !fault.empty();
  for (const Asked& of : figures) {
    if (!(of.sigmas * of.figure <= of.most)) {
      fit.reasons.push_back((hopeless ? of.unknown : of.known) + ": " + of.advice);
    }
  }
  if (kSigmas * board_px > kOfBoard * asked.field_px) {
    fit.reasons.push_back(
        fmt::format("the corners of the board are off a smooth one by {:.2f} mm: it is dented, "
                    "wavy or printed unevenly; print it anew, on a stiff flat plate",
                    1000 * fit.corner_spread_m));
  }
  if (fit.picture_use < asked.picture_use) {
    fit.reasons.push_back(
        fmt::format("corners were seen in {:.0f} % of the picture (at least {:.0f}): move the "
                    "board all over it",
                    100 * fit.picture_use, 100 * asked.picture_use));
  }
  for (const Half& half : halves) {
    if (half.use < kLeastHalf) {
      fit.reasons.push_back(fmt::format(
          "corners were seen in {:.0f} % of the {} half of the picture: move the board there too",
          100 * half.use, half.name));
    }
  }
  if (!fault.empty()) {
    fit.reasons.push_back("the lens that fits " + fault);
  }
  fit.verdict = hopeless ? Verdict::kFailed : fit.reasons.empty() ? Verdict::kGood : Verdict::kPoor;
}

/// Of each picture the first whose corners are the same to the last bit: itself, where it is none's
/// copy.
std::vector<std::size_t> originals(const std::vector<BoardCorners>& views) {
  std::vector<std::size_t> first(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    first[i] = static_cast<std::size_t>(
        std::find(views.begin(), views.begin() + static_cast<std::ptrdiff_t>(i), views[i]) -
        views.begin());
  }
  return first;
}

/// As fit_lens, of pictures none of which is a copy.
LensFit fit_originals(const LensFitOptions& options, const Board& board,
                      const std::vector<BoardCorners>& views, int width_px, int height_px,
                      LensModel model, const std::vector<bool>& lit) {
  LensFit fit;
  fit.views.resize(views.size());
  fit.picture_use = picture_use(views, width_px, height_px, lit);
  const auto too_few = [&](std::size_t count, std::string_view what) {
    fail(fit, fmt::format("{} {}: at least {} are needed, 20 to 40 are good; the whole board must "
                          "be in the picture, and inner corners are counted: a board of {} x {} "
                          "squares has {} x {}",
                          count, what, kFewestBoards, board.columns + 1, board.rows + 1,
                          board.columns, board.rows));
    return fit;
  };
  if (views.size() < kFewestBoards) {
    return too_few(views.size(), views.size() == 1 ? "picture shows a whole board"
                                                   : "pictures show a whole board");
  }
  std::vector<View> seen;
  for (const BoardCorners& corners : views) {
    PANOPTES_CHECK(static_cast<int>(corners.size()) == board.corners(), "all corners of a board");
    seen.push_back({corners, std::vector<bool>(corners.size(), true)});
  }
  std::optional<Estimate> found = first_estimate(board, seen, width_px, height_px, model);
  if (!found) {
    fail(fit,
         "no lens explains the corners: is this the board that was given, its columns and rows "
         "of inner corners counted?");
    return fit;
  }
  Estimate& at = *found;
  std::vector<double> sigma_px(views.size(), 1.0);
  for (int round = 0; round < 3; ++round) {
    pose_again(at, board, seen);
    weigh(at, seen, sigma_px);
    adjust(at, board, seen, sigma_px, false, 100);
  }
  double squared = 0;
  double weighted = 0;
  double corners = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (const std::optional<Pose3>& T = at.T_camera_board[i]) {
      const double error = squared_error(at, seen[i], *T);
      fit.views[i] = {true, *T, rms_px(at, seen[i], *T)};
      squared += error;
      weighted += error / square(sigma_px[i]);
      corners += seen[i].counted();
    }
  }
  fit.lens = at.lens;
  fit.shape = at.shape;
  const auto used = static_cast<std::size_t>(fit.used());
  if (used < kFewestBoards) {
    return too_few(used, "pictures agree with each other");
  }
  fit.reprojection_rms_px = std::sqrt(squared / corners);
  const Eigen::Index of_lens = lens_parameters(at.lens).size();
  const double unknowns = static_cast<double>(of_lens + ShapeNumbers::SizeAtCompileTime) +
                          6 * static_cast<double>(used);
  fit.noise_px = std::sqrt(squared / (2 * corners - unknowns));
  const double scatter = weighted / (2 * corners - unknowns);
  const Information told = information(at, board, seen, sigma_px);
  Eigen::MatrixXd all = told.all / scatter;
  all.diagonal().tail<5>() += shape_numbers(usual_shape(board)).cwiseAbs2().cwiseInverse();
  const std::optional<Eigen::MatrixXd> by_noise = inverted(all);
  if (!by_noise || !(at.lens.fx_px > 0) || !(at.lens.fy_px > 0)) {
    fail(fit, "the boards do not tell the focal length: slant them by 30 to 45 degrees, each way");
    return fit;
  }
  const Pattern off_shape = pattern(told, board, scatter);
  const Eigen::MatrixXd by_board = by_pattern(off_shape, told, board, scatter, *by_noise);
  const Eigen::MatrixXd covariance = *by_noise + by_board;
  fit.covariance = covariance.topLeftCorner(of_lens, of_lens);
  fit.shape_sigma = shape_of(covariance.diagonal().tail<5>().cwiseSqrt());
  fit.corner_spread_m = off_shape.spread_m;
  const FieldDifference field = field_sigma(fit.lens, fit.covariance);
  fit.field_sigma_rms_px = field.rms_px;
  fit.field_sigma_most_px = field.most_px;
  std::vector<BoardCorners> kept;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (fit.views[i].used) {
      kept.push_back(views[i]);
    }
  }
  fit.picture_use = picture_use(kept, width_px, height_px, lit);
  judge(fit, options, use_of_halves(used_parts(kept, width_px, height_px), lit), covariance,
        off_shape.by_chance
            ? 0
            : field_sigma(fit.lens, by_board.topLeftCorner(of_lens, of_lens)).rms_px);
  return fit;
}

}  // namespace

int LensFit::used() const {
  return static_cast<int>(
      std::count_if(views.begin(), views.end(), [](const FittedView& view) { return view.used; }));
}

int LensFit::copies() const {
  return static_cast<int>(
      std::count_if(views.begin(), views.end(), [](const FittedView& view) { return view.copy; }));
}

double picture_use(const std::vector<BoardCorners>& views, int width_px, int height_px,
                   const std::vector<bool>& lit) {
  const std::vector<bool> used = used_parts(views, width_px, height_px);
  int parts = 0;
  int with_corners = 0;
  for (std::size_t part = 0; part < used.size(); ++part) {
    const bool counts = lit.empty() || lit[part];
    parts += counts;
    with_corners += counts && used[part];
  }
  return parts > 0 ? static_cast<double>(with_corners) / parts : 0;
}

LensFit fit_lens(const LensFitOptions& options, const Board& board,
                 const std::vector<BoardCorners>& views, int width_px, int height_px,
                 LensModel model, const std::vector<bool>& lit) {
  const std::vector<std::size_t> first = originals(views);
  std::vector<BoardCorners> different;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (first[i] == i) {
      different.push_back(views[i]);
    }
  }
  LensFit fit = fit_originals(options, board, different, width_px, height_px, model, lit);
  std::vector<FittedView> all(views.size());
  auto next = fit.views.begin();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (first[i] == i) {
      all[i] = *next++;
    } else {
      all[i].copy = true;
    }
  }
  fit.views = std::move(all);
  return fit;
}

LensFit fit_best_lens(const LensFitOptions& options, const Board& board,
                      const std::vector<BoardCorners>& views, int width_px, int height_px,
                      const std::vector<bool>& lit) {
  LensFit straight =
      fit_lens(options, board, views, width_px, height_px, LensModel::kBrownConrady, lit);
  LensFit fisheye =
      fit_lens(options, board, views, width_px, height_px, LensModel::kEquidistant, lit);
  if (straight.used() == 0 || fisheye.used() == 0) {
    return straight.used() >= fisheye.used() ? straight : fisheye;
  }
  const auto cost = [&](const LensFit& fit) {
    double numbers = 0;
    double squared = 0;  // a picture left out fits as badly as what is just kept
    for (const FittedView& view : fit.views) {
      if (!view.copy) {
        numbers += 2.0 * board.corners();
        squared += board.corners() * square(view.used ? view.rms_px : 4 * fit.reprojection_rms_px);
      }
    }
    return numbers * std::log(std::max(squared, 1e-18) / numbers) +
           static_cast<double>(lens_parameters(fit.lens).size()) * std::log(numbers);
  };
  constexpr double kAlike = 10;  // Kass and Raftery 1995: very strong evidence
  return cost(fisheye) < cost(straight) - kAlike ? fisheye : straight;
}

FieldDifference field_difference(const Intrinsics& a, const Intrinsics& b,
                                 double most_off_axis_rad) {
  auto seen = seen_all_over(a);
  std::erase_if(seen, [most_off_axis_rad](const auto& pair) {
    return std::acos(std::clamp(pair.second.z(), -1.0, 1.0)) > most_off_axis_rad;
  });
  Pose3 T_b_a;
  FieldDifference difference;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    Mat3 A = Mat3::Zero();
    Vec3 g = Vec3::Zero();
    double sum = 0;
    int count = 0;
    difference.most_px = 0;
    for (const auto& [px, direction_a] : seen) {
      const Vec3 direction = T_b_a.rotation * direction_a;
      if (!can_draw(b, direction)) {
        continue;
      }
      const Projection drawn = project_with_jacobian(b, direction);
      const Eigen::Matrix<double, 2, 3> J = by_turn(drawn, direction);
      const Vec2 apart = px - drawn.px;
      A += J.transpose() * J;
      g += J.transpose() * apart;
      sum += apart.squaredNorm();
      difference.most_px = std::max(difference.most_px, apart.norm());
      ++count;
    }
    difference.rms_px = std::sqrt(sum / std::max(1, count));
    Eigen::Matrix<double, 6, 1> move = Eigen::Matrix<double, 6, 1>::Zero();
    move.head<3>() = A.ldlt().solve(g);
    T_b_a = moved(T_b_a, move);
  }
  return difference;
}

}  // namespace panoptes

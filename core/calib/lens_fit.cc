// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/lens_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <ceres/ceres.h>
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
constexpr double kLeastHalf = 0.35;  // use of each half of the picture: a lens is not told by one

using Matrix26 = Eigen::Matrix<double, 2, 6>;

double square(double x) { return x * x; }

/// One lens and where each board was, as they are at a stage of the fit.
struct Estimate {
  Intrinsics lens;
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

double squared_error(const Estimate& at, const Board& board, const View& view,
                     const Pose3& T_camera_board) {
  double sum = 0;
  for (int i = 0; i < board.corners(); ++i) {
    if (!view.counts[i]) {
      continue;
    }
    const Vec3 p = T_camera_board * board.corner_board(i);
    if (!can_draw(at.lens, p)) {
      return std::numeric_limits<double>::infinity();
    }
    sum += (at.lens.project(p) - view.px[i]).squaredNorm();
  }
  return sum;
}

double rms_px(const Estimate& at, const Board& board, const View& view,
              const Pose3& T_camera_board) {
  return std::sqrt(squared_error(at, board, view, T_camera_board) / view.counted());
}

Estimate posed(const Intrinsics& lens, const Board& board, const std::vector<View>& views) {
  Estimate at{lens, {}};
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
    if (T && !std::isfinite(squared_error(at, board, view, *T))) {
      T.reset();
    }
    at.T_camera_board.push_back(T);
  }
  return at;
}

/// By the pictures in the middle: what fits none does not decide.
double typical_rms_px(const Estimate& at, const Board& board, const std::vector<View>& views) {
  std::vector<double> all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    all.push_back(at.T_camera_board[i] ? rms_px(at, board, views[i], *at.T_camera_board[i])
                                       : std::numeric_limits<double>::infinity());
  }
  return all.empty() ? std::numeric_limits<double>::infinity() : median(std::move(all));
}

/// Lens and poses moved to where the corners fit best, each by its picture's standard deviation;
/// `robust` bounds what a corner may weigh.
void adjust(Estimate& at, const Board& board, const std::vector<View>& views,
            const std::vector<double>& sigma_px, bool robust, int most_iterations) {
  Eigen::VectorXd lens = lens_parameters(at.lens);
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
        problem.AddResidualBlock(
            reprojection_cost(at.lens, views[i].px[k], sigma_px[i], board.corner_board(k)),
            robust ? new ceres::CauchyLoss(3) : nullptr, lens.data(), poses[i].data());
      }
    }
  }
  if (problem.NumResidualBlocks() == 0) {
    return;
  }
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
  options.linear_solver_ordering = order;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  at.lens = with_parameters(at.lens, lens);
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
    Estimate at = posed(guess(model, width_px, height_px, f * width_px), board, views);
    const double rms = typical_rms_px(at, board, views);
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
    const double rms = typical_rms_px(at, board, views);
    if (rms < least_px && at.lens.fx_px > 0 && at.lens.fy_px > 0) {
      least_px = rms;
      best = std::move(at);
    }
  }
  return best;
}

/// Poses anew by the lens as it is now, where they are better or were missing.
void pose_again(Estimate& at, const Board& board, const std::vector<View>& views) {
  Estimate fresh = posed(at.lens, board, views);
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::optional<Pose3>& now = at.T_camera_board[i];
    const std::optional<Pose3>& other = fresh.T_camera_board[i];
    if (other && (!now || squared_error(at, board, views[i], *other) <
                              squared_error(at, board, views[i], *now))) {
      now = other;
    }
  }
}

/// What takes part from now on, and how sharp each picture is. What is far off the rest of its
/// picture was no corner; a picture that fits far worse than most, or has few corners left, shows
/// another board.
void weigh(Estimate& at, const Board& board, std::vector<View>& views,
           std::vector<double>& sigma_px) {
  constexpr double kMisfit = 4;    // times what is usual
  constexpr double kNoCorner = 5;  // standard deviations
  constexpr double kKept = 0.8;    // of a picture's corners
  constexpr double kUsualWeight = 10;
  std::vector<double> off_px;
  const auto corner_off_px = [&](std::size_t i, int k) {
    const Vec3 p = *at.T_camera_board[i] * board.corner_board(k);
    return can_draw(at.lens, p) ? (at.lens.project(p) - views[i].px[k]).norm()
                                : std::numeric_limits<double>::infinity();
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (int k = 0; at.T_camera_board[i] && k < board.corners(); ++k) {
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
    for (int k = 0; k < board.corners(); ++k) {
      of_view.push_back(corner_off_px(i, k));
    }
    const double here_px = std::max(median(of_view) / kMedianOfTwo, usual_px);
    for (int k = 0; k < board.corners(); ++k) {
      views[i].counts[k] = of_view[k] <= kNoCorner * here_px;
    }
    const int counted = views[i].counted();
    if (here_px > kMisfit * usual_px || counted < kKept * board.corners()) {
      T.reset();
      continue;
    }
    sigma_px[i] =
        std::sqrt((squared_error(at, board, views[i], *T) + kUsualWeight * square(usual_px)) /
                  (2.0 * counted - 6 + kUsualWeight));
  }
}

/// The lens' part of the inverse of all information: the boards' poses taken out (Schur).
Eigen::MatrixXd lens_information(const Estimate& at, const Board& board,
                                 const std::vector<View>& views,
                                 const std::vector<double>& sigma_px) {
  const Eigen::Index count = lens_parameters(at.lens).size();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t i = 0; i < at.T_camera_board.size(); ++i) {
    if (!at.T_camera_board[i]) {
      continue;
    }
    Eigen::MatrixXd U = Eigen::MatrixXd::Zero(count, count);
    Eigen::MatrixXd W = Eigen::MatrixXd::Zero(count, 6);
    Eigen::Matrix<double, 6, 6> V = Eigen::Matrix<double, 6, 6>::Zero();
    for (int k = 0; k < board.corners(); ++k) {
      if (!views[i].counts[k]) {
        continue;
      }
      const Vec3 p_board = board.corner_board(k);
      const Projection drawn = project_with_jacobian(at.lens, *at.T_camera_board[i] * p_board);
      const Matrix26 by_pose = drawn.px_by_point * moved_by_pose(*at.T_camera_board[i], p_board);
      U += drawn.px_by_lens.transpose() * drawn.px_by_lens;
      W += drawn.px_by_lens.transpose() * by_pose;
      V += by_pose.transpose() * by_pose;
    }
    S += (U - W * V.ldlt().solve(W.transpose())) / square(sigma_px[i]);
  }
  return S;
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

/// The uncertainty of where the lens draws directions, less what a turn of all explains.
void tell_field_sigma(LensFit& fit) {
  const auto seen = seen_all_over(fit.lens);
  Eigen::MatrixXd J(2 * seen.size(), fit.covariance.cols());
  Eigen::MatrixXd B(2 * seen.size(), 3);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Projection drawn = project_with_jacobian(fit.lens, seen[i].second);
    J.middleRows<2>(2 * i) = drawn.px_by_lens;
    B.middleRows<2>(2 * i) = by_turn(drawn, seen[i].second);
  }
  const Eigen::MatrixXd left = J - B * (B.transpose() * B).ldlt().solve(B.transpose() * J);
  double sum = 0;
  double most = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto rows = left.middleRows<2>(2 * i);
    const double variance = (rows * fit.covariance * rows.transpose()).trace() / 2;  // each way
    sum += variance;
    most = std::max(most, variance);
  }
  fit.field_sigma_rms_px = std::sqrt(sum / static_cast<double>(seen.size()));
  fit.field_sigma_most_px = std::sqrt(most);
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

/// Whether each figure is what is asked, or hopeless; in words.
void judge(LensFit& fit, const LensFitOptions& asked, const std::array<Half, 4>& halves) {
  const Eigen::VectorXd sigma = fit.covariance.diagonal().cwiseSqrt();
  const double focal = std::max(sigma[0] / fit.lens.fx_px, sigma[1] / fit.lens.fy_px);
  const double centre_px = std::max(sigma[2], sigma[3]);
  bool hopeless = false;
  const auto ask = [&](double figure, double most, const std::string& words, double sigmas = 1) {
    if (!(sigmas * figure <= most)) {
      hopeless = hopeless || !(figure <= kHopeless * most);
      fit.reasons.push_back(words);
    }
  };
  ask(fit.noise_px, asked.noise_px,
      fmt::format("corners scatter by {:.2f} px (at most {:.2f}): the pictures are blurred or "
                  "the board is not flat; hold it still, more light, a stiff board",
                  fit.noise_px, asked.noise_px));
  ask(focal, asked.focal_sigma_ratio,
      fmt::format("the focal length is known to {:.2f} % (at most {:.2f}): hold the board slanted "
                  "by 30 to 45 degrees, each way, and near enough to fill the picture",
                  100 * focal, 100 * asked.focal_sigma_ratio));
  ask(centre_px, asked.centre_sigma_px,
      fmt::format("the principal point is known to {:.2f} px (at most {:.2f}): slant the board "
                  "both ways, left, right, up and down",
                  centre_px, asked.centre_sigma_px));
  ask(fit.field_sigma_rms_px, asked.field_px,
      fmt::format(
          "over the picture directions are known to {:.2f} px ({:g} sigma, at most {:.2f}), "
          "where it is worst to {:.2f} px: more boards near its edges and corners",
          kSigmas * fit.field_sigma_rms_px, kSigmas, asked.field_px,
          kSigmas * fit.field_sigma_most_px),
      kSigmas);
  if (fit.picture_use < asked.picture_use) {
    fit.reasons.push_back(
        fmt::format("corners were seen in {:.0f} % of the picture (at least {:.0f}): move the "
                    "board all over it",
                    100 * fit.picture_use, 100 * asked.picture_use));
  }
  for (const Half& half : halves) {
    if (half.use < kLeastHalf) {
      hopeless = true;
      fit.reasons.push_back(fmt::format(
          "corners were seen in {:.0f} % of the {} half of the picture: move the board there too",
          100 * half.use, half.name));
    }
  }
  if (const std::string fault = lens_fault(fit.lens); !fault.empty()) {
    hopeless = true;
    fit.reasons.push_back("the lens that fits " + fault);
  }
  fit.verdict = hopeless ? Verdict::kFailed : fit.reasons.empty() ? Verdict::kGood : Verdict::kPoor;
}

}  // namespace

int LensFit::used() const {
  return static_cast<int>(
      std::count_if(views.begin(), views.end(), [](const FittedView& view) { return view.used; }));
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
  LensFit fit;
  fit.views.resize(views.size());
  fit.picture_use = picture_use(views, width_px, height_px, lit);
  const auto too_few = [&](std::size_t count, std::string_view what) {
    fail(fit, fmt::format("{} {}: at least {} are needed, 20 to 40 are good; the whole board must "
                          "be in the picture",
                          count, what, kFewestBoards));
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
    weigh(at, board, seen, sigma_px);
    adjust(at, board, seen, sigma_px, false, 100);
  }
  double squared = 0;
  double weighted = 0;
  double corners = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (const std::optional<Pose3>& T = at.T_camera_board[i]) {
      const double error = squared_error(at, board, seen[i], *T);
      fit.views[i] = {true, *T, rms_px(at, board, seen[i], *T)};
      squared += error;
      weighted += error / square(sigma_px[i]);
      corners += seen[i].counted();
    }
  }
  fit.lens = at.lens;
  const auto used = static_cast<std::size_t>(fit.used());
  if (used < kFewestBoards) {
    return too_few(used, "pictures agree with each other");
  }
  fit.reprojection_rms_px = std::sqrt(squared / corners);
  const double unknowns =
      static_cast<double>(lens_parameters(at.lens).size()) + 6 * static_cast<double>(used);
  fit.noise_px = std::sqrt(squared / (2 * corners - unknowns));
  const std::optional<Eigen::MatrixXd> covariance =
      inverted(lens_information(at, board, seen, sigma_px));
  if (!covariance || !(at.lens.fx_px > 0) || !(at.lens.fy_px > 0)) {
    fail(fit, "the boards do not tell the focal length: slant them by 30 to 45 degrees, each way");
    return fit;
  }
  fit.covariance = *covariance * (weighted / (2 * corners - unknowns));
  tell_field_sigma(fit);
  std::vector<BoardCorners> kept;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (fit.views[i].used) {
      kept.push_back(views[i]);
    }
  }
  fit.picture_use = picture_use(kept, width_px, height_px, lit);
  judge(fit, options, use_of_halves(used_parts(kept, width_px, height_px), lit));
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
    const double numbers = 2.0 * static_cast<double>(views.size()) * board.corners();
    double squared = 0;  // a picture left out fits as badly as what is just kept
    for (const FittedView& view : fit.views) {
      squared += board.corners() * square(view.used ? view.rms_px : 4 * fit.reprojection_rms_px);
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

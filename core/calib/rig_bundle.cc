// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SparseCore>
#include <ceres/ceres.h>

#include "core/base/check.h"
#include "core/base/median.h"
#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/calib/schur_bundle.h"
#include "core/calib/slides_by_views.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

constexpr double kLeastNoise_px = 0.02;  // no better are points seen, however well a few agree
constexpr std::size_t kFewestToLearn = 20;
// Mountings are held by so little that it counts for nothing beside what is seen of them; but the
// height of one of those that share points, of which a level floor shows nothing.
constexpr double kHeld_m = 0.1;
constexpr double kHeld_rad = 0.2;
constexpr double kFixed_m = 1e-4;
constexpr double kFixed_s = 1e-5;
constexpr Eigen::Index kMountingRows = 6;  // of a camera
constexpr double kFree = 1e3;              // of what a prior says nothing of
constexpr double kFarthest_m = 1e5;        // beyond it a point is a direction
// So that what nothing shows stays where it is, and the normal equations keep a solution.
constexpr double kLargestRadius = 1e12;
// A direction of which a drive tells less than this many of the sigmas that it is believed to is
// not seen: what is believed says more.
constexpr double kWide = 3;

constexpr MotionNoise kLeastNoise{0.0005, 0.0005, 0.001, 0.00002, deg_to_rad(0.002)};
constexpr double kLeastSlide_rad = 1e-5;
constexpr double kStep_m = 0.0003;  // a tick of the wheels
constexpr double kStep_rad = 0.0005;
constexpr double kLeastRolled_m = 0.01;     // less is steps
constexpr double kWheelFromMiddle_m = 0.2;  // about: a turn rolls the wheels too

/// Each loss begins where the one before it has led: only the last needs all digits.
/// digits.
double tolerance_of(Loss loss) {
  return loss == Loss::kHuber ? 1e-3 : loss == Loss::kCauchy ? 1e-4 : 1e-6;
}

/// What the wheels say from an instant to the next.
struct Driven {
  Pose2 T_before_now;
  double way_m = 0;     ///< of the body,
  double rolled_m = 0;  ///< and of its wheels; there and back is twice the way
};

std::optional<Driven> driven(const WheelReadings& wheels, Time from, Time to) {
  constexpr Duration kPiece = std::chrono::milliseconds(50);
  const std::optional<Odometry> first = wheels(from);
  std::optional<Odometry> before = first;
  Driven out;
  for (Time at = from; before && at < to;) {
    at = std::min(at + kPiece, to);
    const std::optional<Odometry> now = wheels(at);
    if (!now) {
      return std::nullopt;
    }
    const Pose2 moved = before->T_odom_body.inverse() * now->T_odom_body;
    out.way_m += moved.position().norm();
    out.rolled_m +=
        std::max(moved.position().norm(), kWheelFromMiddle_m * std::abs(moved.theta_rad));
    out.T_before_now = first->T_odom_body.inverse() * now->T_odom_body;
    before = now;
  }
  return before ? std::optional<Driven>(out) : std::nullopt;
}

WheelSigma sigma_of(const MotionNoise& noise, const Driven& moved) {
  const double root_m = std::sqrt(moved.rolled_m);
  // A heading that wanders evenly leaves its chord by so much of the way.
  const double swung_m = noise.turn_rad * root_m * moved.way_m / std::sqrt(12.0);
  return {std::hypot(kStep_m, noise.way_m * root_m),
          std::hypot(std::hypot(kStep_m, swung_m), noise.across_m * root_m),
          std::hypot(kStep_rad, noise.turn_rad * root_m)};
}

/// A point in start, homogeneous (seen_from) and of length 1, and its slides.
using PointBlock = std::array<double, 4 + kSlides>;
constexpr int kPointMoves = 3 + kSlides;
using PointManifold =
    ceres::ProductManifold<ceres::SphereManifold<4>, ceres::EuclideanManifold<kSlides>>;

/// All that is adjusted, as the solver holds it.
struct Blocks {
  std::vector<PoseBlock> T_body_start;
  std::vector<PoseBlock> T_camera_body;
  std::vector<Eigen::VectorXd> lens;
  std::vector<double> clock_offset_s;
  std::array<double, kWheelErrors> wheel_errors{};
  std::vector<PointBlock> p_start;
};

Eigen::Vector4d point(const PointBlock& block) {
  return Eigen::Map<const Eigen::Vector4d>(block.data());
}

Eigen::Matrix<double, kSlides, 1> slides(const PointBlock& block) {
  return Eigen::Map<const Eigen::Matrix<double, kSlides, 1>>(block.data() + 4);
}

Blocks to_blocks(const RigBundleState& state) {
  Blocks blocks;
  for (const Pose3& T : state.T_start_body) {
    blocks.T_body_start.push_back(to_block(T.inverse()));
  }
  for (const Pose3& T : state.T_body_camera) {
    blocks.T_camera_body.push_back(to_block(T.inverse()));
  }
  for (const Intrinsics& lens : state.lenses) {
    blocks.lens.push_back(lens_parameters(lens));
  }
  blocks.clock_offset_s = state.clock_offset_s;
  for (int i = 0; i < kWheelErrors; ++i) {
    blocks.wheel_errors[static_cast<std::size_t>(i)] = state.wheel_errors[i];
  }
  for (const Vec3& p : state.points_start) {
    const Eigen::Vector4d h = p.homogeneous().normalized();
    blocks.p_start.push_back({h[0], h[1], h[2], h[3]});
  }
  return blocks;
}

RigBundleState to_state(const Blocks& blocks, const RigBundleState& before) {
  RigBundleState state = before;
  for (std::size_t i = 0; i < blocks.T_body_start.size(); ++i) {
    state.T_start_body[i] = from_block(blocks.T_body_start[i].data()).inverse();
  }
  for (std::size_t i = 0; i < blocks.T_camera_body.size(); ++i) {
    state.T_body_camera[i] = from_block(blocks.T_camera_body[i].data()).inverse();
    state.lenses[i] = with_parameters(before.lenses[i], blocks.lens[i]);
  }
  state.clock_offset_s = blocks.clock_offset_s;
  state.wheel_errors = Eigen::Map<const Vec3>(blocks.wheel_errors.data());
  for (std::size_t i = 0; i < blocks.p_start.size(); ++i) {
    const Eigen::Vector4d p = point(blocks.p_start[i]);
    state.points_start[i] = p.head<3>() / std::max(p[3], p.head<3>().norm() / kFarthest_m);
  }
  return state;
}

/// What the wheels say about a view: empty where they do not reach. How fast the body goes is taken
/// at the instant, the same for all of its views: what wheels say of a moment is noisy, and by
/// differences of it pictures would tell clocks.
std::optional<BodyMoved> body_moved(const WheelReadings& wheels, Time instant, Time stamp,
                                    double clock_offset_s) {
  const std::optional<Odometry> then = wheels(instant);
  const std::optional<Odometry> taken = wheels(stamp - from_seconds(clock_offset_s));
  if (!then || !taken) {
    return std::nullopt;
  }
  return BodyMoved{then->T_odom_body.inverse() * taken->T_odom_body, then->twist_body,
                   clock_offset_s};
}

/// Without a way: what wheels wander in a turn on the spot would tell a metre.
Pose2 turn_of(const Pose2& moved) { return {0, 0, moved.theta_rad}; }

/// What is told of some numbers, and how what tells it scatters: the same where all noise is
/// independent, more where what is seen of one point is off together.
struct Scattered {
  Eigen::MatrixXd information;
  Eigen::MatrixXd scatter;
};

class Adjustment {
 public:
  Adjustment(const RigBundleOptions& options, const std::vector<RigCamera>& believed,
             const WheelReadings& wheels, RigTracks& tracks, const RigBundleState& start)
      : options_(options),
        believed_(believed),
        tracks_(tracks),
        state_(start),
        blocks_(to_blocks(start)),
        sigma_px_(2 * believed.size(), 1),
        by_slides_(tracks.seen.size(), BySlides::Zero(3, kSlides)) {
    PANOPTES_CHECK(start.T_body_camera.size() == believed.size() &&
                       start.T_start_body.size() == tracks.instants.size(),
                   "a state of the cameras and instants of the tracks");
    std::vector<std::optional<Pose2>> poses;
    for (const Time instant : tracks.instants) {
      const std::optional<Odometry> here = wheels(instant);
      poses.push_back(here ? std::optional<Pose2>(here->T_odom_body) : std::nullopt);
    }
    const bool is_turn = options.has_wheels && !tells_metre(poses);
    no_metre_ = is_turn || !options.has_wheels;
    for (const RigView& view : tracks.views) {
      moved_.push_back(body_moved(wheels, tracks.instants[view.instant], view.stamp,
                                  start.clock_offset_s[view.camera]));
      if (is_turn && moved_.back()) {
        moved_.back()->T_instant_taken = turn_of(moved_.back()->T_instant_taken);
        moved_.back()->twist_body.v_mps = 0;
      }
    }
    for (std::size_t i = 0; i + 1 < tracks.instants.size(); ++i) {
      driven_.push_back(options.has_wheels
                            ? driven(wheels, tracks.instants[i], tracks.instants[i + 1])
                            : std::nullopt);
      if (is_turn && driven_.back()) {
        driven_.back()->T_before_now = turn_of(driven_.back()->T_before_now);
      }
    }
    camera_of_point_.assign(start.points_start.size(), 0);
    for (RigSeen& seen : tracks.seen) {
      seen.believed = off_px(seen).has_value();
      if (seen.own) {
        camera_of_point_[seen.point] = tracks.views[seen.view].camera;
      }
    }
    leave_out_what_is_seen_once();
    compare_views();
  }

  RigBundle run() {
    RigBundle out;
    for (const Loss loss : {Loss::kHuber, Loss::kCauchy}) {
      learn_noise();
      solve(loss);
    }
    // What is believed is judged twice: the second time without what the first left out.
    constexpr int kJudged = 2;
    for (int i = 0; i < kJudged; ++i) {
      learn_noise();
      judge();
      out.converged = solve(Loss::kSquare);
    }
    learn_noise();
    put_at_believed_height();
    Told told = what_is_told();
    if (const auto kept = as_believed(told)) {
      out.converged = solve(Loss::kSquare, &*kept);  // before, it may have slid along them
      told = what_is_told();
    }
    const Blocks adjusted = blocks_;
    blocks_ = to_blocks(to_state(adjusted, state_));  // without slides
    out.rms_after_px = rms_px();
    blocks_ = to_blocks(state_);
    out.rms_before_px = rms_px();
    blocks_ = adjusted;
    report(told, out);
    return out;
  }

  RigBundle expect(const RigNoise& noise) {
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      sigma_px_[2 * c] = noise.own_px;
      sigma_px_[2 * c + 1] = noise.other_px;
    }
    noise_ = noise.motion;
    slide_rad_ = std::max(noise.slide_rad, kLeastSlide_rad);
    RigBundle out;
    out.converged = true;
    report(what_is_told(), out);
    return out;
  }

 private:
  std::size_t group(const RigSeen& seen) const {
    return 2 * tracks_.views[seen.view].camera + (seen.own ? 0 : 1);
  }

  std::optional<Vec2> off_px(const RigSeen& seen) const {
    Vec2 off;
    if (!moved_[seen.view] ||
        !reprojection(seen)->Evaluate(blocks_of(seen).data(), off.data(), nullptr)) {
      return std::nullopt;
    }
    return sigma_px_[group(seen)] * off;
  }

  std::unique_ptr<ceres::CostFunction> reprojection(const RigSeen& seen) const {
    return std::unique_ptr<ceres::CostFunction>(
        rig_reprojection_cost(state_.lenses[tracks_.views[seen.view].camera], seen.px,
                              sigma_px_[group(seen)], *moved_[seen.view], by_slides(seen)));
  }

  std::array<const double*, 6> blocks_of(const RigSeen& seen) const {
    const RigView& view = tracks_.views[seen.view];
    return {blocks_.lens[view.camera].data(),
            blocks_.T_camera_body[view.camera].data(),
            blocks_.T_body_start[view.instant].data(),
            &blocks_.clock_offset_s[view.camera],
            blocks_.wheel_errors.data(),
            blocks_.p_start[seen.point].data()};
  }

  const BySlides& by_slides(const RigSeen& seen) const {
    return by_slides_[static_cast<std::size_t>(&seen - tracks_.seen.data())];
  }

  /// From how near and from where aside each view sees each of its points, beside the others.
  void compare_views() {
    std::vector<Vec3> p_camera_start;  // by view
    for (const RigView& view : tracks_.views) {
      p_camera_start.push_back((from_block(blocks_.T_camera_body[view.camera].data()) *
                                from_block(blocks_.T_body_start[view.instant].data()))
                                   .inverse()
                                   .translation);
    }
    std::vector<Vec3> ray_start;
    for (const RigSeen& seen : tracks_.seen) {
      const Eigen::Vector4d p = point(blocks_.p_start[seen.point]);
      ray_start.emplace_back(p.head<3>() - p[3] * p_camera_start[seen.view]);
    }
    by_slides_ = slides_by_views(tracks_.seen, ray_start, blocks_.p_start.size());
  }

  /// What one picture alone shows tells nothing.
  void leave_out_what_is_seen_once() {
    std::vector<int> times(blocks_.p_start.size(), 0);
    for (const RigSeen& seen : tracks_.seen) {
      times[seen.point] += seen.believed ? 1 : 0;
    }
    for (RigSeen& seen : tracks_.seen) {
      seen.believed = seen.believed && times[seen.point] > 1;
    }
  }

  double rms_px() const {
    double sum = 0;
    int count = 0;
    for (const RigSeen& seen : tracks_.seen) {
      if (const auto off = seen.believed ? off_px(seen) : std::nullopt) {
        sum += off->squaredNorm();
        ++count;
      }
    }
    return count > 0 ? std::sqrt(sum / count) : 0;
  }

  // By medians: what is false hardly counts.
  void learn_noise() {
    std::vector<std::vector<double>> squares(sigma_px_.size());
    for (const RigSeen& seen : tracks_.seen) {
      if (const auto off = off_px(seen)) {
        squares[group(seen)].push_back(off->squaredNorm());
      }
    }
    for (std::size_t g = 0; g < squares.size(); ++g) {
      if (squares[g].size() >= kFewestToLearn) {
        sigma_px_[g] = std::max(kLeastNoise_px, sigma_by_median(squares[g]));
      }
    }
    learn_slides();
    // What a motion is off by, as shares of what noise of one would make of it: only what is more
    // than a step of the wheels tells of it.
    std::vector<double> along;
    std::vector<double> across;
    std::vector<double> turn;
    std::vector<double> height;
    std::vector<double> tilt;
    for (std::size_t i = 0; i < tracks_.instants.size(); ++i) {
      const Pose3 T = from_block(blocks_.T_body_start[i].data());
      const Vec3 up = T.rotation * Vec3::UnitZ();
      tilt.push_back(up.head<2>().squaredNorm());
      height.push_back(std::abs(up.dot(T.translation)) / (1 + blocks_.wheel_errors[kWayError]));
      if (i + 1 < tracks_.instants.size() && driven_[i]) {
        const std::unique_ptr<ceres::CostFunction> cost(wheels_cost(driven_[i]->T_before_now, {}));
        const double* all[] = {blocks_.T_body_start[i].data(), blocks_.T_body_start[i + 1].data(),
                               blocks_.wheel_errors.data()};
        Vec3 off;
        cost->Evaluate(all, off.data(), nullptr);
        if (driven_[i]->rolled_m > kLeastRolled_m) {
          const double root_m = std::sqrt(driven_[i]->rolled_m);
          along.push_back(std::abs(off.x()) / root_m);
          across.push_back(std::abs(off.y()) / root_m);
          turn.push_back(std::abs(off.z()) / root_m);
        }
      }
    }
    const auto learn = [](double& sigma, double least, const std::vector<double>& off) {
      constexpr double kMedianOfNormal = 0.6745;
      if (off.size() >= kFewestToLearn) {
        sigma = std::max(least, median(std::vector<double>(off)) / kMedianOfNormal);
      }
    };
    learn(noise_.way_m, kLeastNoise.way_m, along);
    learn(noise_.across_m, kLeastNoise.across_m, across);
    learn(noise_.turn_rad, kLeastNoise.turn_rad, turn);
    learn(noise_.height_m, kLeastNoise.height_m, height);
    if (tilt.size() >= kFewestToLearn) {
      noise_.tilt_rad = std::max(kLeastNoise.tilt_rad, sigma_by_median(tilt));
    }
  }

  /// What the pictures tell of each point and its slides alone: the rows are its block's.
  struct PointTold {
    using Square = Eigen::Matrix<double, 4 + kSlides, 4 + kSlides>;
    Square information = Square::Zero();
    Eigen::Matrix<double, 4 + kSlides, 1> gradient = Eigen::Matrix<double, 4 + kSlides, 1>::Zero();
    int count = 0;
  };

  std::vector<PointTold> points_told() const {
    std::vector<PointTold> told(blocks_.p_start.size());
    for (const RigSeen& seen : tracks_.seen) {
      if (seen.believed) {
        Vec2 r;
        Eigen::Matrix<double, 2, 4 + kSlides, Eigen::RowMajor> J;
        double* by[] = {nullptr, nullptr, nullptr, nullptr, nullptr, J.data()};
        if (reprojection(seen)->Evaluate(blocks_of(seen).data(), r.data(), by)) {
          told[seen.point].information += J.transpose() * J;
          told[seen.point].gradient += J.transpose() * r;
          ++told[seen.point].count;
        }
      }
    }
    for (std::size_t i = 0; i < told.size(); ++i) {
      // Along p nothing is told, and it stays of length 1.
      const Eigen::Vector4d p = point(blocks_.p_start[i]);
      told[i].information.topLeftCorner<4, 4>() +=
          told[i].information.topLeftCorner<4, 4>().trace() * p * p.transpose();
    }
    return told;
  }

  // By the points that tell it best: what they would slide by without what is known of it before.
  void learn_slides() {
    constexpr double kSingular = 1e-12;
    std::vector<std::array<double, 2>> variance_and_square;
    const std::vector<PointTold> told = points_told();
    for (std::size_t i = 0; i < told.size(); ++i) {
      const Eigen::LDLT<PointTold::Square> solved(told[i].information);
      if (2 * told[i].count > 4 + kSlides && solved.info() == Eigen::Success &&
          solved.rcond() > kSingular) {
        const PointTold::Square covariance = solved.solve(PointTold::Square::Identity());
        const Eigen::Matrix<double, kSlides, 1> slid =
            slides(blocks_.p_start[i]) - (covariance * told[i].gradient).tail<kSlides>();
        for (const int k : {0, 1}) {  // as it is nearer: aside, its distance explains as well
          variance_and_square.push_back({covariance(4 + k, 4 + k), slid[k] * slid[k]});
        }
      }
    }
    if (variance_and_square.size() < 2 * kFewestToLearn) {
      return;
    }
    std::sort(variance_and_square.begin(), variance_and_square.end());
    variance_and_square.resize(variance_and_square.size() / 2);
    std::vector<double> squares;
    std::vector<double> variances;
    for (const auto& [variance, square] : variance_and_square) {
      variances.push_back(variance);
      squares.push_back(square);
    }
    constexpr double kMedianSquareOfNormal = 0.4549;
    slide_rad_ = std::sqrt(std::max(
        kLeastSlide_rad * kLeastSlide_rad,
        median(std::move(squares)) / kMedianSquareOfNormal - median(std::move(variances))));
  }

  /// For each camera the first of those that it shares points with, over others too: by a
  /// camera's height alone they are all higher.
  std::vector<std::size_t> sharing() const {
    const std::size_t count = believed_.size();
    std::vector<std::vector<int>> shared(count, std::vector<int>(count, 0));
    for (const RigSeen& seen : tracks_.seen) {
      if (seen.believed && !seen.own) {
        ++shared[tracks_.views[seen.view].camera][camera_of_point_[seen.point]];
      }
    }
    std::vector<std::size_t> first(count);
    std::iota(first.begin(), first.end(), std::size_t{0});
    for (std::size_t again = 0; again < count; ++again) {
      for (std::size_t a = 0; a < count; ++a) {
        for (std::size_t b = 0; b < count; ++b) {
          if (shared[a][b] + shared[b][a] >= kFewestShared) {
            first[a] = first[b] = std::min(first[a], first[b]);
          }
        }
      }
    }
    return first;
  }

  /// A height that all of those share is the one that was believed of them, on the mean.
  void put_at_believed_height() {
    const std::vector<std::size_t> first = sharing();
    std::vector<double> off_m(first.size(), 0);
    std::vector<int> count(first.size(), 0);
    RigBundleState state = to_state(blocks_, state_);
    for (std::size_t c = 0; c < first.size(); ++c) {
      off_m[first[c]] +=
          believed_[c].T_body_camera.translation.z() - state.T_body_camera[c].translation.z();
      ++count[first[c]];
    }
    for (std::size_t c = 0; c < first.size(); ++c) {
      state.T_body_camera[c].translation.z() += off_m[first[c]] / count[first[c]];
    }
    const std::vector<PointBlock> before = blocks_.p_start;
    for (std::size_t p = 0; p < state.points_start.size(); ++p) {
      const std::size_t of = first[camera_of_point_[p]];
      state.points_start[p].z() += off_m[of] / count[of];
    }
    blocks_ = to_blocks(state);
    for (std::size_t p = 0; p < before.size(); ++p) {
      std::copy(before[p].begin() + 4, before[p].end(), blocks_.p_start[p].begin() + 4);
    }
  }

  void judge() {
    for (RigSeen& seen : tracks_.seen) {
      const std::optional<Vec2> off = off_px(seen);
      seen.believed =
          off && off->norm() < options_.inlier_sigma * std::sqrt(2.0) * sigma_px_[group(seen)];
    }
    leave_out_what_is_seen_once();
  }

  Vec3 wheels_known() const {
    Vec3 sigma = options_.wheels.sigma;
    sigma[kWayError] = no_metre_ ? 1 : sigma[kWayError];
    return sigma;
  }

  /// All but what holds the mountings.
  void build(ceres::Problem& problem, Loss loss) {
    for (PoseBlock& block : blocks_.T_body_start) {
      add_pose(problem, block);
      problem.AddResidualBlock(level_cost(noise_.height_m, noise_.tilt_rad), nullptr, block.data(),
                               blocks_.wheel_errors.data());
    }
    problem.AddResidualBlock(start_cost(), nullptr, blocks_.T_body_start.front().data());
    problem.AddParameterBlock(blocks_.wheel_errors.data(), kWheelErrors);
    for (std::size_t i = 0; i < driven_.size(); ++i) {
      if (driven_[i]) {
        problem.AddResidualBlock(
            wheels_cost(driven_[i]->T_before_now, sigma_of(noise_, *driven_[i])),
            made(Loss::kHuber), blocks_.T_body_start[i].data(), blocks_.T_body_start[i + 1].data(),
            blocks_.wheel_errors.data());
      }
    }
    problem.AddResidualBlock(known_cost(Vec3::Zero(), wheels_known()), nullptr,
                             blocks_.wheel_errors.data());
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      const RigCamera& camera = believed_[c];
      add_pose(problem, blocks_.T_camera_body[c]);
      if (options_.before.size() == 0) {
        problem.AddResidualBlock(lens_known_cost(camera.intrinsics, camera.sigma), nullptr,
                                 blocks_.lens[c].data());
        problem.AddResidualBlock(known_cost(Eigen::VectorXd::Constant(1, camera.clock_offset_s),
                                            Eigen::VectorXd::Constant(1, camera.sigma.clock_s)),
                                 nullptr, &blocks_.clock_offset_s[c]);
      }
    }
    if (options_.before.size() > 0) {
      know_together(problem);
    }
    ceres::Manifold* of_points = nullptr;
    for (const RigSeen& seen : tracks_.seen) {
      if (seen.believed) {
        const RigView& view = tracks_.views[seen.view];
        const std::size_t c = view.camera;
        double* p_start = blocks_.p_start[seen.point].data();
        if (!problem.HasParameterBlock(p_start)) {
          of_points = of_points != nullptr ? of_points : new PointManifold;
          problem.AddParameterBlock(p_start, 4 + kSlides, of_points);
          for (int first = 0; first < kSlides; first += 2) {
            problem.AddResidualBlock(slides_cost(first, slide_rad_), nullptr, p_start);
          }
        }
        problem.AddResidualBlock(reprojection(seen).release(), made(loss), blocks_.lens[c].data(),
                                 blocks_.T_camera_body[c].data(),
                                 blocks_.T_body_start[view.instant].data(),
                                 &blocks_.clock_offset_s[c], blocks_.wheel_errors.data(), p_start);
      }
    }
  }

  void fix_metre(ceres::Problem& problem, const std::vector<std::size_t>& first) {
    constexpr double kFixed = 1e-6;
    problem.AddResidualBlock(known_cost(Vec3::Zero(), Vec3(kFixed, kFree, kFree)), nullptr,
                             blocks_.wheel_errors.data());
    if (options_.has_wheels) {
      fix_places(problem, first);
    } else {
      fix_way(problem);
    }
  }

  /// Without wheels nothing tells what all clocks are off by together: nothing on the mean, each
  /// weighted by what is known of it.
  void keep_clocks(ceres::Problem& problem) {
    std::vector<Eigen::VectorXd> believed_s;
    std::vector<double*> all;
    Eigen::RowVectorXd weight(static_cast<Eigen::Index>(believed_.size()));
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      believed_s.push_back(Eigen::VectorXd::Constant(1, believed_[c].clock_offset_s));
      weight[static_cast<Eigen::Index>(c)] = std::pow(believed_[c].sigma.clock_s, -2);
      all.push_back(&blocks_.clock_offset_s[c]);
    }
    problem.AddResidualBlock(known_together_cost(believed_s, weight / (weight.sum() * kFixed_s)),
                             nullptr, all);
  }

  /// Lenses and clocks, as a calibration before has left them.
  void know_together(ceres::Problem& problem) {
    const RigCovariance at = rows();
    std::vector<Eigen::VectorXd> believed;
    std::vector<double*> all;
    std::vector<Eigen::Index> row;
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      believed.push_back(lens_parameters(believed_[c].intrinsics));
      believed.push_back(Eigen::VectorXd::Constant(1, believed_[c].clock_offset_s));
      all.insert(all.end(), {blocks_.lens[c].data(), &blocks_.clock_offset_s[c]});
      for (Eigen::Index i = 0; i <= blocks_.lens[c].size(); ++i) {
        row.push_back(at.camera[c] + kMountingRows + i);
      }
    }
    const Eigen::MatrixXd before = options_.before(row, row);
    const Eigen::VectorXd sigma = before.diagonal().cwiseSqrt();
    const Eigen::MatrixXd together =
        sigma.cwiseInverse().asDiagonal() * before * sigma.cwiseInverse().asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> root(together);
    const Eigen::MatrixXd weight =
        root.matrixL().solve(Eigen::MatrixXd(sigma.cwiseInverse().asDiagonal()));
    problem.AddResidualBlock(known_together_cost(believed, weight), nullptr, all);
  }

  void fix_place(ceres::Problem& problem, std::size_t c) {
    problem.AddResidualBlock(
        mounting_known_cost(believed_[c].T_body_camera, kFree, Vec3(kFixed_m, kFixed_m, kFree)),
        nullptr, blocks_.T_camera_body[c].data());
  }

  /// Without wheels the body is where one camera's place says, and that camera goes as far as it
  /// did to begin with: the one that goes farthest from where it starts.
  void fix_way(ceres::Problem& problem) {
    std::size_t farthest = 0;
    std::size_t there = 0;
    double away_m = 0;
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      const Vec3& p_body = state_.T_body_camera[c].translation;
      for (std::size_t i = 0; i < state_.T_start_body.size(); ++i) {
        const double here_m = (state_.T_start_body[i] * p_body - p_body).norm();
        if (here_m > away_m) {
          farthest = c;
          there = i;
          away_m = here_m;
        }
      }
    }
    fix_place(problem, farthest);
    problem.AddResidualBlock(
        away_cost(state_.T_body_camera[farthest].translation, away_m, kFixed_m), nullptr,
        blocks_.T_body_start[there].data());
  }

  /// By the place of one camera of each of those that share points: what wanders would shrink it.
  void fix_places(ceres::Problem& problem, const std::vector<std::size_t>& first) {
    const auto far_m = [this](std::size_t c) {
      return believed_[c].T_body_camera.translation.head<2>().norm();
    };
    for (std::size_t of = 0; of < first.size(); ++of) {
      std::size_t farthest = of;
      for (std::size_t c = 0; c < first.size(); ++c) {
        farthest = first[c] == of && far_m(c) > far_m(farthest) ? c : farthest;
      }
      if (first[of] == of) {
        fix_place(problem, farthest);
      }
    }
  }

  /// Mountings along the directions of which nothing is told, each a row (mountings_kept_cost).
  struct Kept {
    std::vector<Pose3> T_body_camera;
    Eigen::MatrixXd directions;
  };

  bool solve(Loss loss, const Kept* kept = nullptr) {
    compare_views();
    ceres::Problem problem;
    build(problem, loss);
    const std::vector<std::size_t> first = sharing();
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      const bool fixed = kept == nullptr && first[c] == c;
      problem.AddResidualBlock(
          mounting_known_cost(believed_[c].T_body_camera, kHeld_rad,
                              Vec3(kHeld_m, kHeld_m, fixed ? kFixed_m : kHeld_m)),
          nullptr, blocks_.T_camera_body[c].data());
    }
    if (kept != nullptr) {
      std::vector<double*> all;
      for (PoseBlock& block : blocks_.T_camera_body) {
        all.push_back(block.data());
      }
      problem.AddResidualBlock(mountings_kept_cost(kept->T_body_camera, kept->directions), nullptr,
                               all);
    } else if (no_metre_) {
      fix_metre(problem, first);
    }
    if (!options_.has_wheels) {
      keep_clocks(problem);
    }
    auto order = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& p : blocks_.p_start) {
      if (problem.HasParameterBlock(p.data())) {
        order->AddElementToGroup(p.data(), 0);
      }
    }
    for (auto& T : blocks_.T_body_start) {
      order->AddElementToGroup(T.data(), 1);
    }
    // Within a group, addresses order: one for each kind.
    int next = 2;
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      order->AddElementToGroup(blocks_.T_camera_body[c].data(), next++);
      order->AddElementToGroup(blocks_.lens[c].data(), next++);
      order->AddElementToGroup(&blocks_.clock_offset_s[c], next++);
    }
    order->AddElementToGroup(blocks_.wheel_errors.data(), next);
    return solve_by_schur(problem, order, {options_.iterations, tolerance_of(loss), kLargestRadius},
                          options_.each_step);
  }

  /// What is told of the rig, with what is not: the rows are RigCovariance's.
  struct Told {
    Eigen::MatrixXd covariance;  ///< of what is seen
    Eigen::MatrixXd open;        ///< directions that are not, in `unit`s; orthonormal columns
    Eigen::VectorXd unit;
  };

  /// What is told of the rig, in the bundle.
  void report(const Told& told, RigBundle& out) const {
    for (const RigSeen& seen : tracks_.seen) {
      out.observations += seen.believed ? 1 : 0;
      out.observations_other += seen.believed && !seen.own ? 1 : 0;
    }
    out.without_wheels = static_cast<int>(std::count_if(
        driven_.begin(), driven_.end(), [](const auto& stretch) { return !stretch; }));
    out.has_wheels = options_.has_wheels;
    out.tells_metre = !no_metre_;
    out.left_out = static_cast<int>(tracks_.seen.size()) - out.observations;
    for (std::size_t c = 0; c < believed_.size(); ++c) {
      out.sigma_own_px.push_back(sigma_px_[2 * c]);
      out.sigma_other_px.push_back(sigma_px_[2 * c + 1]);
    }
    out.slide_rad = slide_rad_;
    out.state = to_state(blocks_, state_);
    out.state.wheel_errors[kWayError] *= no_metre_ ? 0 : 1;
    out.known = covariance(told);
  }

  RigCovariance rows() const;
  Scattered information();
  Eigen::VectorXd sigmas() const;
  Eigen::MatrixXd mounting_precision() const;
  Eigen::MatrixXd systematic() const;
  void make_directions();
  Told what_is_told();
  std::optional<Kept> as_believed(const Told& told) const;
  std::vector<std::vector<std::string>> named(const Eigen::MatrixXd& open) const;
  RigCovariance covariance(const Told& told) const;

  RigBundleOptions options_;
  const std::vector<RigCamera>& believed_;
  RigTracks& tracks_;
  RigBundleState state_;
  Blocks blocks_;
  std::vector<std::optional<BodyMoved>> moved_;  // by view
  std::vector<std::optional<Driven>> driven_;    // from each instant to the next
  std::vector<std::size_t> camera_of_point_;
  std::vector<double> sigma_px_;  // by group
  MotionNoise noise_;
  double slide_rad_ = kLeastSlide_rad;
  std::vector<BySlides> by_slides_;  // by what is seen
  bool no_metre_ = false;            // a turn on the spot, or no wheels
};

/// Points that are about at one place, of one map or of several, by the number of it: what is seen
/// of the same thing is off together.
std::vector<std::size_t> places(const std::vector<Vec3>& points) {
  constexpr double kPlace = 0.05;  // of the way to most points
  std::vector<double> away_m;
  for (const Vec3& p : points) {
    away_m.push_back(p.norm());
  }
  const double place_m = points.empty() ? 1 : kPlace * median(std::move(away_m));
  std::map<std::array<double, 3>, std::size_t> numbers;
  std::vector<std::size_t> out;
  for (const Vec3& p : points) {
    const Vec3 at = (p / place_m).array().floor();
    out.push_back(numbers.try_emplace({at.x(), at.y(), at.z()}, numbers.size()).first->second);
  }
  return out;
}

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// What the rows of a Jacobian tell of all but the points: each point is eliminated by its own
/// rows' QR, which keeps the digits that the normal equations of what is hardly seen lose. The
/// scatter is that of the points' gradients (Liang and Zeger 1986), summed over each cluster of
/// points, of the size that the residuals have on the whole.
Scattered information_without_points(const SparseRows& J, const std::vector<double>& residuals,
                                     Eigen::Index all_but_points,
                                     const std::vector<std::size_t>& cluster_of_point) {
  // Lower halves.
  Eigen::MatrixXd others = Eigen::MatrixXd::Zero(all_but_points, all_but_points);
  Eigen::MatrixXd by_points = others;                // what the points' rows tell,
  Eigen::MatrixXd scatter = others;                  // and how their gradients scatter
  std::map<std::size_t, Eigen::VectorXd> gradients;  // by cluster
  // What tells of points themselves, a few at a time, which is faster.
  Eigen::MatrixXd eliminated(all_but_points, 64 * kPointMoves);
  Eigen::Index filled = 0;
  const auto take_away = [&] {
    if (filled > 0) {  // Eigen 3.4 divides by it
      by_points.selfadjointView<Eigen::Lower>().rankUpdate(eliminated.leftCols(filled), -1);
    }
    filled = 0;
  };
  double squares = 0;
  double freedom = 0;
  std::map<Eigen::Index, std::vector<Eigen::Index>> rows_of_point;
  for (Eigen::Index row = 0; row < J.outerSize(); ++row) {
    Eigen::Index last = -1;
    for (SparseRows::InnerIterator it(J, row); it; ++it) {
      last = std::max<Eigen::Index>(last, it.col());
    }
    rows_of_point[last < all_but_points ? -1 : (last - all_but_points) / kPointMoves].push_back(
        row);
  }
  for (const auto& [point, rows] : rows_of_point) {
    const auto count = static_cast<Eigen::Index>(rows.size());
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(count, kPointMoves);
    Eigen::VectorXd r(count);
    Eigen::MatrixXd& told = point < 0 ? others : by_points;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index row = rows[static_cast<std::size_t>(i)];
      r[i] = residuals[static_cast<std::size_t>(row)];
      for (SparseRows::InnerIterator a(J, row); a; ++a) {
        if (a.col() >= all_but_points) {
          B(i, a.col() - all_but_points - kPointMoves * point) = a.value();
          continue;
        }
        for (SparseRows::InnerIterator b(J, row); b; ++b) {
          if (b.col() >= a.col() && b.col() < all_but_points) {
            told(b.col(), a.col()) += a.value() * b.value();
          }
        }
      }
    }
    if (point < 0) {
      continue;
    }
    // Of one that is seen from one place alone, no distance is to be eliminated.
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(B);
    const Eigen::Index rank = qr.rank();
    const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(count, rank);
    r -= (Q * (Q.transpose() * r)).eval();
    squares += r.squaredNorm();
    freedom += static_cast<double>(count - rank);
    if (filled + rank > eliminated.cols()) {
      take_away();
    }
    auto W = eliminated.middleCols(filled, rank);
    W.setZero();
    filled += rank;
    Eigen::VectorXd& gradient = gradients[cluster_of_point[static_cast<std::size_t>(point)]];
    gradient = gradient.size() > 0 ? gradient : Eigen::VectorXd::Zero(all_but_points);
    for (Eigen::Index i = 0; i < count; ++i) {
      for (SparseRows::InnerIterator it(J, rows[static_cast<std::size_t>(i)]); it; ++it) {
        if (it.col() < all_but_points) {
          W.row(it.col()) += it.value() * Q.row(i);
          gradient[it.col()] += it.value() * r[i];
        }
      }
    }
  }
  take_away();
  for (const auto& [cluster, gradient] : gradients) {
    scatter.selfadjointView<Eigen::Lower>().rankUpdate(gradient);
  }
  const Eigen::MatrixXd of_points =
      squares > 0 ? Eigen::MatrixXd(freedom / squares * scatter) : by_points;
  const auto whole = [](const Eigen::MatrixXd& lower) {
    return Eigen::MatrixXd(lower.selfadjointView<Eigen::Lower>());
  };
  return {whole(others + by_points), whole(others + of_points)};
}

RigCovariance Adjustment::rows() const {
  RigCovariance out;
  for (const Eigen::VectorXd& lens : blocks_.lens) {
    out.camera.push_back(out.wheels);
    out.wheels += 6 + lens.size() + 1;
  }
  return out;
}

/// A point that may as well be infinitely far is a direction: noise of many distances would tell of
/// places what no picture shows.
void Adjustment::make_directions() {
  const std::vector<PointTold> told = points_told();
  for (std::size_t i = 0; i < told.size(); ++i) {
    Eigen::Map<Eigen::Vector4d> p(blocks_.p_start[i].data());
    const double by_w =
        told[i].information.topLeftCorner<4, 4>().ldlt().solve(Eigen::Vector4d::UnitW())[3];
    constexpr double kSigmas = 3;
    if (!(p[3] * p[3] > kSigmas * kSigmas * by_w)) {
      p[3] = 0;
      p.normalize();
    }
  }
}

// The points are eliminated first, then the poses (Schur): what is left tells of the rig alone.
Scattered Adjustment::information() {
  const RigCovariance at = rows();
  const Eigen::Index rig = at.wheels + kWheelErrors;
  const auto points = blocks_.p_start;
  ceres::Problem problem;
  build(problem, Loss::kSquare);
  ceres::Problem::EvaluateOptions how;
  how.apply_loss_function = false;
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    how.parameter_blocks.insert(
        how.parameter_blocks.end(),
        {blocks_.T_camera_body[c].data(), blocks_.lens[c].data(), &blocks_.clock_offset_s[c]});
  }
  how.parameter_blocks.push_back(blocks_.wheel_errors.data());
  for (PoseBlock& block : blocks_.T_body_start) {
    how.parameter_blocks.push_back(block.data());
  }
  const Eigen::Index poses = 6 * static_cast<Eigen::Index>(blocks_.T_body_start.size());
  const std::vector<std::size_t> clusters = places(to_state(blocks_, state_).points_start);
  std::vector<std::size_t> cluster_of_point;
  for (std::size_t i = 0; i < blocks_.p_start.size(); ++i) {
    if (problem.HasParameterBlock(blocks_.p_start[i].data())) {
      how.parameter_blocks.push_back(blocks_.p_start[i].data());
      cluster_of_point.push_back(clusters[i]);
    }
  }
  std::vector<double> residuals;
  problem.Evaluate(how, nullptr, &residuals, nullptr, nullptr);
  make_directions();
  ceres::CRSMatrix crs;
  problem.Evaluate(how, nullptr, nullptr, nullptr, &crs);
  blocks_.p_start = points;
  const SparseRows J =
      Eigen::Map<const SparseRows>(crs.num_rows, crs.num_cols, static_cast<int>(crs.values.size()),
                                   crs.rows.data(), crs.cols.data(), crs.values.data());
  // What is common to cameras and poses is a small difference of large numbers.
  using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Eigen::MatrixXd G = Eigen::MatrixXd::Identity(rig, rig);  // to the body's own axes
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    G.block<6, 6>(at.camera[c], at.camera[c]) =
        mounting_by_moves(from_block(blocks_.T_camera_body[c].data()).inverse());
  }
  const Scattered all = information_without_points(J, residuals, rig + poses, cluster_of_point);
  const Long S = all.information.cast<long double>();
  const Long B = S.topRightCorner(rig, poses);
  const Long by_poses = S.bottomRightCorner(poses, poses).ldlt().solve(B.transpose());
  const Long left = S.topLeftCorner(rig, rig) - B * by_poses;
  const Long G_inverse = G.inverse().cast<long double>();
  const Eigen::MatrixXd told = (G_inverse.transpose() * left * G_inverse).cast<double>();
  Eigen::MatrixXd onto(rig + poses, rig);  // the rig alone, whatever the poses
  onto << G_inverse.cast<double>(), -(by_poses * G_inverse).cast<double>();
  return {0.5 * (told + told.transpose()), onto.transpose() * all.scatter * onto};
}

/// As all is believed to be before anything is seen.
Eigen::VectorXd Adjustment::sigmas() const {
  const RigCovariance at = rows();
  Eigen::VectorXd sigma(at.wheels + kWheelErrors);
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    const Eigen::VectorXd of = sigmas_before(believed_[c].sigma, blocks_.lens[c]);
    sigma.segment(at.camera[c], of.size()) = of;
  }
  if (options_.before.size() > 0) {
    sigma.head(at.wheels) = options_.before.diagonal().cwiseSqrt();
  }
  sigma.tail<kWheelErrors>() = wheels_known();
  return sigma;
}

/// Of mountings, which are held by nothing else.
Eigen::MatrixXd Adjustment::mounting_precision() const {
  const RigCovariance at = rows();
  const Eigen::VectorXd sigma = sigmas();
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(sigma.size(), sigma.size());
  std::vector<Eigen::Index> mounting;
  for (const Eigen::Index camera : at.camera) {
    for (Eigen::Index i = camera; i < camera + kMountingRows; ++i) {
      mounting.push_back(i);
      precision(i, i) = 1 / (sigma[i] * sigma[i]);
    }
  }
  if (options_.before.size() > 0) {
    const Eigen::VectorXd by = sigma(mounting).cwiseInverse();
    const Eigen::MatrixXd together =
        by.asDiagonal() * Eigen::MatrixXd(options_.before(mounting, mounting)) * by.asDiagonal();
    precision(mounting, mounting) =
        by.asDiagonal() * Eigen::MatrixXd(together.inverse()) * by.asDiagonal();
  }
  return precision;
}

/// What no run makes surer, as the root of a covariance: of each number by itself, then of all
/// cameras together about the body's axes.
Eigen::MatrixXd Adjustment::systematic() const {
  const RigCovariance at = rows();
  std::vector<std::vector<double>> away_m(believed_.size());
  for (const RigSeen& seen : tracks_.seen) {
    if (seen.believed) {
      const RigView& view = tracks_.views[seen.view];
      const Eigen::Vector4d p_body =
          seen_from(from_block(blocks_.T_body_start[view.instant].data()),
                    point(blocks_.p_start[seen.point]));
      const double far_m = p_body.head<3>().norm();
      away_m[view.camera].push_back(far_m / std::max(p_body[3], far_m / kFarthest_m));
    }
  }
  const Eigen::Index rig = at.wheels + kWheelErrors;
  const Eigen::VectorXd before = sigmas();
  Eigen::VectorXd sigma = Eigen::VectorXd::Zero(rig);
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(rig, 3);
  const double together_rad = options_.systematic_lens_px / state_.lenses.front().fx_px;
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    const Intrinsics& lens = state_.lenses[c];
    const double turn_rad = options_.systematic_mounting_px / lens.fx_px;
    auto of = sigma.segment<10>(at.camera[c]);
    of.head<3>().setConstant(turn_rad);
    of.segment<3>(3).setConstant(away_m[c].empty() ? 0 : turn_rad * median(away_m[c]));
    of.segment<2>(6).setConstant(options_.systematic_lens_px * lens.fx_px /
                                 (0.5 * lens.width_px));  // at the picture's edge
    of.segment<2>(8).setConstant(options_.systematic_lens_px);
    const double edge_px = 0.5 * lens.width_px * std::numbers::sqrt2 / 2;
    if (const auto edge = lens.direction(Vec2(lens.cx_px + edge_px, lens.cy_px + edge_px))) {
      const auto by_lens = project_with_jacobian(lens, *edge).px_by_lens;
      for (Eigen::Index i = 4; i < by_lens.cols(); ++i) {
        sigma[at.camera[c] + kMountingRows + i] =
            options_.systematic_distortion_px / by_lens.col(i).norm();
      }
    }
    // A lens that is known better than that before stays so, and is no open direction.
    const Eigen::Index lens_row = at.camera[c] + kMountingRows;
    const Eigen::Index count = blocks_.lens[c].size();
    sigma.segment(lens_row, count) =
        sigma.segment(lens_row, count).cwiseMin(before.segment(lens_row, count));
    const Vec3 t = from_block(blocks_.T_camera_body[c].data()).inverse().translation;
    together.block<3, 3>(at.camera[c], 0) = together_rad * Mat3::Identity();
    together.block<3, 3>(at.camera[c] + 3, 0) = -together_rad * cross_matrix(t);
  }
  Eigen::MatrixXd root(rig, rig + 3);
  root << Eigen::MatrixXd(sigma.asDiagonal()), together;
  return root;
}

Adjustment::Told Adjustment::what_is_told() {
  Told told;
  told.unit = kWide * sigmas();
  const Eigen::Index rig = told.unit.size();
  const Scattered all = information();
  // Along what is told, by as much more as it scatters.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> along(
      Eigen::MatrixXd(told.unit.asDiagonal() * all.information * told.unit.asDiagonal()));
  Eigen::VectorXd precision = along.eigenvalues().cwiseMax(0);
  for (Eigen::Index i = 0; i < rig; ++i) {
    const Eigen::VectorXd v = told.unit.cwiseProduct(along.eigenvectors().col(i));
    const double scatter = v.dot(all.scatter * v);
    if (scatter > precision[i]) {
      precision[i] *= precision[i] / scatter;
    }
  }
  const Eigen::MatrixXd seen =
      along.eigenvectors() * precision.asDiagonal() * along.eigenvectors().transpose();
  // With what no run makes surer: (seen^-1 + root root^T)^-1, also where seen has no inverse.
  const Eigen::MatrixXd root = told.unit.cwiseInverse().asDiagonal() * systematic();
  const Eigen::MatrixXd by_root = root.transpose() * seen;
  const Eigen::MatrixXd inner =
      Eigen::MatrixXd::Identity(root.cols(), root.cols()) + by_root * root;
  const Eigen::MatrixXd known = seen - by_root.transpose() * inner.ldlt().solve(by_root);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(0.5 * (known + known.transpose()));
  told.covariance = Eigen::MatrixXd::Zero(rig, rig);
  Eigen::Index open = 0;
  for (Eigen::Index i = 0; i < rig; ++i) {  // the least comes first
    if (axes.eigenvalues()[i] < 1) {
      ++open;
    } else {
      const Eigen::VectorXd v = told.unit.cwiseProduct(axes.eigenvectors().col(i));
      told.covariance += v * v.transpose() / axes.eigenvalues()[i];
    }
  }
  told.open = axes.eigenvectors().leftCols(open);
  return told;
}

/// Along what is open all mountings are moved to where they are most likely by what is believed of
/// them. Empty where they are there already.
std::optional<Adjustment::Kept> Adjustment::as_believed(const Told& told) const {
  constexpr double kSame = 0.01;  // of a sigma
  const RigCovariance at = rows();
  const Eigen::MatrixXd precision = mounting_precision();
  Eigen::VectorXd off = Eigen::VectorXd::Zero(told.unit.size());
  Kept kept;
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    kept.T_body_camera.push_back(from_block(blocks_.T_camera_body[c].data()).inverse());
    off.segment<6>(at.camera[c]) =
        mounting_moved(believed_[c].T_body_camera, kept.T_body_camera.back());
  }
  const Eigen::MatrixXd open = told.unit.asDiagonal() * told.open;
  const Eigen::MatrixXd known = open.transpose() * precision * open;
  const Eigen::VectorXd by = known.ldlt().solve(open.transpose() * (precision * off));
  const Eigen::VectorXd moved = -open * by;
  if (by.size() == 0 ||
      moved.cwiseProduct(precision.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff() < kSame) {
    return std::nullopt;
  }
  constexpr double kFixed = 1e4;  // per unit
  kept.directions.resize(told.open.cols(), 6 * static_cast<Eigen::Index>(believed_.size()));
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    const auto by_camera = moved.segment<6>(at.camera[c]);
    kept.T_body_camera[c].rotation =
        (turned_by(by_camera.head<3>()) * kept.T_body_camera[c].rotation).normalized();
    kept.T_body_camera[c].translation += by_camera.tail<3>();
    kept.directions.middleCols<6>(6 * static_cast<Eigen::Index>(c)) =
        kFixed * told.open.middleRows<6>(at.camera[c]).transpose() *
        told.unit.segment<6>(at.camera[c]).cwiseInverse().asDiagonal();
  }
  return kept;
}

/// Of each number: in the open motion that moves it most, does it move half as much as any?
std::vector<std::vector<std::string>> Adjustment::named(const Eigen::MatrixXd& open) const {
  constexpr double kNothing = 1e-3;
  const std::array<const char*, 6> names{"its roll",          "its pitch",         "its yaw",
                                         "its place along x", "its place along y", "its height"};
  const RigCovariance at = rows();
  const Eigen::MatrixXd onto = open * open.transpose();
  std::vector<std::vector<std::string>> out(believed_.size());
  for (std::size_t c = 0; c < believed_.size(); ++c) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      const Eigen::Index i = at.camera[c] + static_cast<Eigen::Index>(k);
      if (onto(i, i) > std::max(kNothing, onto.col(i).cwiseAbs().maxCoeff() / 2)) {
        out[c].emplace_back(names[k]);
      }
    }
  }
  return out;
}

RigCovariance Adjustment::covariance(const Told& told) const {
  RigCovariance out = rows();
  const Eigen::MatrixXd open = told.unit.asDiagonal() * told.open;
  const Eigen::MatrixXd known = open.transpose() * mounting_precision() * open;
  out.covariance = told.covariance + open * known.ldlt().solve(open.transpose());
  if (no_metre_) {  // nothing has been told of the way
    const Eigen::Index way = out.wheels + kWayError;
    out.covariance.row(way).setZero();
    out.covariance.col(way).setZero();
    out.covariance(way, way) = std::pow(options_.wheels.sigma[kWayError], 2);
  }
  out.unobservable = named(told.open);
  return out;
}

}  // namespace

Eigen::Matrix<double, 6, 6> RigCovariance::relative(const RigBundleState& state,
                                                    std::size_t reference,
                                                    std::size_t camera_seen) const {
  const Pose3& a = state.T_body_camera[reference];
  const Pose3& b = state.T_body_camera[camera_seen];
  const Mat3 R = a.rotation.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.block<3, 3>(0, 0) = -R;
  J.block<3, 3>(0, 6) = R;
  J.block<3, 3>(3, 0) = R * cross_matrix(b.translation - a.translation);
  J.block<3, 3>(3, 3) = -R;
  J.block<3, 3>(3, 9) = R;
  Eigen::Matrix<double, 12, 12> both;
  const std::array<Eigen::Index, 2> at{camera[reference], camera[camera_seen]};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      both.block<6, 6>(6 * i, 6 * j) = covariance.block<6, 6>(at[i], at[j]);
    }
  }
  return J * both * J.transpose();
}

RigBundle adjust_rig(const RigBundleOptions& options, const std::vector<RigCamera>& believed,
                     const WheelReadings& wheels, RigTracks& tracks, const RigBundleState& start) {
  return Adjustment(options, believed, wheels, tracks, start).run();
}

RigBundle expect_rig(const RigBundleOptions& options, const std::vector<RigCamera>& believed,
                     const WheelReadings& wheels, RigTracks& tracks, const RigBundleState& truth,
                     const RigNoise& noise) {
  return Adjustment(options, believed, wheels, tracks, truth).expect(noise);
}

}  // namespace panoptes

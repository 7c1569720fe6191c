// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/relative_motion.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panoptes {
namespace {

constexpr int kSmallest = 6;         // matches below which nothing is tried
constexpr int kScored = 100;         // matches that judge a sampled hypothesis: more cost only time
constexpr double kRoom_per_m = 0.3;  // how far a room's mean inverse depth may be from the default
constexpr double kForgetPrior =
    1e-4;  // share of the prior kept where the pictures shall speak alone

// A match, ready to be compared in one of the two pictures: `source` knows its depth better.
struct MatchObservation {
  bool source_is_a = true;
  Vec3 origin;         // camera of the source, in the source's body frame
  Vec3 direction;      // what its pixel sees, z = 1 in its camera, in its body frame
  InverseDepth depth;  // along it
  double guessed = 1;  // share of it that is the default and not measured
  bool depth_measured = false;
  Mat3 R_camera_target;              // body of the target place to its camera
  Vec3 origin_target;                // that camera, in its body frame
  const Intrinsics* lens = nullptr;  // of the target
  Vec2 px;                           // where the target shows it
  int camera_a = 0;
};

Vec3 ray_body(const LoopCamera& camera, const Mat3& R_body_camera, const Eigen::Vector2f& px) {
  return R_body_camera * camera.intrinsics.ray(px.cast<double>());
}

const InverseDepth kUnknownDepth{};

const InverseDepth& depth_of(const PlaceDepths& depths, int camera, int feature) {
  return depths.empty() || depths[camera].empty() ? kUnknownDepth : depths[camera][feature];
}

std::vector<Mat3> rotations(const LoopCameras& cameras) {
  std::vector<Mat3> R_body_camera;
  for (const LoopCamera& camera : cameras) {
    R_body_camera.push_back(camera.T_body_camera.rotation.toRotationMatrix());
  }
  return R_body_camera;
}

std::vector<MatchObservation> observations_of(const SeenPlace& a, const SeenPlace& b,
                                              const std::vector<PlaceMatch>& matches) {
  const std::vector<Mat3> R_a = rotations(a.cameras);
  const std::vector<Mat3> R_b = rotations(b.cameras);
  std::vector<MatchObservation> observations;
  observations.reserve(matches.size());
  for (const PlaceMatch& match : matches) {
    const InverseDepth& depth_a = depth_of(a.depths, match.camera_a, match.feature_a);
    const InverseDepth& depth_b = depth_of(b.depths, match.camera_b, match.feature_b);
    MatchObservation observation;
    observation.source_is_a = depth_a.sigma_per_m <= depth_b.sigma_per_m;
    const bool from_a = observation.source_is_a;
    const LoopCamera& source = from_a ? a.cameras[match.camera_a] : b.cameras[match.camera_b];
    const LoopCamera& target = from_a ? b.cameras[match.camera_b] : a.cameras[match.camera_a];
    const Eigen::Vector2f& px_a = a.features[match.camera_a].px[match.feature_a];
    const Eigen::Vector2f& px_b = b.features[match.camera_b].px[match.feature_b];
    observation.origin = source.T_body_camera.translation;
    observation.direction =
        ray_body(source, from_a ? R_a[match.camera_a] : R_b[match.camera_b], from_a ? px_a : px_b);
    observation.depth = from_a ? depth_a : depth_b;
    observation.guessed = std::pow(observation.depth.sigma_per_m / kUnknownDepth.sigma_per_m, 2);
    observation.depth_measured = observation.depth.is_measured();
    observation.R_camera_target = (from_a ? R_b[match.camera_b] : R_a[match.camera_a]).transpose();
    observation.origin_target = target.T_body_camera.translation;
    observation.lens = &target.intrinsics;
    observation.px = (from_a ? px_b : px_a).cast<double>();
    observation.camera_a = match.camera_a;
    observations.push_back(observation);
  }
  return observations;
}

// The rigid motion of one candidate, computed once for all matches.
struct Motion {
  double c;
  double s;
  Vec3 t;

  explicit Motion(const Pose2& T_a_b)
      : c(std::cos(T_a_b.theta_rad)), s(std::sin(T_a_b.theta_rad)), t(T_a_b.x_m, T_a_b.y_m, 0) {}
  Vec3 turn(const Vec3& v) const { return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()}; }
  Vec3 turn_back(const Vec3& v) const {
    return {c * v.x() + s * v.y(), -s * v.x() + c * v.y(), v.z()};
  }
};

// Residual in pixels with its inverse covariance, and how it changes with x, y, theta. A depth that
// nothing has measured says nothing of x and y: where two places are near each other any such depth
// explains what is seen, and many of them would outvote what is known.
struct Residual {
  Vec2 r;
  Mat2 weight;
  double across_px = 0;                  // the part that no depth explains
  Eigen::Matrix<double, 2, 4> jacobian;  // the fourth: of the room's inverse depth, see State
};

using Mat4 = Eigen::Matrix4d;
using Vec4 = Eigen::Vector4d;

// What is solved for: the motion, and by how much the room is nearer than the default depth says.
// All guessed depths are wrong together by that much, and would otherwise outvote what is measured.
struct State {
  Pose2 T_a_b;
  double nearer_per_m = 0;
};

// A observation at one motion and one inverse depth: where the target sees it, in its camera (times
// the inverse depth), and how that changes with the inverse depth.
struct Image {
  Vec3 turned;  // before the translation between the cameras counts
  Vec3 q;
  Vec3 along;
};

Image image_of(const MatchObservation& observation, const Motion& motion, double rho) {
  Image image;
  Vec3 along_body;
  if (observation.source_is_a) {
    const Vec3 offset = observation.origin - motion.t;
    image.turned = motion.turn_back(rho * offset + observation.direction);
    along_body = motion.turn_back(offset) - observation.origin_target;
    image.q = observation.R_camera_target * (image.turned - rho * observation.origin_target);
  } else {
    image.turned = motion.turn(rho * observation.origin + observation.direction);
    along_body = motion.turn(observation.origin) + motion.t - observation.origin_target;
    image.q =
        observation.R_camera_target * (image.turned + rho * (motion.t - observation.origin_target));
  }
  image.along = observation.R_camera_target * along_body;
  return image;
}

// How a pixel moves with a change of the point in the camera's frame.
Vec2 moved_px(const Intrinsics& lens, const Vec3& q, const Vec3& dq) {
  const double z_inverse = 1 / q.z();
  return {lens.fx_px * z_inverse * (dq.x() - q.x() * z_inverse * dq.z()),
          lens.fy_px * z_inverse * (dq.y() - q.y() * z_inverse * dq.z())};
}

constexpr double kBehind =
    0.05;  // of the depth in the source's camera: too near the target's plane

// The residual's inverse covariance: noise in all directions, depth along one.
Mat2 weight_of(double variance_px2, double depth_variance, const Vec2& along_px) {
  return (Mat2::Identity() -
          along_px * along_px.transpose() *
              (depth_variance / (variance_px2 + depth_variance * along_px.squaredNorm()))) /
         variance_px2;
}

// Squared residual in sigmas, at the depth known before; infinite when the target cannot see it.
double squared_mahalanobis(const MatchObservation& observation, const Motion& motion,
                           double variance_px2) {
  const Image image = image_of(observation, motion, observation.depth.mean_per_m);
  if (!(image.q.z() >= kBehind)) {
    return std::numeric_limits<double>::infinity();
  }
  const Vec2 r = observation.lens->project(image.q) - observation.px;
  const Vec2 along = moved_px(*observation.lens, image.q, image.along);
  const double along_r = along.dot(r);
  const double spread = observation.depth.sigma_per_m * observation.depth.sigma_per_m;
  return (r.squaredNorm() -
          along_r * along_r * spread / (variance_px2 + spread * along.squaredNorm())) /
         variance_px2;
}

// The residual linearised where this match's own depth fits best: at the depth known before, whose
// error turns up on both sides of the equation, every motion would come out too short.
bool linearise(const MatchObservation& observation, const Motion& motion, double nearer_per_m,
               double variance_px2, Residual& out) {
  const Intrinsics& lens = *observation.lens;
  const double spread = observation.depth.sigma_per_m * observation.depth.sigma_per_m;
  const double known = observation.depth.mean_per_m + observation.guessed * nearer_per_m;
  double rho = std::max(0.0, known);
  Image image = image_of(observation, motion, rho);
  for (int round = 0; round < 2; ++round) {
    if (!(image.q.z() >= kBehind)) {
      return false;
    }
    const Vec2 r = lens.project(image.q) - observation.px;
    const Vec2 along = moved_px(lens, image.q, image.along);
    const double best = known - spread * along.dot(r + along * (known - rho)) /
                                    (variance_px2 + spread * along.squaredNorm());
    rho = std::max(0.0, best);
    image = image_of(observation, motion, rho);
  }
  if (!(image.q.z() >= kBehind)) {
    return false;
  }
  const Vec2 along = moved_px(lens, image.q, image.along);
  out.r = lens.project(image.q) - observation.px + along * (known - rho);
  out.weight = weight_of(variance_px2, spread, along);
  out.jacobian.col(3) = observation.guessed * along;
  const double length = along.norm();
  out.across_px =
      length > 1e-9 ? (along.x() * out.r.y() - along.y() * out.r.x()) / length : out.r.norm();
  const Mat3& R = observation.R_camera_target;
  const Vec3& turned = image.turned;
  if (observation.source_is_a) {
    out.jacobian.col(0) = moved_px(lens, image.q, R * (-rho * motion.turn_back(Vec3::UnitX())));
    out.jacobian.col(1) = moved_px(lens, image.q, R * (-rho * motion.turn_back(Vec3::UnitY())));
    out.jacobian.col(2) = moved_px(lens, image.q, R * Vec3(turned.y(), -turned.x(), 0));
  } else {
    out.jacobian.col(0) = moved_px(lens, image.q, R * (rho * Vec3::UnitX()));
    out.jacobian.col(1) = moved_px(lens, image.q, R * (rho * Vec3::UnitY()));
    out.jacobian.col(2) = moved_px(lens, image.q, R * Vec3(-turned.y(), turned.x(), 0));
  }
  if (!observation.depth_measured) {
    out.jacobian.leftCols<2>().setZero();
  }
  return true;
}

Vec3 difference(const Pose2& T, const Pose2& T0) {
  return {T.x_m - T0.x_m, T.y_m - T0.y_m, wrap_angle(T.theta_rad - T0.theta_rad)};
}

Pose2 moved(const Pose2& T, const Vec3& step) {
  return {T.x_m + step.x(), T.y_m + step.y(), wrap_angle(T.theta_rad + step.z())};
}

struct Normal {
  Mat4 information = Mat4::Zero();  // of the pictures
  Vec4 gradient = Vec4::Zero();
};

// Sums over the observations named by `chosen` (all when null). `kernel` <= 0: squares; else
// Geman-McClure of that width in sigmas.
Normal sum_up(const std::vector<MatchObservation>& observations, const std::vector<int>* chosen,
              const State& state, double variance_px2, double kernel) {
  const Motion motion(state.T_a_b);
  Normal normal;
  const int count = static_cast<int>(chosen != nullptr ? chosen->size() : observations.size());
  Residual residual;
  for (int k = 0; k < count; ++k) {
    const MatchObservation& observation = observations[chosen != nullptr ? (*chosen)[k] : k];
    if (!linearise(observation, motion, state.nearer_per_m, variance_px2, residual)) {
      continue;
    }
    double trust = 1;
    if (kernel > 0) {
      const double m2 = residual.r.dot(residual.weight * residual.r);
      trust = 1 / (1 + m2 / (kernel * kernel));
      trust *= trust;
    }
    const Eigen::Matrix<double, 4, 2> JW = trust * residual.jacobian.transpose() * residual.weight;
    normal.information += JW * residual.jacobian;
    normal.gradient += JW * residual.r;
  }
  return normal;
}

// The prior of all that is solved for.
struct StatePrior {
  Pose2 T_a_b;
  Mat4 information = Mat4::Zero();

  explicit StatePrior(const MotionPrior& prior, double share = 1) : T_a_b(prior.T_a_b) {
    information.topLeftCorner<3, 3>() = share * prior.covariance.inverse();
    information(3, 3) = 1 / (kRoom_per_m * kRoom_per_m);
  }
};

State step_from(const State& state, const Normal& normal, const StatePrior& state_prior) {
  Vec4 off;
  off << difference(state.T_a_b, state_prior.T_a_b), state.nearer_per_m;
  const Mat4 H = normal.information + state_prior.information;
  const Vec4 step = -H.ldlt().solve(normal.gradient + state_prior.information * off);
  if (!step.allFinite()) {
    return state;
  }
  return {moved(state.T_a_b, step.head<3>()), state.nearer_per_m + step[3]};
}

// The start most matches agree with, among motions through three of them each.
Pose2 search_start(const MotionOptions& options, const std::vector<MatchObservation>& observations,
                   const MotionPrior& prior, const StatePrior& state_prior, double variance_px2,
                   Rng& rng) {
  const double limit = options.inlier_sigma * options.inlier_sigma;
  const Mat3 root = prior.covariance.llt().matrixL();
  const int count = static_cast<int>(observations.size());
  std::vector<int> judges;
  const int stride = std::max(1, count / kScored);
  for (int i = 0; i < count; i += stride) {
    judges.push_back(i);
  }
  Pose2 best = prior.T_a_b;
  double best_cost = std::numeric_limits<double>::infinity();
  for (int h = 0; h < options.hypotheses; ++h) {
    State state{prior.T_a_b};
    if (h > 0) {
      constexpr double kReach = 2;  // three steps of Gauss-Newton carry the rest of the way
      Vec3 draw;
      for (int k = 0; k < 3; ++k) {
        draw[k] = rng.uniform(-kReach, kReach);
      }
      state.T_a_b = moved(state.T_a_b, root * draw);
      const std::vector<int> sample{rng.index(count), rng.index(count), rng.index(count)};
      for (int iteration = 0; iteration < 3; ++iteration) {
        state =
            step_from(state, sum_up(observations, &sample, state, variance_px2, 0), state_prior);
      }
    }
    const Motion motion(state.T_a_b);
    double cost = 0;
    for (const int judge : judges) {
      cost += std::min(limit, squared_mahalanobis(observations[judge], motion, variance_px2));
      if (cost >= best_cost) {
        break;
      }
    }
    if (cost < best_cost) {
      best_cost = cost;
      best = state.T_a_b;
    }
  }
  return best;
}

}  // namespace

void bind(Fields& f, MotionOptions& o) {
  f("noise_px", o.noise_px, between(0.05, 10));
  f("inlier_sigma", o.inlier_sigma, between(1, 10));
  f("hypotheses", o.hypotheses, between(1, 100000));
}

std::vector<PlaceMatch> match_places(const FeatureOptions& options, const PlaceFeatures& a,
                                     const PlaceFeatures& b, const Facing& facing) {
  std::vector<PlaceMatch> matches;
  for (const CameraPair& pair : facing.pairs) {
    for (const FeatureMatch& match : match_features(options, a[pair.a], b[pair.b])) {
      matches.push_back({pair.a, pair.b, match.a, match.b});
    }
  }
  return matches;
}

std::optional<PlanarMotion> motion_by_features(const MotionOptions& options, const SeenPlace& a,
                                               const SeenPlace& b,
                                               const std::vector<PlaceMatch>& matches,
                                               const MotionPrior& prior, Rng* search) {
  if (static_cast<int>(matches.size()) < kSmallest) {
    return std::nullopt;
  }
  const std::vector<MatchObservation> observations = observations_of(a, b, matches);
  const double variance_px2 = 2 * options.noise_px * options.noise_px;  // both pictures are noisy
  const StatePrior state_prior(prior);
  State state{prior.T_a_b};
  if (search != nullptr) {
    state.T_a_b = search_start(options, observations, prior, state_prior, variance_px2, *search);
  }
  // from forgiving to strict
  for (const double kernel : {8.0, 8.0, 5.0, 5.0, 3.0, 3.0, 3.0}) {
    state =
        step_from(state, sum_up(observations, nullptr, state, variance_px2, kernel), state_prior);
  }
  std::vector<int> inliers;
  PlanarMotion motion;
  for (int round = 0; round < 3; ++round) {
    inliers.clear();
    const Motion now(state.T_a_b);
    Residual residual;
    double sum_px2 = 0;
    motion.inliers_by_camera.assign(a.cameras.size(), 0);
    for (int i = 0; i < static_cast<int>(observations.size()); ++i) {
      if (linearise(observations[i], now, state.nearer_per_m, variance_px2, residual) &&
          residual.r.dot(residual.weight * residual.r) <=
              options.inlier_sigma * options.inlier_sigma) {
        inliers.push_back(i);
        sum_px2 += residual.across_px * residual.across_px;
        ++motion.inliers_by_camera[observations[i].camera_a];
      }
    }
    if (static_cast<int>(inliers.size()) < kSmallest) {
      return std::nullopt;
    }
    motion.rms_px = std::sqrt(sum_px2 / static_cast<double>(inliers.size()));
    state = step_from(state, sum_up(observations, &inliers, state, variance_px2, 0), state_prior);
  }
  // what the pictures are noisier than promised makes the answer less sure, never surer
  const double excess = std::max(1.0, motion.rms_px * motion.rms_px / variance_px2);
  const Mat4 information =
      sum_up(observations, &inliers, state, variance_px2, 0).information / excess;
  const Vec3 shared = information.block<3, 1>(0, 3);
  motion.information_seen =
      information.topLeftCorner<3, 3>() -
      shared * shared.transpose() / (information(3, 3) + state_prior.information(3, 3));
  motion.T_a_b = state.T_a_b;
  motion.covariance = (motion.information_seen + prior.covariance.inverse()).inverse();
  const StatePrior forgotten(prior, kForgetPrior);
  for (int iteration = 0; iteration < 3; ++iteration) {
    state = step_from(state, sum_up(observations, &inliers, state, variance_px2, 0), forgotten);
  }
  motion.T_a_b_seen = state.T_a_b;
  motion.matches = static_cast<int>(matches.size());
  motion.inliers = static_cast<int>(inliers.size());
  for (const int i : inliers) {
    motion.inlier_matches.push_back(matches[i]);
  }
  return motion;
}

std::vector<std::optional<PlanarMotion>> motion_by_each_camera(
    const MotionOptions& options, const SeenPlace& a, const SeenPlace& b,
    const std::vector<PlaceMatch>& matches, const MotionPrior& prior) {
  std::vector<std::optional<PlanarMotion>> alone;
  for (int camera = 0; camera < static_cast<int>(a.cameras.size()); ++camera) {
    std::vector<PlaceMatch> own;
    std::copy_if(matches.begin(), matches.end(), std::back_inserter(own),
                 [&](const PlaceMatch& match) { return match.camera_a == camera; });
    alone.push_back(motion_by_features(options, a, b, own, prior, nullptr));
  }
  return alone;
}

Vec3 step_by_features(const MotionOptions& options, const SeenPlace& a, const SeenPlace& b,
                      const std::vector<PlaceMatch>& matches, const Pose2& T_a_b) {
  const double variance_px2 = 2 * options.noise_px * options.noise_px;
  const Normal normal = sum_up(observations_of(a, b, matches), nullptr, {T_a_b}, variance_px2, 0);
  Mat4 H = normal.information;
  H(3, 3) += 1 / (kRoom_per_m * kRoom_per_m);
  return -H.ldlt().solve(normal.gradient).head<3>();
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_figures.h"

#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/camera/lens_correction.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

// Below it the run has told at least as much as the rig file: the information of both adds up.
constexpr double kObservedShare = 0.5;                 // of the prior's variance
constexpr double kMostElevation_rad = deg_to_rad(60);  // beyond it a bearing says little

// What chi-squared of 1, 2, ... degrees of freedom is below, 95 times in 100.
constexpr std::array<double, kCameraStates> kChi2_95 = {3.841,  5.991,  7.815,  9.488,  11.070,
                                                        12.592, 14.067, 15.507, 16.919, 18.307};

/// Of the states of one camera, or of the wheels.
template <int kStates>
struct Estimated {
  using Vector = Eigen::Matrix<double, kStates, 1>;
  using Matrix = Eigen::Matrix<double, kStates, kStates>;
  Vector state;
  Matrix covariance;
  Matrix prior;
  std::optional<Vector> truth;

  Estimated(const RigEstimate& estimate, int at)
      : state(estimate.state.segment<kStates>(at)),
        covariance(estimate.covariance.block<kStates, kStates>(at, at)),
        prior(estimate.prior_covariance.block<kStates, kStates>(at, at)) {}

  /// What `of` makes of the states; empty where the run does not show it.
  template <class Function>
  std::optional<LearnedValue> learned(const Function& of) const {
    constexpr double kStep = 1e-6;  // rad, m, shares, px, s
    Vector gradient;
    for (int k = 0; k < kStates; ++k) {
      const Vector step = kStep * Vector::Unit(k);
      gradient[k] = (of(state + step) - of(state - step)) / (2 * kStep);
    }
    const double variance = gradient.dot(covariance * gradient);
    if (!(variance < kObservedShare * gradient.dot(prior * gradient))) {
      return std::nullopt;
    }
    LearnedValue value{of(state), std::sqrt(variance), std::nullopt};
    if (truth) {
      value.error = value.value - of(*truth);
    }
    return value;
  }
};

using EstimatedCamera = Estimated<kCameraStates>;

CameraCorrection true_correction(const LoopCamera& straight, const RigCamera& believed,
                                 const RigCamera& truth) {
  const LensCorrection lens =
      straight_correction(straight.intrinsics, believed.intrinsics, truth.intrinsics);
  const Eigen::AngleAxisd turn(
      (truth.T_body_camera.rotation * believed.T_body_camera.rotation.conjugate()).normalized());
  CameraCorrection state;
  state.segment<3>(kRotation) = wrap_angle(turn.angle()) * turn.axis();
  state.segment<3>(kPosition) =
      truth.T_body_camera.translation - believed.T_body_camera.translation;
  state[kFocal] = lens.focal_ratio;
  state.segment<2>(kCentre) = lens.centre_px;
  state[kClock] = truth.clock_offset_s - believed.clock_offset_s;
  return state;
}

/// Where the middle of the picture is seen, in body.
Vec3 centre_direction(const LoopCamera& believed, const CameraCorrection& by) {
  const Intrinsics lens = corrected(believed.intrinsics, {by[kFocal], by.segment<2>(kCentre)});
  const Vec2 centre_px((lens.width_px - 1) / 2.0, (lens.height_px - 1) / 2.0);
  return (corrected(believed.T_body_camera, by).rotation * lens.ray(centre_px)).normalized();
}

std::optional<LearnedValue> learned_bearing(const EstimatedCamera& of, const LoopCamera& believed) {
  const Vec3 told = centre_direction(believed, CameraCorrection::Zero());
  if (std::abs(told.z()) > std::sin(kMostElevation_rad)) {
    return std::nullopt;
  }
  return of.learned([&](const CameraCorrection& by) {
    const Vec3 seen = centre_direction(believed, by);
    return wrap_angle(std::atan2(seen.y(), seen.x()) - std::atan2(told.y(), told.x()));
  });
}

/// Seen from the prior, in the directions in which the states are known most independently.
LearnedCamera::Consistency consistency_of(const EstimatedCamera& of) {
  const Eigen::LLT<CameraCovariance> prior(of.prior);
  const CameraCovariance half = prior.matrixL().solve(of.covariance);
  const CameraCovariance whitened = prior.matrixL().solve(half.transpose());
  const CameraCorrection error = prior.matrixL().solve(of.state - *of.truth);
  const Eigen::SelfAdjointEigenSolver<CameraCovariance> axes(0.5 *
                                                             (whitened + whitened.transpose()));
  LearnedCamera::Consistency found;
  for (int k = 0; k < kCameraStates; ++k) {
    const double share = axes.eigenvalues()[k];
    if (share > 0 && share < kObservedShare) {
      const double along = axes.eigenvectors().col(k).dot(error);
      found.chi2 += along * along / share;
      ++found.freedom;
    }
  }
  found.inside_95 =
      found.freedom == 0 || found.chi2 <= kChi2_95[static_cast<std::size_t>(found.freedom) - 1];
  return found;
}

LearnedCamera learned_camera(const EstimatedCamera& of, const LoopCamera& straight,
                             double believed_clock_s) {
  const auto mounting = [&](int axis) {
    return of.learned([&, axis](const CameraCorrection& by) {
      return mounting_offset(straight.T_body_camera, corrected(straight.T_body_camera, by))
          .rotation_rad[axis];
    });
  };
  const auto state = [&](int at, double from) {
    return of.learned([at, from](const CameraCorrection& by) { return from + by[at]; });
  };
  LearnedCamera learned;
  learned.roll_rad = mounting(0);
  learned.pitch_rad = mounting(1);
  learned.yaw_rad = mounting(2);
  learned.x_m = state(kPosition, 0);
  learned.y_m = state(kPosition + 1, 0);
  learned.z_m = state(kHeight, 0);
  learned.clock_s = state(kClock, believed_clock_s);
  learned.centre_bearing_rad = learned_bearing(of, straight);
  if (!of.truth) {
    return learned;
  }
  if (learned.x_m && learned.y_m) {
    learned.position_error_m = std::hypot(*learned.x_m->error, *learned.y_m->error);
  }
  if (const auto consistency = consistency_of(of); consistency.freedom > 0) {
    learned.consistency = consistency;
  }
  return learned;
}

}  // namespace

std::map<std::string, LearnedCamera> learned_cameras(const RigEstimate& estimate,
                                                     const Rig& believed, const Rig* truth) {
  std::map<std::string, LearnedCamera> all;
  for (int i = 0; i < static_cast<int>(estimate.believed.size()); ++i) {
    const LoopCamera& straight = estimate.believed[static_cast<std::size_t>(i)];
    const RigCamera& camera = believed.cameras.at(straight.name);
    EstimatedCamera of(estimate, camera_state(i));
    if (truth != nullptr && truth->cameras.contains(straight.name)) {
      of.truth = true_correction(straight, camera, truth->cameras.at(straight.name));
    }
    all[straight.name] = learned_camera(of, straight, camera.clock_offset_s);
  }
  return all;
}

LearnedWheels learned_wheels(const RigEstimate& estimate, double believed_base_m) {
  const Estimated<kWheelStates> of(estimate, wheel_state(estimate.believed.size()));
  using Wheels = Estimated<kWheelStates>::Vector;
  LearnedWheels learned;
  learned.radius_ratio = of.learned([](const Wheels& by) {
    return (1 - by[kWheelDifference] / 2) / (1 + by[kWheelDifference] / 2);
  });
  learned.base_m =
      of.learned([&](const Wheels& by) { return believed_base_m * (1 + by[kWheelBase]); });
  return learned;
}

}  // namespace panoptes

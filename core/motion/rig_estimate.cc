// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/rig_estimate.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/camera/lens_correction.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

/// Never more than the file says itself: what it takes for exact stays so.
double left_of(double believed_sigma, double variance) {
  return std::min(believed_sigma, std::sqrt(std::max(0.0, variance)));
}

/// The camera with its states in it, and no sigma changed.
RigCamera corrected(const RigCamera& believed, const Intrinsics& pinhole,
                    const CameraCorrection& state) {
  RigCamera camera = believed;
  const LensCorrection by =
      of_lens({state[kFocal], state.segment<2>(kCentre)}, pinhole, believed.intrinsics);
  camera.intrinsics = corrected(believed.intrinsics, by);
  camera.T_body_camera = corrected(believed.T_body_camera, state);
  camera.clock_offset_s += state[kClock];
  return camera;
}

/// Roll, pitch, yaw, x, y, z, share of the focal lengths, principal point and clock of `camera` as
/// differences from `believed`, in the order of the states: what a rig file has sigmas of.
CameraCorrection in_the_file(const RigCamera& believed, const RigCamera& camera) {
  const MountingOffset offset = mounting_offset(believed.T_body_camera, camera.T_body_camera);
  CameraCorrection all;
  all.segment<3>(kRotation) = offset.rotation_rad;
  all.segment<3>(kPosition) = offset.shift_m;
  all[kFocal] = camera.intrinsics.fx_px / believed.intrinsics.fx_px - 1;
  all[kCentre] = camera.intrinsics.cx_px - believed.intrinsics.cx_px;
  all[kCentre + 1] = camera.intrinsics.cy_px - believed.intrinsics.cy_px;
  all[kClock] = camera.clock_offset_s - believed.clock_offset_s;
  return all;
}

/// Of what stands in the file, of the states' covariance.
CameraCorrection variances_in_the_file(const RigCamera& believed, const Intrinsics& pinhole,
                                       const CameraCorrection& state,
                                       const CameraCovariance& covariance) {
  constexpr double kStep = 1e-5;  // rad, m, shares, px, s: small beside what bends
  CameraCovariance J;
  for (int k = 0; k < kCameraStates; ++k) {
    const CameraCorrection step = kStep * CameraCorrection::Unit(k);
    J.col(k) = (in_the_file(believed, corrected(believed, pinhole, state + step)) -
                in_the_file(believed, corrected(believed, pinhole, state - step))) /
               (2 * kStep);
  }
  return (J * covariance * J.transpose()).diagonal();
}

bool can_be(const Intrinsics& lens) {
  const bool axis_inside = lens.cx_px > 0 && lens.cy_px > 0 && lens.cx_px < lens.width_px - 1 &&
                           lens.cy_px < lens.height_px - 1;
  return lens.is_pinhole() || (axis_inside && lens_fault(lens).empty());
}

RigCamera refined(const RigCamera& believed, const Intrinsics& pinhole, CameraCorrection state,
                  CameraCovariance covariance) {
  const bool sound = can_be(corrected(believed, pinhole, state).intrinsics);
  if (!sound) {
    state.segment<3>(kFocal).setZero();
    covariance.middleRows<3>(kFocal).setZero();
    covariance.middleCols<3>(kFocal).setZero();
  }
  RigCamera camera = corrected(believed, pinhole, state);
  const CameraCorrection left = variances_in_the_file(believed, pinhole, state, covariance);
  CameraSigmas& sigma = camera.sigma;
  for (int k = 0; k < 3; ++k) {
    sigma.rotation_rad[k] = left_of(sigma.rotation_rad[k], left[kRotation + k]);
  }
  for (int k = 0; k < 3; ++k) {
    sigma.position_m[k] = left_of(sigma.position_m[k], left[kPosition + k]);
  }
  if (sound) {
    sigma.focal_ratio = left_of(sigma.focal_ratio, left[kFocal]);
    sigma.centre_px =  // one number for both ways: the one that is known less
        left_of(sigma.centre_px, std::max(left[kCentre], left[kCentre + 1]));
  }
  sigma.clock_s = left_of(sigma.clock_s, left[kClock]);
  return camera;
}

}  // namespace

std::string told(const KnockReport& knock) {
  return fmt::format(
      "camera {}: knocked by about {:.1f} degrees and {:.0f} mm, found after {:.0f} s; its "
      "mounting is "
      "learned anew, and places from before are recognised by the other cameras alone",
      knock.camera, rad_to_deg(knock.turned_rad), 1000 * knock.shifted_m,
      to_seconds(knock.found - knock.since));
}

Eigen::MatrixXd systematic_covariance(const LoopCameras& cameras) {
  constexpr double kOff_px = 0.1;
  constexpr double kBent_px = 0.4;     // what a lens' shape moves its centre by, the axis with it
  constexpr double kNear_m = 2;        // what shows where a camera is lies about so far away
  constexpr double kTurn_radps = 0.5;  // and what shows its clock is a turn about so fast
  Eigen::VectorXd sigma = Eigen::VectorXd::Zero(rig_states(cameras.size()));
  Eigen::MatrixXd bent = Eigen::MatrixXd::Zero(sigma.size(), 2 * cameras.size());
  for (int camera = 0; camera < static_cast<int>(cameras.size()); ++camera) {
    const Intrinsics& lens = cameras[camera].intrinsics;
    const double off_rad = kOff_px / lens.fx_px;
    auto s = sigma.segment<kCameraStates>(camera_state(camera));
    s.segment<3>(kRotation).setConstant(off_rad);
    s.segment<3>(kPosition).setConstant(off_rad * kNear_m);
    s[kFocal] = kOff_px / (lens.width_px / 2.0);
    s.segment<2>(kCentre).setConstant(kOff_px);
    s[kClock] = off_rad / kTurn_radps;
    // A centre to the right of the true one and a camera turned to the right show what stands near
    // the centre where it is: only how a picture bends tells one from the other.
    const Mat3 R = cameras[camera].T_body_camera.rotation.toRotationMatrix();
    auto across = bent.col(2 * camera).segment<kCameraStates>(camera_state(camera));
    across.segment<3>(kRotation) = kBent_px / lens.fx_px * R.col(1);
    across[kCentre] = kBent_px;
    auto down = bent.col(2 * camera + 1).segment<kCameraStates>(camera_state(camera));
    down.segment<3>(kRotation) = -kBent_px / lens.fy_px * R.col(0);
    down[kCentre + 1] = kBent_px;
  }
  Eigen::MatrixXd covariance = bent * bent.transpose();
  covariance.diagonal() += sigma.cwiseAbs2();
  return covariance;
}

std::string not_this_rig(const LoopCameras& believed, const RigState& state) {
  constexpr double kMost_m = 0.15;  // a file that only roughly says where cameras are is 10 cm off
  constexpr double kSigmas = 3.5;   // of two axes together: one in 450 is farther
  for (int camera = 0; camera < static_cast<int>(believed.size()); ++camera) {
    const double shifted_m = state.segment<2>(camera_state(camera) + kPosition).norm();
    const double sigma_m = believed[camera].sigma.position_m.head<2>().maxCoeff();
    if (shifted_m > std::max(kMost_m, kSigmas * sigma_m)) {
      return fmt::format(
          "{} looks mounted {:.0f} cm from where the rig file has it, more than anybody measures "
          "wrong: is it the file of this rig? See its at_m, its tilt and its field of view",
          believed[camera].name, 100 * shifted_m);
    }
  }
  return {};
}

Rig refined(const Rig& believed, const RigEstimate& estimate) {
  PANOPTES_CHECK(estimate.state.size() == rig_states(estimate.believed.size()),
                 "a state for every camera");
  Rig rig = believed;
  rig.covariance.reset();
  for (int i = 0; i < static_cast<int>(estimate.believed.size()); ++i) {
    const LoopCamera& of = estimate.believed[static_cast<std::size_t>(i)];
    const int at = camera_state(i);
    RigCamera& camera = rig.cameras.at(of.name);
    camera = refined(camera, of.intrinsics, estimate.state.segment<kCameraStates>(at),
                     estimate.covariance.block<kCameraStates, kCameraStates>(at, at));
  }
  return rig;
}

}  // namespace panoptes

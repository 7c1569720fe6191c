// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/motion_by_rig.h"

#include <array>

namespace panoptes {
namespace {

// By how much a state is moved to see what follows: small against what a pixel shows.
constexpr std::array<double, kCameraStates> kMoved{1e-4, 1e-4, 1e-4, 1e-4, 1e-4,
                                                   1e-4, 1e-4, 1e-2, 1e-2, 1e-4};
constexpr double kScaleMoved = 1e-3;

PlaceDepths scaled(PlaceDepths depths, double by) {
  for (std::vector<InverseDepth>& of_camera : depths) {
    for (InverseDepth& depth : of_camera) {
      depth.mean_per_m /= by;
      depth.sigma_per_m /= by;
    }
  }
  return depths;
}

}  // namespace

Eigen::MatrixXd motion_by_rig(const MotionOptions& options, const LoopCameras& believed,
                              const RigState& state, const TimedPlace& a, const TimedPlace& b,
                              const std::vector<PlaceMatch>& matches, const Pose2& T_a_b) {
  const auto step_by = [&](const RigState& moved, const PlaceDepths& depths_a,
                           const PlaceDepths& depths_b) {
    const LoopCameras cameras_a = at_keyframe(believed, moved, a.taken);
    const LoopCameras cameras_b = at_keyframe(believed, moved, b.taken);
    return step_by_features(options, {cameras_a, a.features, depths_a},
                            {cameras_b, b.features, depths_b}, matches, T_a_b);
  };
  const auto step_at = [&](const RigState& moved) { return step_by(moved, a.depths, b.depths); };
  std::vector<bool> matters(believed.size(), false);
  for (const PlaceMatch& match : matches) {
    matters[match.camera_a] = matters[match.camera_b] = true;
  }
  const Vec3 here = step_at(state);
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(3, state.size());
  for (int camera = 0; camera < static_cast<int>(believed.size()); ++camera) {
    for (int k = 0; matters[camera] && k < kCameraStates; ++k) {
      RigState moved = state;
      moved[camera_state(camera) + k] += kMoved[k];
      by_state.col(camera_state(camera) + k) = (step_at(moved) - here) / kMoved[k];
    }
  }
  by_state.col(wheel_state(believed.size()) + kWheelScale) =
      (step_by(state, scaled(a.depths, 1 + kScaleMoved), scaled(b.depths, 1 + kScaleMoved)) -
       here) /
      kScaleMoved;
  return by_state;
}

}  // namespace panoptes

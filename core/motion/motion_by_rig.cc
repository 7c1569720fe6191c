// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/motion_by_rig.h"

#include <array>

namespace panoptes {
namespace {

// By how much a state is moved to see what follows: small against what a pixel shows.
constexpr std::array<double, kCameraStates> kMoved{1e-4, 1e-4, 1e-4, 1e-4, 1e-4,
                                                   1e-4, 1e-2, 1e-2, 1e-4};

}  // namespace

Eigen::MatrixXd motion_by_rig(const MotionOptions& options, const LoopCameras& believed,
                              const RigState& state, const TimedPlace& a, const TimedPlace& b,
                              const std::vector<PlaceMatch>& matches, const Pose2& T_a_b) {
  const auto step_at = [&](const RigState& moved) {
    const LoopCameras cameras_a = at_keyframe(believed, moved, a.taken);
    const LoopCameras cameras_b = at_keyframe(believed, moved, b.taken);
    return step_by_features(options, {cameras_a, a.features, a.depths},
                            {cameras_b, b.features, b.depths}, matches, T_a_b);
  };
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
  return by_state;
}

}  // namespace panoptes

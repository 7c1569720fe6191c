// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/rig_correction.h"

#include <Eigen/Geometry>

#include "core/base/check.h"

namespace panoptes {

LoopCameras corrected(const LoopCameras& believed, const RigState& state) {
  PANOPTES_CHECK(state.size() == rig_states(believed.size()), "a state for every camera");
  LoopCameras cameras = believed;
  for (int i = 0; i < static_cast<int>(cameras.size()); ++i) {
    const auto s = state.segment<kCameraStates>(camera_state(i));
    LoopCamera& camera = cameras[i];
    const Vec3 turn = s.segment<3>(kRotation);
    const double angle = turn.norm();
    if (angle > 0) {
      camera.T_body_camera.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) *
                                      camera.T_body_camera.rotation;
    }
    camera.T_body_camera.translation.head<2>() += s.segment<2>(kPosition);
    camera.intrinsics.fx_px *= 1 + s[kFocal];
    camera.intrinsics.fy_px *= 1 + s[kFocal];
    camera.intrinsics.cx_px += s[kCentre];
    camera.intrinsics.cy_px += s[kCentre + 1];
  }
  return cameras;
}

LoopCameras at_keyframe(const LoopCameras& believed, const RigState& state,
                        const PictureTimes& taken) {
  PANOPTES_CHECK(taken.late_s.size() == believed.size(), "an instant for every camera");
  LoopCameras cameras = corrected(believed, state);
  for (int i = 0; i < static_cast<int>(cameras.size()); ++i) {
    const double after_s = taken.late_s[i] - state[camera_state(i) + kClock];
    if (after_s != 0) {
      cameras[i].T_body_camera =
          on_floor(exp_twist(taken.twist_body, after_s)) * cameras[i].T_body_camera;
    }
  }
  return cameras;
}

}  // namespace panoptes

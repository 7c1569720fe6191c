// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/rig_correction.h"

#include "core/base/check.h"
#include "core/camera/lens_correction.h"
#include "core/camera/mounting.h"

namespace panoptes {

Pose3 corrected(const Pose3& T_body_camera, const CameraCorrection& by) {
  Pose3 T = T_body_camera;
  T.rotation = (turned_by(by.segment<3>(kRotation)) * T.rotation).normalized();
  T.translation += by.segment<3>(kPosition);
  return T;
}

LoopCameras corrected(const LoopCameras& believed, const RigState& state) {
  PANOPTES_CHECK(state.size() == rig_states(believed.size()), "a state for every camera");
  LoopCameras cameras = believed;
  for (int i = 0; i < static_cast<int>(cameras.size()); ++i) {
    const CameraCorrection by = state.segment<kCameraStates>(camera_state(i));
    LoopCamera& camera = cameras[i];
    camera.T_body_camera = corrected(camera.T_body_camera, by);
    camera.intrinsics = corrected(camera.intrinsics, {by[kFocal], by.segment<2>(kCentre)});
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

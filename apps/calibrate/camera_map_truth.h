// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/calib/mono_map.h"
#include "core/camera/rig.h"
#include "core/eval/truth.h"

namespace panoptes {

/// The true motion of one camera of a recording.
class TrueCameraPath {
 public:
  /// Empty where the recording does not hold the truth, or not of this camera.
  static std::optional<TrueCameraPath> read(const std::filesystem::path& dataset,
                                            const std::string& camera);

  /// When it was told to be this.
  Pose3 T_scene_camera(Time stamp) const;
  /// What is up in the camera's frame.
  Vec3 up_camera() const;

 private:
  std::vector<TruePose> poses_;
  RigCamera camera_;
};

/// How far a camera's path is from the truth, its first pose laid on the true one.
struct CameraPathErrors {
  std::vector<double> heading_error_rad;  ///< of each frame, about the true vertical
  std::vector<Vec3> true_map;             ///< where it truly was, in map, true metres
  double path_m = 0;                      ///< of the camera, truly
  double position_rms_m = 0;              ///< after the scale that fits best
  double scale = 1;                       ///< true metres in one of the map's
};
CameraPathErrors camera_path_errors(const std::vector<MonoMap::Frame>& frames,
                                    const TrueCameraPath& truth);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/base/time.h"
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

 private:
  std::vector<TruePose> poses_;
  RigCamera camera_;
};

}  // namespace panoptes

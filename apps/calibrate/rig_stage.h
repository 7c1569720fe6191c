// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_slam.h"
#include "core/calib/rig_calibration.h"

namespace panoptes {

struct RigStage {
  std::string dataset;
  std::string rig;
  std::vector<std::string> cameras;  ///< all where it is empty
  MonoSlamOptions slam;
  KeyframeBundleOptions bundle;
  RigCalibrationOptions calibration;
  std::string out;
  bool quiet = false;
};

/// How the cameras of a recorded drive are mounted. The exit status.
int calibrate_rig_of(const RigStage& args);

}  // namespace panoptes

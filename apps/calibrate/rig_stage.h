// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_slam.h"
#include "core/calib/rig_by_maps.h"
#include "core/calib/rig_calibration.h"

namespace panoptes {

/// What tells how a rig's cameras are mounted.
enum class RigMethod {
  kGuided,  ///< paths beside the wheels', points sought in every camera (calibrate_rig)
  kThesis,  ///< maps aligned by what looks alike, in a chain (calibrate_by_maps)
  kCycles   ///< the same, by a graph whose cycles are checked
};
/// "guided", "thesis", "cycles".
std::string_view name(RigMethod method);

struct RigStage {
  std::string dataset;
  std::string rig;
  std::vector<std::string> cameras;  ///< all where it is empty
  MonoSlamOptions slam;
  KeyframeBundleOptions bundle;
  RigMethod method = RigMethod::kGuided;
  RigCalibrationOptions calibration;  ///< of guided
  RigByMapsOptions by_maps;           ///< of the others
  std::uint64_t seed = 0;             ///< of what these draw
  std::string out;
  bool quiet = false;
};

/// How the cameras of a recorded drive are mounted. The exit status.
int calibrate_rig_of(const RigStage& args);

}  // namespace panoptes

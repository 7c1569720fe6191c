// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_slam.h"

namespace panoptes {

struct MapStage {
  std::string dataset;
  std::string rig;
  std::vector<std::string> cameras;  ///< all where it is empty
  MonoSlamOptions slam;
  KeyframeBundleOptions bundle;
  std::string out;
  bool quiet = false;
};

/// A map for each camera of a recording, by its pictures. The exit status.
int calibrate_maps(const MapStage& args);

}  // namespace panoptes

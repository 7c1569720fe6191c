// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/calib/mono_map.h"
#include "core/camera/rig.h"

namespace panoptes {

/// What one camera of a recording has made of its pictures.
struct CameraMap {
  std::string camera;
  Intrinsics lens;
  MonoMap map;
  double cpu_s = 0;  ///< of the filter, without reading pictures
};

/// Maps a recording with one of its cameras, by its pictures alone. `progress` is told the share
/// that is done. Throws ConfigError for pictures that are not as the lens says.
CameraMap map_camera(const std::filesystem::path& dataset, const std::string& camera,
                     const Intrinsics& lens, const MonoSlamOptions& options,
                     const std::function<void(double)>& progress);

}  // namespace panoptes

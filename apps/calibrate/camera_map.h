// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/process/fault.h"
#include "core/base/time.h"
#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_map.h"
#include "core/camera/rig.h"
#include "core/eval/camera_path.h"

namespace panoptes {

/// One of the pictures, and how it was looked at.
struct LookedAt {
  cv::Mat grey;
  MonoSlamStep step;
  int columns = 0;  ///< of the grid
  int rows = 0;
  double search_sigmas = 0;
};

/// What one camera of a recording has made of its pictures.
struct CameraMap {
  std::string camera;
  Intrinsics lens;
  MonoMap map;
  LookedAt looked_at;           ///< the middle one
  std::vector<MonoMap> growth;  ///< the map after each quarter of the pictures
  Time growth_from;             ///< when the first was taken
  double cpu_s = 0;             ///< of the filter, without reading pictures
  AdjustedMap adjusted;
  cv::Mat keyframe_grey;              ///< the picture of
  std::size_t keyframe_shown = 0;     ///< this one of its keyframes, the middle one
  std::optional<double> cut_short_s;  ///< after the first picture, where not all were read
  /// Of the frames and of the keyframes, where the recording holds the truth.
  std::optional<CameraPathErrors> errors;
  std::optional<CameraPathErrors> adjusted_errors;
  double adjust_s = 0;  ///< CPU
};

/// What may end a map before the last picture: it is of those before, then.
struct MapEnds {
  std::function<bool()> interrupted;  ///< asked before each picture
  Faults* faults = nullptr;  ///< told of a picture that is not as it must be; else that is thrown
};

/// What odometry tells of the motion between pictures, beside `motion_is_told`: nothing, or the
/// turn where pictures are missing.
enum class GapsTold { kNot, kByWheels };

/// Throws ConfigError for what is wrong with a recording and can be told before a camera of it is
/// mapped: its table, its first picture, the odometry where motion is told.
void check_recording(const std::filesystem::path& dataset, const std::string& camera,
                     const RigCamera& believed, const MonoSlamOptions& options);

/// Maps a recording with one of its cameras, by its pictures, alone or with its odometry
/// (`options.motion_is_told`), and adjusts the map. `progress` is told the share that is done.
/// Throws ConfigError for pictures that are not as the lens says.
CameraMap map_camera(const std::filesystem::path& dataset, const std::string& camera,
                     const RigCamera& believed, const MonoSlamOptions& options,
                     const KeyframeBundleOptions& bundle, GapsTold gaps,
                     const std::function<void(double)>& progress, const MapEnds& ends = {});

}  // namespace panoptes

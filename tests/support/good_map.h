// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"
#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_map.h"
#include "core/camera/rig.h"

namespace panoptes {

/// A map of ten seconds of which nothing is wrong.
inline MonoMap good_map() {
  MonoMap map;
  for (int i = 0; i < 100; ++i) {
    map.frames.push_back({time_at(i / 10.0), {}, false});
  }
  map.points.resize(60);
  map.closed = 80;
  map.start_is_known = true;
  return map;
}

/// Its keyframes, that agree on the lens as it is believed to be.
inline AdjustedMap good_keyframes(const RigCamera& believed) {
  AdjustedMap adjusted;
  adjusted.T_map_camera.resize(20);
  adjusted.lens = believed.intrinsics;
  adjusted.converged = true;
  adjusted.rms_after_px = 0.1;
  return adjusted;
}

}  // namespace panoptes

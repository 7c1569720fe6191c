// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_map.h"
#include "core/calib/verdict.h"
#include "core/camera/rig.h"

namespace panoptes {

/// What one camera's map is worth: poor where it was lost on its way, where nothing closes it,
/// where its keyframes do not agree or agree on another lens than `believed` says; failed where the
/// camera is lost at the end, next to nothing is mapped or no keyframes hold together.
Judged judge_map(const MonoMap& map, const AdjustedMap& adjusted, const RigCamera& believed);

}  // namespace panoptes

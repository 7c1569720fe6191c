// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/calib/rig_by_maps.h"
#include "core/calib/verdict.h"

namespace panoptes {

/// What a rig is worth that maps alone tell: poor where a map is, where two are not aligned, where
/// alignments break cycles so that it is not sure which is false, where cameras wander beside one
/// another or contradict the rig file by far, where pictures are not taken at once; failed where no
/// camera is told. Reasons name what is in doubt without making it poor, too: maps that only one
/// alignment holds.
Judged judge_rig_by_maps(const std::vector<MappedCamera>& cameras, const RigByMaps& found);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/calib/rig_calibration.h"
#include "core/calib/verdict.h"

namespace panoptes {

/// What a calibrated rig is worth, with each camera's name: poor where a camera's own map is and no
/// other camera has seen the same, where cameras share no points, where pictures, lenses, wheels
/// and rig file contradict one another; failed where it did not come to an end. What no motion over
/// a floor shows is no fault of it.
Judged judge_rig(const std::vector<MappedCamera>& cameras, const RigCalibration& calibration);

/// What is to be believed of a rig that was found and judged: where that is poor, it says why, and
/// is known no better than it was before. Doubts of before are gone.
Rig believed_after(Rig found, const Rig& before, const Judged& judged);

}  // namespace panoptes

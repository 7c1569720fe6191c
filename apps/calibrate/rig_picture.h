// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/calib/rig_calibration.h"
#include "core/calib/verdict.h"
#include "core/camera/rig.h"

namespace panoptes {

/// What a calibration has come to, from above: the points of all cameras' maps with the robot's
/// way, and the rig on the robot, with what was believed of it and the 95 % ellipses of where each
/// camera is as the first one sees it, of the first one in the body (thesis Fig. 4.14). 8-bit BGR.
cv::Mat draw_rig(const RigCalibration& calibration, const Rig& believed, Verdict verdict);

}  // namespace panoptes

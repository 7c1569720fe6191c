// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/calib/rig_calibration.h"
#include "core/camera/joint_covariance.h"

namespace panoptes {

/// How well a calibration knows its cameras together: what wheels err by is marginalised.
JointCovariance joint_covariance(const RigCalibration& calibration);

}  // namespace panoptes

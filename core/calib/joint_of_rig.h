// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/calib/rig_calibration.h"
#include "core/camera/joint_covariance.h"

namespace panoptes {

/// What is known of cameras before a calibration: a covariance, of RigCovariance's rows but the
/// wheels'. How well each number is known its camera's sigma says; how they go together `joint`,
/// and what no sigma says, how well distortions are known, where it tells of them.
Eigen::MatrixXd covariance_before(const std::vector<std::string>& cameras,
                                  const std::vector<RigCamera>& believed,
                                  const std::optional<JointCovariance>& joint);

/// How well a calibration knows its cameras together: what wheels err by is marginalised.
JointCovariance joint_covariance(const RigCalibration& calibration);

}  // namespace panoptes

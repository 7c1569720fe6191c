// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "core/calib/rig_calibration.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// Translation and rotation of a pose.
nlohmann::ordered_json pose_figures(const Pose3& T);

/// How far a pose is from the true one: angle, distance, and between the directions of both.
void add_errors(const Pose3& found, const Pose3& truth, nlohmann::ordered_json& figures);

/// What metrics.json tells of a calibrated rig, against the truth where there is one.
nlohmann::ordered_json rig_figures(const RigCalibration& calibration,
                                   const std::optional<Rig>& truth);

}  // namespace panoptes

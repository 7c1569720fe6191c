// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "core/calib/rig_calibration.h"
#include "core/camera/rig.h"

namespace panoptes {

/// What metrics.json tells of a calibrated rig, against the truth where there is one.
nlohmann::ordered_json rig_figures(const RigCalibration& calibration,
                                   const std::optional<Rig>& truth);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "apps/process/fault.h"
#include "core/calib/verdict.h"
#include "core/camera/rig.h"

namespace panoptes {

/// The rig that a simulated robot truly had; empty where a recording does not hold it.
std::optional<Rig> true_rig(const std::filesystem::path& dataset);

/// A calibrated rig for Panoptes, for Kalibr, and for ROS.
void write_rig(const std::filesystem::path& out, const Rig& rig,
               const std::vector<std::string>& cameras, Verdict verdict);

/// Writes metrics.json of what has been judged. The exit status.
int write_judged(const std::filesystem::path& out, nlohmann::ordered_json figures,
                 const Judged& judged, Faults& faults);

}  // namespace panoptes

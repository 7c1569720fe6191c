// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/camera/rig.h"

namespace panoptes {

/// The rig of a dataset, or of a rig file where `rig` names one. Throws ConfigError where there is
/// none.
Rig whole_rig(const std::string& dataset, const std::string& rig);

/// The cameras of a rig that are named, in that order; all where none is. What the rig file has
/// known exactly (sigmas of 0) is known to next to nothing. Throws ConfigError for a camera that
/// the rig has not.
std::vector<std::pair<std::string, RigCamera>> rig_cameras(const Rig& rig,
                                                           const std::vector<std::string>& names);

/// The cameras of a dataset that are calibrated, as a rig file (the dataset's own where `rig` is
/// empty) has them: those of `names`, or all that have pictures. Throws ConfigError where there is
/// no rig or no such camera.
std::vector<std::pair<std::string, RigCamera>> stage_cameras(const std::string& dataset,
                                                             const std::string& rig,
                                                             std::vector<std::string> names);

/// Cameras of that rig of which a dataset has no pictures; none where cameras are named.
std::vector<std::string> cameras_left_out(const std::string& dataset, const std::string& rig,
                                          const std::vector<std::string>& names);

}  // namespace panoptes

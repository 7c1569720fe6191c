// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>

#include "apps/place/rig_sweep.h"

namespace panoptes {

/// What the best rigs of a placement study do to navigation is for runs to tell: leaves in
/// `out_dir` the rigs as files of their own and drives.yaml, a study of runs (`panoptes trials
/// --study`). What the robot believes of each is off as a programmed motion would leave it: by
/// calibratability(). Takes seconds a rig; `progress` is told the share that is done.
void write_drives(const std::filesystem::path& out_dir, const PlacementStudy& study,
                  const RigSweep& sweep, const std::function<void(double done)>& progress);

/// calibrations.yaml: a study that truly records the best three of those rigs, mounted by hand, and
/// calibrates them. Their files are write_drives()'s.
void write_calibrations(const std::filesystem::path& out_dir, const PlacementStudy& study,
                        const RigSweep& sweep);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/calib/planned_calibration.h"

namespace panoptes {

struct PlanStage {
  std::string mission;
  std::vector<std::string> overrides;
  std::string rig;                   ///< the mission's where it is empty
  std::vector<std::string> cameras;  ///< all where it is empty
  std::string room;                  ///< LENGTHxWIDTHxHEIGHT; the default where it is empty
  std::string out;                   ///< nothing is written where it is empty
  PlanOptions plan;
};

/// What a calibration by a mission's programmed motion would tell; nothing is driven. The exit
/// status.
int plan_calibration_of(PlanStage args);

}  // namespace panoptes

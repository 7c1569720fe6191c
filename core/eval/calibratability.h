// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/calib/planned_calibration.h"
#include "core/camera/rig.h"
#include "core/geometry/body.h"
#include "core/plan/motion_program.h"

namespace panoptes {

struct CalibratabilityOptions {
  MotionProgramOptions program = Rose();
  PlanOptions plan;
};

/// How well a programmed motion would tell where a camera is: one sigma, of what it shows at all.
struct CameraCalibratability {
  std::string camera;
  double rotation_rad = 0;                ///< of roll, pitch and yaw, the worst
  double position_m = 0;                  ///< of x and y, the worse
  std::vector<std::string> unobservable;  ///< in words: this stays as the rig file has it
};

/// A rig is as good as its worst camera.
struct Calibratability {
  std::vector<CameraCalibratability> cameras;
  double rotation_rad = 0;
  double position_m = 0;
  bool all_observable = true;
  Rig left;  ///< the rig; sigmas and covariance of how its cameras sit are what the motion leaves
};

/// Takes a second and more. Needs one camera or more.
Calibratability calibratability(const CalibratabilityOptions& options, const Rig& rig,
                                const Body& body);

}  // namespace panoptes

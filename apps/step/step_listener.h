// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/camera/observation.h"
#include "core/nav/pilot_step.h"
#include "core/nav/slam_step.h"

namespace panoptes {

/// Told of every step of a mission, after the robot has been commanded.
class StepListener {
 public:
  virtual ~StepListener() = default;

  /// What was observed, what slam made of it, and what who drives decided.
  virtual void add(const Observation& seen, const SlamStep& at, const PilotStep& step) = 0;
};

}  // namespace panoptes

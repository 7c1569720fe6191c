// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "core/plan/motion_program.h"

namespace panoptes {

/// Where a body is over time: poses at a constant period from the run's start on, and arcs between.
class DrivePath {
 public:
  DrivePath(std::vector<Pose2> T_start_body, double period_s);

  const std::vector<Pose2>& poses() const { return T_start_body_; }
  Time instant(std::size_t pose) const;
  Time end() const { return instant(T_start_body_.size() - 1); }

  /// Empty before the start and after the end.
  std::optional<Pose2> at(Time instant) const;
  /// As wheels that err by nothing tell it.
  std::optional<Odometry> odometry(Time instant) const;

 private:
  std::vector<Pose2> T_start_body_;
  double period_s_;
};

/// The path of a body that does exactly as a program commands, for `longest_s` at most.
DrivePath driven_path(const MotionProgramOptions& program, const Body& body, double longest_s);

}  // namespace panoptes

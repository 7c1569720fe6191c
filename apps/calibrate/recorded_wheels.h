// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/rig.h"
#include "core/io/dataset.h"
#include "core/io/frame_set_assembly.h"

namespace panoptes {

/// The odometry of a recording, by its own clock.
class RecordedWheels {
 public:
  /// Throws ConfigError with the file and line for what is missing or wrong.
  explicit RecordedWheels(const std::string& dataset);

  /// Empty where it does not reach, and in gaps: what happens in one is not on a line.
  std::optional<Odometry> at(Time instant) const;

  /// Throws ConfigError where it does not reach over most of a camera's pictures.
  void check_reach(const std::vector<RecordedPicture>& pictures, const RigCamera& camera) const;

 private:
  std::string file_;
  std::vector<StampedOdometry> rows_;
  Duration longest_gap_{};
};

}  // namespace panoptes

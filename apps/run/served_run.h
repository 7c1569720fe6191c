// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "apps/run/mission.h"
#include "apps/run/recorder.h"
#include "core/base/time.h"
#include "core/eval/truth.h"
#include "core/io/growing_file.h"
#include "hw/robot.h"

namespace panoptes {

/// What truly happens to a served robot, where others can read it while it does: in `scene`, by the
/// seconds since `start_unix_ns`.
class TruthFiles {
 public:
  TruthFiles(const std::filesystem::path& folder, const Truth& first);

  /// What is new since what was added before (Robot::truth_since).
  void add(const Truth& news);

 private:
  GrowingFile poses_;
  GrowingFile contacts_;
  GrowingFile clearance_;
};

/// The folder that serving a robot leaves behind. Runs of its clients can be evaluated with it from
/// the first moment on, however the program ends.
class ServedRun {
 public:
  /// `folder` is there; the robot's time 0 is now.
  ServedRun(const std::filesystem::path& folder, const ExploreMission& mission, const Truth& first);

  /// What is new in the robot's truth.
  void keep(const hw::Robot& robot);

  /// `outcome` is completed or interrupted.
  void write_metrics(const std::string& outcome, Time now) const;

  const Truth& known() const { return known_; }  ///< without layers

 private:
  std::filesystem::path folder_;
  RunInfo info_;
  TruthFiles files_;
  Truth known_;
};

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "apps/mission/mission.h"
#include "apps/report/finished_run.h"
#include "apps/serve/served_truth.h"
#include "core/base/time.h"
#include "core/eval/truth.h"
#include "hw/robot.h"

namespace panoptes {

/// The folder that serving a robot leaves behind. Runs of its clients can be evaluated with it from
/// the first moment on, however the program ends.
class ServedRun {
 public:
  /// `folder` is there; `start_unix_ns` is the wall instant of the robot's time 0.
  ServedRun(const std::filesystem::path& folder, const ExploreMission& mission,
            std::int64_t start_unix_ns, const Truth& first);

  /// What is new in the robot's truth.
  void keep(const hw::Robot& robot);

  /// `outcome` is completed, interrupted, or failed for what `fault` says.
  void write_metrics(const std::string& outcome, Time now, const std::string& fault = {}) const;

  const Truth& known() const { return known_; }  ///< without layers

 private:
  std::filesystem::path folder_;
  RunInfo info_;
  ServedTruthWriter files_;
  Truth known_;
};

}  // namespace panoptes

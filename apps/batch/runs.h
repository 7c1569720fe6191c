// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

#include "apps/batch/plan.h"
#include "apps/batch/results.h"

namespace panoptes {

/// Runs under way, each a process of its own. A run writes in a folder that is its process's alone
/// and is renamed when it ends: a run's folder holds a whole run, whoever else makes the same run
/// at the same time, and who comes second throws his own away. Those that are under way when this
/// ends are ended as Ctrl-C would.
class Runs {
 public:
  Runs(const TrialsOptions& options, Results& results) : options_(options), results_(results) {}
  ~Runs();
  Runs(const Runs&) = delete;
  Runs& operator=(const Runs&) = delete;

  void start(Trial& trial);

  /// Takes what has ended, and says how long each of that took (s).
  std::vector<double> collect();

  int under_way() const { return static_cast<int>(running_.size()); }
  std::vector<double> running_s() const;

  /// Asks each of them to end.
  void ask();

 private:
  struct Running {
    Trial* trial = nullptr;
    std::filesystem::path part;
    pid_t process = -1;
    double started_s = 0;
  };

  std::string broken_by(const Running& run, int status) const;
  void take(const Running& run, int status);
  void publish(const Running& run);

  const TrialsOptions& options_;
  Results& results_;
  std::vector<Running> running_;
  bool asked_ = false;
};

/// Removes what processes that were killed have left of runs that are done.
void remove_left_over(const TrialsOptions& options, const std::vector<Trial>& trials);

}  // namespace panoptes

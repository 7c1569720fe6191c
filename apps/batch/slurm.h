// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/batch/plan.h"

namespace panoptes {

struct SlurmOptions {
  std::string words;         ///< for every sbatch: partition, account, time
  std::optional<int> chunk;  ///< runs a task; absent: as many as take a minute
  bool resume = false;       ///< what is missing of an array that has been submitted before
  bool wait = false;         ///< until all is merged
};

/// How many tasks the runs that are not left out go to: none shorter than about a minute, and no
/// more than an array holds (MaxArraySize is 1001 by default).
int tasks_for(const std::vector<Trial>& trials, const std::optional<int>& chunk);

/// Submits the runs that wait to Slurm: a job that works out the light of each world once, an array
/// whose tasks each make a shard, and a job that merges what they left. Its scripts and what they
/// say are kept in `out_dir/slurm`. The manifest is written before. Exit status: 0, and with `wait`
/// that of the merge. Throws DeviceError where there is no Slurm or it refuses, ConfigError where
/// tasks of these trials are still in the queue.
int submit_to_slurm(const TrialsOptions& options, const SlurmOptions& slurm,
                    const std::vector<Trial>& trials);

}  // namespace panoptes

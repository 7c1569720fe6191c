// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/study/figure_row.h"
#include "apps/study/study.h"

namespace panoptes {

/// A setting to be tried at several values.
struct Vary {
  std::string key;
  std::vector<std::string> values;
};

/// A mission as a run would resolve it; `text` is what the run's mission.yaml then holds.
struct ResolvedMission {
  std::string name;
  std::string text;
  std::map<std::string, std::string> inputs;  ///< files read for it, with their SHA-256
  double duration_s = 0;                      ///< until it ends at the latest, on its own clock
};

/// What stays of a run that is done.
enum class Keep { kAll, kMetrics };

/// One of `count` parts of the runs, counted from 1: every `count`-th of them.
struct Shard {
  int index = 1;
  int count = 1;
};

struct TrialsOptions {
  std::vector<std::string> missions;
  std::optional<Study> study;  ///< in place of missions and vary
  std::vector<std::uint64_t> seeds;
  std::vector<Vary> vary;        ///< every combination is tried
  std::vector<std::string> set;  ///< overrides of every run, `key.path=value`
  Keep keep = Keep::kAll;
  int jobs = 1;                ///< runs at once
  std::optional<int> threads;  ///< that draw in each run; absent: one where several run at once
  std::filesystem::path out_dir;
  std::filesystem::path junit;  ///< empty: none
  bool quiet = false;
  std::string version;
  /// Does `COMMAND MISSION --set .. --out DIR`.
  std::filesystem::path program = "/proc/self/exe";
  /// Throws ConfigError for a mission that cannot be run.
  std::function<ResolvedMission(const std::string& command, const std::string& mission,
                                const std::vector<std::string>& set)>
      resolve;
};

/// `1-5,101` is 1 2 3 4 5 101. Throws ConfigError.
std::vector<std::uint64_t> parse_seeds(std::string_view text);

/// The reverse, for numbers of any kind: as short as can be, in their order.
std::string numbers_text(const std::vector<std::uint64_t>& numbers);

/// `key.path=v1,v2`; commas inside brackets do not divide. Throws ConfigError.
Vary parse_vary(std::string_view text);

/// `2/8` is the second of eight parts. Throws ConfigError.
Shard parse_shard(std::string_view text);

/// Adds a setting to try at several values. What a study of recognition compares (`places.*`) is
/// compared on the pictures of one drive: it becomes a list in every run.
void add_vary(TrialsOptions& options, const Vary& vary);

/// Runs that differ in their seed alone.
struct TrialPoint {
  std::string mission_file;
  std::string command = "explore";  ///< of a study's mission
  std::string mission;
  std::vector<std::string> values;  ///< of the varied settings, in their order; rig and rung
  std::string setting;              ///< the same as words; empty when nothing is varied
  std::size_t cell = 0;             ///< of the study
  std::vector<Limit> limits;        ///< besides what its mission requires
  std::vector<std::string> set;     ///< all overrides but the seed
  std::filesystem::path folder;     ///< that of its runs, within that of the trials
  std::map<std::string, std::string> inputs;  ///< files that its mission was read from
  double duration_s = 0;
};

enum class TrialStatus { kWaiting, kRunning, kPassed, kFailed, kBroken };

/// One run of a mission, with one seed under one combination of the varied settings.
struct Trial {
  std::shared_ptr<const TrialPoint> point;
  std::uint64_t seed = 0;
  std::string settings_sha256;  ///< of what its mission.yaml will hold

  TrialStatus status = TrialStatus::kWaiting;
  std::string outcome;     ///< of metrics.json; of a broken one how it ended
  bool cut_short = false;  ///< by what the machine lacked, or a bug
  bool left_out = false;   ///< by a study's halving: not to be made, and no part of the verdict
  std::vector<std::string> broken;                     ///< requirements, with the values
  std::vector<std::pair<std::string, bool>> required;  ///< all of them, and whether they are met
  double wall_s = 0;
  FigureRow figures;
};

bool is_done(const Trial& trial);

/// Where it is kept.
std::filesystem::path folder_of(const Trial& trial, const std::filesystem::path& out_dir);

/// All overrides, the seed's included.
std::vector<std::string> set_of(const Trial& trial);

/// What tells the runs of one mission and seed apart: the keys that are varied; of a study `rig`
/// and `rung`.
std::vector<std::string> varied(const TrialsOptions& options);

/// Every mission with every combination and every seed. Where two seeds of a mission differ in the
/// line that names them alone, the others are not resolved one by one. Throws ConfigError where two
/// runs would go to one place, and with all that is wrong with the missions of a study.
std::vector<Trial> plan_trials(const TrialsOptions& options);

/// Gives runs that were planned of this study its limits.
void set_limits(const Study& study, std::vector<Trial>& trials);

}  // namespace panoptes

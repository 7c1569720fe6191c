// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "apps/batch/plan.h"

namespace panoptes {

// What stands beside what a run itself leaves in its folder.
inline constexpr const char* kInputsFile = "inputs.sha256";  ///< what it was made of, as it said,
inline constexpr const char* kLogFile = "run.log";           ///< its words,
inline constexpr const char* kEndFile = "ended.txt";         ///< and how it broke, where it did

/// Takes what is left of runs. It keeps the names of their figures once, and hashes a file once.
class Results {
 public:
  explicit Results(const TrialsOptions& options) : options_(options) {}

  /// Takes the figures that a folder holds; false when there are none that can be read.
  bool take_metrics(Trial& trial, const std::filesystem::path& folder);

  /// Takes what its folder holds: a whole run of these settings, or one that broke. One that was
  /// interrupted, or has not been there, waits to be run.
  void take(Trial& trial);

  /// Takes what its folder holds where that is a whole run of these settings and need not be run
  /// again; else it waits to be run.
  bool take_finished(Trial& trial);

  /// Nothing that others have left is overwritten, or judged: what its folder holds is a run with
  /// these settings, and if it is done it was made of what is there now. Throws ConfigError.
  void check_what_is_there(const Trial& trial);

  /// That what is planned is of this program, and of files as they are. Throws ConfigError.
  void check_made_of(const std::string& program_sha256, const TrialPoint& point);

  const std::string& hash_now(const std::string& file);

 private:
  std::string changed_since(const Trial& trial);

  const TrialsOptions& options_;
  FigureRows rows_;
  std::map<std::string, std::string> hashes_;
};

/// Whether the mission.yaml of a folder is what was planned for the run.
bool has_settings_of(const Trial& trial, const std::filesystem::path& folder);

/// Why it is no pass, a line each.
std::vector<std::string> faults(const Trial& trial, const TrialsOptions& options);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

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
};

struct TrialsOptions {
  std::vector<std::string> missions;
  std::vector<std::uint64_t> seeds;
  std::vector<Vary> vary;        ///< every combination is tried
  std::vector<std::string> set;  ///< overrides of every run, `key.path=value`
  int jobs = 1;                  ///< runs at once
  std::filesystem::path out_dir;
  std::filesystem::path junit;  ///< empty: none
  bool quiet = false;
  std::string version;
  std::filesystem::path program = "/proc/self/exe";  ///< does `explore MISSION --set .. --out DIR`
  /// Throws ConfigError for a mission that cannot be run.
  std::function<ResolvedMission(const std::string& mission, const std::vector<std::string>& set)>
      resolve;
};

/// `1-5,101` is 1 2 3 4 5 101. Throws ConfigError.
std::vector<std::uint64_t> parse_seeds(std::string_view text);

/// `key.path=v1,v2`; commas inside brackets do not divide. Throws ConfigError.
Vary parse_vary(std::string_view text);

/// Adds a setting to try at several values. What a study of recognition compares (`places.*`) is
/// compared on the pictures of one drive: it becomes a list in every run.
void add_vary(TrialsOptions& options, const Vary& vary);

/// What the columns of the table are, a line each, for --help.
std::string table_legend();

/// Runs every mission with every combination and every seed, each as a process of its own in
/// `out_dir/<mission>/<combination>/<seed>`, prints one table and writes trials.csv, metrics.json
/// and the JUnit file. Of runs that compared ways to tell places apart it prints another table, and
/// writes study.csv, a row a run and a combination, and places.png. Runs that are already there,
/// finished with the same settings, by the same program and from the same files (their hashes are
/// beside each run), are kept; other ones are never overwritten: ConfigError. Exit status: 0 when
/// every run met its requirements, 1 when one did not, 130 when interrupted (SIGINT, SIGTERM and
/// SIGHUP are passed on to the runs).
int run_trials(const TrialsOptions& options);

}  // namespace panoptes

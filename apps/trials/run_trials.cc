// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/run_trials.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "apps/batch/manifest.h"
#include "apps/batch/results.h"
#include "apps/batch/runs.h"
#include "apps/command/folder_lock.h"
#include "apps/command/out_file.h"
#include "apps/mission/stop_condition.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "apps/trials/halving.h"
#include "apps/trials/tables.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/config/sha256.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// `3 of 20 runs done, 1 failed, 4:10 left` on stderr: a line drawn again and again on a terminal,
/// one every 30 s elsewhere.
class TrialsProgress {
 public:
  explicit TrialsProgress(bool quiet)
      : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) != 0), shown_s_(steady_s()) {}
  ~TrialsProgress() {
    if (drawn_) {
      std::fprintf(stderr, "\r\033[K");
    }
  }
  TrialsProgress(const TrialsProgress&) = delete;
  TrialsProgress& operator=(const TrialsProgress&) = delete;

  void show(const std::vector<Trial*>& trials, const std::vector<double>& took_s,
            const std::vector<double>& running_s, int jobs) {
    constexpr double kOnTerminal_s = 0.5;
    constexpr double kElsewhere_s = 30;
    const double now_s = steady_s();
    if (quiet_ || now_s - shown_s_ < (terminal_ ? kOnTerminal_s : kElsewhere_s)) {
      return;
    }
    shown_s_ = now_s;
    int done = 0;
    int not_passed = 0;
    std::size_t waiting = 0;
    for (const Trial* trial : trials) {
      done += is_done(*trial) ? 1 : 0;
      not_passed +=
          trial->status == TrialStatus::kFailed || trial->status == TrialStatus::kBroken ? 1 : 0;
      waiting += trial->status == TrialStatus::kWaiting ? 1 : 0;
    }
    std::string line = std::to_string(done) + " of " + std::to_string(trials.size()) +
                       " runs done, " + std::to_string(not_passed) + " failed";
    if (const auto left_s = time_left_s(took_s, running_s, waiting, jobs)) {
      line += ", " + minutes_text(*left_s) + " left";
    } else if (!took_s.empty()) {
      line += ", what is left takes longer than any so far";
    }
    std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", line.c_str());
    std::fflush(stderr);
    drawn_ = terminal_;
  }

 private:
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  double shown_s_;
};

// Whoever is refused leaves no folder that was not there.
void remove_if_empty(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_empty(folder, ignored)) {
    fs::remove(folder, ignored);
  }
}

/// The verdicts' file can be written, or the user is told before anything runs.
void check_junit(const TrialsOptions& options) {
  if (options.junit.empty()) {
    return;
  }
  try {
    check_out_file("--junit", options.junit);
  } catch (const ConfigError&) {
    remove_if_empty(options.out_dir);
    throw;
  }
}

/// A folder of trials is known by its manifest.
void make_trials_dir(const fs::path& out_dir) {
  std::error_code fault;
  fs::create_directories(out_dir, fault);
  if (fault || !fs::is_directory(out_dir)) {
    throw ConfigError(out_dir.string() + ": cannot be made; name another folder with --out");
  }
  if (!fs::is_empty(out_dir) && !fs::exists(manifest_file(out_dir))) {
    throw ConfigError(out_dir.string() +
                      ": holds something else than trials; name another folder with --out");
  }
  if (::access(out_dir.c_str(), W_OK | X_OK) != 0) {
    throw ConfigError(out_dir.string() + ": cannot be written; name another folder with --out");
  }
}

/// Of whoever writes the tables: one at a time.
FolderLock lock_tables(const fs::path& out_dir) {
  std::optional<FolderLock> lock = FolderLock::take(out_dir);
  if (!lock) {
    throw ConfigError(out_dir.string() +
                      ": another panoptes is writing there; name another folder with --out");
  }
  return std::move(*lock);
}

bool asks_for_runs(const TrialsOptions& options) {
  return options.study || !options.missions.empty();
}

/// The runs that a manifest says, and what was asked for with them; from here on relative files are
/// meant as they were then.
std::vector<Trial> take_manifest(TrialsOptions& options, Manifest manifest) {
  options.out_dir = fs::absolute(options.out_dir);
  options.junit = options.junit.empty() ? fs::path() : fs::absolute(options.junit);
  std::error_code fault;
  fs::current_path(manifest.working_folder, fault);
  if (fault) {
    throw ConfigError(manifest.working_folder.string() + ": cannot be entered (" + fault.message() +
                      "), where " + manifest_file(options.out_dir).string() + " was planned");
  }
  options.vary = manifest.vary;
  options.keep = manifest.keep;
  if (!manifest.study_file.empty()) {
    options.study = read_study(manifest.study_file);
    if (sha256(read_file(manifest.study_file)) != manifest.study_sha256) {
      throw ConfigError(manifest.study_file + ": has changed since " +
                        manifest_file(options.out_dir).string() +
                        " was planned; put it back, or name another folder with --out");
    }
    set_limits(*options.study, manifest.trials);
  }
  return std::move(manifest.trials);
}

/// The runs of the manifest that is there. Missions that are named besides must be its own; where
/// there is none yet, they are planned.
std::vector<Trial> planned_runs(TrialsOptions& options, Results& results) {
  if (!fs::exists(manifest_file(options.out_dir)) && asks_for_runs(options)) {
    std::vector<Trial> trials = plan_trials(options);
    make_trials_dir(options.out_dir);
    write_manifest(options, results.hash_now(options.program), trials);
    return trials;
  }
  Manifest manifest = read_manifest(options.out_dir);
  if (asks_for_runs(options)) {
    check_asked_for(manifest, options);
  }
  const std::string program_sha256 = manifest.program_sha256;
  std::vector<Trial> trials = take_manifest(options, std::move(manifest));
  const TrialPoint* point = nullptr;
  for (const Trial& trial : trials) {
    if (trial.point.get() != point) {
      point = trial.point.get();
      results.check_made_of(program_sha256, *point);
    }
  }
  return trials;
}

void write_tables(const TrialsOptions& options, const std::vector<Trial>& trials) {
  write_csv(options, trials);
  write_study(options, trials);
}

/// Makes the runs that wait. `told` is called after each. True when it was interrupted.
bool make_runs(const TrialsOptions& options, const std::vector<Trial*>& trials, Results& results,
               const StopCondition& stop_condition, const std::function<void()>& told) {
  Runs under_way(options, results);
  TrialsProgress progress(options.quiet);
  std::vector<double> took_s;
  int passed_on = 0;
  auto next = trials.begin();
  while (true) {
    const std::vector<double> ended_s = under_way.collect();
    took_s.insert(took_s.end(), ended_s.begin(), ended_s.end());
    if (!ended_s.empty()) {
      told();
    }
    const int asked = (stop_condition.interrupted() ? 1 : 0) + (stop_condition.hurried() ? 1 : 0);
    for (; passed_on < asked; ++passed_on) {
      under_way.ask();
    }
    while (passed_on == 0 && under_way.under_way() < options.jobs && next != trials.end()) {
      Trial& trial = **next++;
      if (trial.status == TrialStatus::kWaiting) {
        under_way.start(trial);
      }
    }
    if (under_way.under_way() == 0) {
      return passed_on > 0;
    }
    progress.show(trials, took_s, under_way.running_s(), options.jobs);
    constexpr auto kLook = std::chrono::milliseconds(50);
    std::this_thread::sleep_for(kLook);
  }
}

/// How many runs are missing and which, the first of them.
std::string missing_text(const std::vector<Trial>& trials) {
  constexpr std::size_t kNamed = 5;
  std::size_t missing = 0;
  std::size_t asked_for = 0;
  std::vector<std::string> names;
  for (const Trial& trial : trials) {
    asked_for += trial.left_out ? 0 : 1;
    if (!is_done(trial) && !trial.left_out && ++missing <= kNamed) {
      names.push_back(folder_of(trial, {}).string());
    }
  }
  if (missing == 0) {
    return {};
  }
  return fmt::format("{} of {} runs {} missing: {}{}", missing, asked_for,
                     missing == 1 ? "is" : "are", joined(names, ", "),
                     missing > kNamed ? ", ..." : "");
}

/// Tables, verdict, and what is to be said of them.
int report(const TrialsOptions& options, const std::vector<Trial>& trials, bool interrupted) {
  write_tables(options, trials);
  const std::vector<TrialGroup> groups = groups_of(trials);
  const bool all_passed = std::all_of(trials.begin(), trials.end(), [](const Trial& trial) {
    return trial.status == TrialStatus::kPassed || trial.left_out;
  });
  const std::string missing = missing_text(trials);
  write_metrics(options, trials, groups,
                interrupted  ? "interrupted"
                : all_passed ? "completed"
                             : "failed",
                interrupted ? "" : missing);
  if (!options.junit.empty()) {
    write_junit(options, trials);
  }
  if (options.study) {
    report_study(options, trials);
  } else if (!groups.empty()) {
    print_tables(groups);
  }
  report_recognition(options, trials);
  for (const Trial& trial : trials) {
    if (trial.status == TrialStatus::kFailed || trial.status == TrialStatus::kBroken) {
      for (const std::string& fault : faults(trial, options)) {
        std::printf("%s: %s\n", folder_of(trial, options.out_dir).c_str(), fault.c_str());
      }
    }
  }
  if (!missing.empty() && !interrupted) {
    std::printf("%s; panoptes trials --out %s makes them\n", missing.c_str(),
                options.out_dir.c_str());
  }
  return interrupted ? kInterrupted : all_passed ? 0 : 1;
}

/// Says which runs a study leaves out; how many rounds of its halving are over.
std::size_t leave_out(const TrialsOptions& options, std::vector<Trial>& trials) {
  return options.study ? leave_out(*options.study, trials) : 0;
}

std::vector<Trial*> pointers(std::vector<Trial>& trials) {
  std::vector<Trial*> all;
  for (Trial& trial : trials) {
    all.push_back(&trial);
  }
  return all;
}

/// Those that are not left out, of one shard.
std::vector<Trial*> due(std::vector<Trial>& trials, const Shard& shard = {}) {
  std::vector<Trial*> mine;
  int i = 0;
  for (Trial& trial : trials) {
    if (!trial.left_out && i++ % shard.count == shard.index - 1) {
      mine.push_back(&trial);
    }
  }
  return mine;
}

/// Takes the runs that need not be made again; how many they are.
int take_finished(const std::vector<Trial*>& trials, Results& results) {
  int finished = 0;
  for (Trial* trial : trials) {
    finished += results.take_finished(*trial) ? 1 : 0;
    results.check_what_is_there(*trial);
  }
  return finished;
}

/// Says which runs a race leaves out, by all that is there: one that broke is a run that failed.
/// How many of its rounds are over.
std::size_t take_rounds(const TrialsOptions& options, std::vector<Trial>& trials,
                        Results& results) {
  if (!options.study || !options.study->halving) {
    return 0;
  }
  for (Trial& trial : trials) {
    results.take(trial);
  }
  return leave_out(options, trials);
}

int run_planned(const TrialsOptions& options, std::vector<Trial>& trials, Results& results) {
  write_tables(options, trials);
  fs::remove(options.out_dir / "metrics.json");  // until all of them are done
  double written_s = steady_s();
  double writing_s = 0;
  const auto write_now_and_then = [&] {
    constexpr double kShare = 0.02;  // of the time at most goes into tables of what is done so far
    if (const double now_s = steady_s(); writing_s < kShare * (now_s - written_s)) {
      write_tables(options, trials);
      written_s = steady_s();
      writing_s = written_s - now_s;
    }
  };
  if (options.study && options.study->halving && !options.quiet) {
    std::fprintf(stderr, "halving: at most %zu of %zu runs will be made\n",
                 runs_of_halving(*options.study, trials), trials.size());
  }
  const StopCondition stop_condition{StopOptions()};
  bool interrupted = false;
  std::size_t rounds_over = leave_out(options, trials);
  for (bool more = true; more;) {
    interrupted = make_runs(options, due(trials), results, stop_condition, write_now_and_then);
    const std::size_t before = std::exchange(rounds_over, leave_out(options, trials));
    more = !interrupted && rounds_over > before;
  }
  if (interrupted) {  // what was cut short is run again next time
    for (Trial& trial : trials) {
      if (trial.status == TrialStatus::kBroken) {
        trial.status = TrialStatus::kWaiting;
        trial.figures = {};
      }
    }
    leave_out(options, trials);
  }
  remove_left_over(options, trials);
  return report(options, trials, interrupted);
}

/// That they did not come to their end, for whoever looks into the folder.
void tell_fault(const TrialsOptions& options, const std::string& fault) {
  const Json metrics{{"schema", "panoptes.metrics/1"},
                     {"command", "trials"},
                     {"version", options.version},
                     {"outcome", "failed"},
                     {"fault", as_utf8(fault)}};
  write_file(options.out_dir / "metrics.json", metrics.dump(2) + "\n");
}

/// What goes wrong while runs are made, or their tables, is told in metrics.json as well.
int with_faults_told(const TrialsOptions& options, const std::function<int()>& act) {
  Faults faults;
  int status = 0;
  faults.attempt([&] { status = act(); });
  if (!faults.none()) {
    faults.attempt([&] { tell_fault(options, faults.text()); });
    return faults.status();
  }
  return status;
}

}  // namespace

int run_trials(TrialsOptions options) {
  Results results(options);
  std::vector<Trial> trials =
      asks_for_runs(options) ? plan_trials(options) : planned_runs(options, results);
  take_finished(pointers(trials), results);
  check_holds_no_others(options, trials);
  make_trials_dir(options.out_dir);
  const FolderLock lock = lock_tables(options.out_dir);
  check_junit(options);
  if (asks_for_runs(options)) {
    write_manifest(options, results.hash_now(options.program), trials);
  }
  return with_faults_told(options, [&] { return run_planned(options, trials, results); });
}

int run_shard(TrialsOptions options, const Shard& shard) {
  Results results(options);
  std::vector<Trial> trials = planned_runs(options, results);
  take_rounds(options, trials, results);
  const std::vector<Trial*> mine = due(trials, shard);
  const int there = take_finished(mine, results);
  const StopCondition stop_condition{StopOptions()};
  const bool interrupted = make_runs(options, mine, results, stop_condition, [] {});
  int broken = 0;
  int made = -there;
  for (const Trial* trial : mine) {
    made += is_done(*trial) ? 1 : 0;
    if (trial->status == TrialStatus::kBroken) {
      ++broken;
      for (const std::string& fault : faults(*trial, options)) {
        std::printf("%s: %s\n", folder_of(*trial, options.out_dir).c_str(), fault.c_str());
      }
    }
  }
  std::printf("shard %d/%d: %zu %s, %d there before, %d made now, of which %d broke\n", shard.index,
              shard.count, mine.size(), mine.size() == 1 ? "run" : "runs", there, made, broken);
  return interrupted ? kInterrupted : broken > 0 ? 1 : 0;
}

int merge_trials(TrialsOptions options) {
  Results results(options);
  std::vector<Trial> trials = planned_runs(options, results);
  const FolderLock lock = lock_tables(options.out_dir);
  check_junit(options);
  for (Trial& trial : trials) {
    results.take(trial);
    results.check_what_is_there(trial);
  }
  leave_out(options, trials);
  return with_faults_told(options, [&] {
    remove_left_over(options, trials);
    return report(options, trials, false);
  });
}

int submit_trials(TrialsOptions options, SlurmOptions slurm) {
  Results results(options);
  std::vector<Trial> trials = planned_runs(options, results);
  check_junit(options);
  std::size_t rounds_over = take_rounds(options, trials, results);
  take_finished(pointers(trials), results);
  while (true) {
    const int status = submit_to_slurm(options, slurm, trials);
    const std::size_t before = rounds_over;
    rounds_over = slurm.wait ? take_rounds(options, trials, results) : before;
    if (rounds_over <= before || missing_text(trials).empty()) {
      return status;
    }
    slurm.resume = true;
  }
}

}  // namespace panoptes

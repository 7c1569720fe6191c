// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/run_trials.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "apps/command/folder_lock.h"
#include "apps/command/out_file.h"
#include "apps/mission/stop_condition.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "apps/trials/results.h"
#include "apps/trials/runs.h"
#include "apps/trials/tables.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

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

  void show(const std::vector<Trial>& trials, const std::vector<double>& took_s, int jobs) {
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
    std::vector<double> running_s;
    for (const Trial& trial : trials) {
      done += is_done(trial) ? 1 : 0;
      not_passed +=
          trial.status == TrialStatus::kFailed || trial.status == TrialStatus::kBroken ? 1 : 0;
      if (trial.status == TrialStatus::kWaiting) {
        ++waiting;
      } else if (trial.status == TrialStatus::kRunning) {
        running_s.push_back(now_s - trial.started_s);
      }
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

/// The verdicts' file can be written, or the user is told before anything runs.
void check_junit(const TrialsOptions& options) {
  if (options.junit.empty()) {
    return;
  }
  try {
    check_out_file("--junit", options.junit);
  } catch (const ConfigError&) {
    std::error_code ignored;
    if (std::filesystem::is_empty(options.out_dir, ignored)) {
      std::filesystem::remove(options.out_dir, ignored);
    }
    throw;
  }
}

/// A folder of trials is known by its trials.csv.
FolderLock claim_trials_dir(const std::filesystem::path& out_dir) {
  std::error_code fault;
  std::filesystem::create_directories(out_dir, fault);
  if (fault || !std::filesystem::is_directory(out_dir)) {
    throw ConfigError(out_dir.string() + ": cannot be made; name another folder with --out");
  }
  std::optional<FolderLock> lock = FolderLock::take(out_dir);
  if (!lock) {
    throw ConfigError(out_dir.string() +
                      ": another panoptes is writing there; name another folder with --out");
  }
  if (!std::filesystem::is_empty(out_dir) && !std::filesystem::exists(out_dir / "trials.csv")) {
    throw ConfigError(out_dir.string() +
                      ": holds something else than trials; name another folder with --out");
  }
  if (::access(out_dir.c_str(), W_OK | X_OK) != 0) {
    throw ConfigError(out_dir.string() + ": cannot be written; name another folder with --out");
  }
  return std::move(*lock);
}

void write_tables(const TrialsOptions& options, const std::vector<Trial>& trials) {
  write_csv(options, trials);
  write_study(options, trials);
}

int run_planned(const TrialsOptions& options, std::vector<Trial>& trials, double from_s) {
  const StopCondition stop_condition{StopOptions()};
  for (Trial& trial : trials) {
    is_finished(trial);
  }
  write_tables(options, trials);
  std::filesystem::remove(options.out_dir / "metrics.json");  // until all of them are done

  bool interrupted = false;
  {
    const Runs under_way(trials);
    TrialsProgress progress(options.quiet);
    std::vector<double> took_s;
    int passed_on = 0;
    while (true) {
      int running = 0;
      for (Trial& trial : trials) {
        if (trial.status == TrialStatus::kRunning) {
          collect(trial);
          if (trial.status == TrialStatus::kRunning) {
            ++running;
          } else {
            took_s.push_back(steady_s() - trial.started_s);
            write_tables(options, trials);
          }
        }
      }
      const int asked = (stop_condition.interrupted() ? 1 : 0) + (stop_condition.hurried() ? 1 : 0);
      for (; passed_on < asked; ++passed_on) {
        interrupted = true;
        under_way.ask();
      }
      for (Trial& trial : trials) {
        if (!interrupted && running < options.jobs && trial.status == TrialStatus::kWaiting) {
          start(trial, options);
          ++running;
        }
      }
      if (running == 0) {
        break;
      }
      progress.show(trials, took_s, options.jobs);
      constexpr auto kLook = std::chrono::milliseconds(50);
      std::this_thread::sleep_for(kLook);
    }
  }
  if (interrupted) {  // what was cut short is run again next time
    for (Trial& trial : trials) {
      if (is_done(trial) &&
          (trial.status == TrialStatus::kBroken || trial.outcome == "interrupted")) {
        trial.status = TrialStatus::kWaiting;
        trial.figures.clear();
      }
    }
  }
  write_tables(options, trials);
  const std::vector<TrialGroup> groups = groups_of(trials);
  const bool all_passed = std::all_of(trials.begin(), trials.end(), [](const Trial& trial) {
    return trial.status == TrialStatus::kPassed;
  });
  write_metrics(options, trials, groups,
                interrupted  ? "interrupted"
                : all_passed ? "completed"
                             : "failed",
                steady_s() - from_s);
  if (!options.junit.empty()) {
    write_junit(options.junit, trials);
  }
  if (options.study) {
    print_study(options, trials);
  } else if (!groups.empty()) {
    print_tables(groups);
  }
  report_recognition(options, trials);
  for (const Trial& trial : trials) {
    if (trial.status == TrialStatus::kFailed || trial.status == TrialStatus::kBroken) {
      for (const std::string& fault : faults(trial)) {
        std::printf("%s: %s\n", trial.dir.c_str(), fault.c_str());
      }
    }
  }
  return interrupted ? 130 : all_passed ? 0 : 1;
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

}  // namespace

int run_trials(const TrialsOptions& options) {
  const double from_s = steady_s();
  std::vector<Trial> trials = plan_trials(options);
  check_what_is_there(options, trials);
  const FolderLock lock = claim_trials_dir(options.out_dir);
  check_junit(options);
  Faults faults;
  int status = 0;
  faults.attempt([&] { status = run_planned(options, trials, from_s); });
  if (!faults.none()) {
    faults.attempt([&] { tell_fault(options, faults.text()); });
    return faults.status();
  }
  return status;
}

}  // namespace panoptes

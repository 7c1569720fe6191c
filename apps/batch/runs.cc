// SPDX-License-Identifier: BSD-3-Clause
#include "apps/batch/runs.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/command/folder_lock.h"
#include "apps/command/process_name.h"
#include "apps/process/stage_clock.h"
#include "core/base/error.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRun = "run";  // in the folder of a run that is under way: its results

// Of a run that is under way, beside where it will be.
constexpr std::string_view kPart = ".part-";
std::string part_prefix(const Trial& trial) { return fmt::format(".{}{}", trial.seed, kPart); }

std::vector<std::string> words_of(const Trial& trial, const TrialsOptions& options,
                                  const fs::path& part) {
  std::vector<std::string> words{"panoptes"};
  std::istringstream command(trial.point->command);
  for (std::string word; command >> word;) {
    words.push_back(word);
  }
  words.insert(words.end(), {trial.point->mission_file, "--quiet", "--out", (part / kRun).string(),
                             "--inputs", (part / kInputsFile).string()});
  if (options.threads || options.jobs > 1) {  // several runs share the machine already
    words.emplace_back("--threads");
    words.push_back(std::to_string(options.threads.value_or(1)));
  }
  for (const std::string& setting : set_of(trial)) {
    words.emplace_back("--set");
    words.push_back(setting);
  }
  return words;
}

pid_t spawn(const std::string& program, std::vector<std::string> words, const fs::path& log) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (output < 0) {
    throw IoError(log.string() + ": cannot be created: " + std::strerror(errno));
  }
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process == 0) {  // from here to exec only what a forked process may call
    ::setpgid(0, 0);   // a terminal's Ctrl-C reaches us alone, and is passed on once
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) {
      ::_exit(1);
    }
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::execve(program.c_str(), arguments.data(), environ);
    ::_exit(127);
  }
  const int fault = errno;
  ::close(output);
  if (process < 0) {
    throw IoError(std::string("cannot start a run: ") + std::strerror(fault));
  }
  return process;
}

// All but the figures, the settings, and what the run was made of.
void keep_metrics(const fs::path& run) {
  static const std::set<std::string> kept = {"metrics.json", "mission.yaml", "places.csv",
                                             kInputsFile, kEndFile};
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(run)) {
    if (!kept.contains(entry.path().filename())) {
      others.push_back(entry.path());
    }
  }
  for (const fs::path& other : others) {
    fs::remove_all(other);
  }
}

}  // namespace

void Runs::start(Trial& trial) {
  Running run{&trial, folder_of(trial, options_.out_dir), -1, 0};
  run.part.replace_filename(part_prefix(trial) + process_name());
  fs::remove_all(run.part);  // of a process before us, of the same name
  fs::create_directories(run.part);
  run.process =
      spawn(options_.program.string(), words_of(trial, options_, run.part), run.part / kLogFile);
  run.started_s = steady_s();
  trial.status = TrialStatus::kRunning;
  running_.push_back(run);
}

std::vector<double> Runs::collect() {
  std::vector<double> took_s;
  const std::vector<Running> all = std::exchange(running_, {});
  for (std::size_t i = 0; i < all.size(); ++i) {
    int status = 0;
    if (::waitpid(all[i].process, &status, WNOHANG) != all[i].process) {
      running_.push_back(all[i]);
      continue;
    }
    try {
      take(all[i], status);
    } catch (...) {
      running_.insert(running_.end(), all.begin() + static_cast<std::ptrdiff_t>(i) + 1, all.end());
      throw;
    }
    took_s.push_back(steady_s() - all[i].started_s);
  }
  return took_s;
}

// How it ended, where it left no whole run of its settings.
std::string Runs::broken_by(const Running& run, int status) const {
  const fs::path results = run.part / kRun;
  Trial left = *run.trial;
  const bool exited = WIFEXITED(status);
  const int code = exited ? WEXITSTATUS(status) : -1;
  const bool whole = results_.take_metrics(left, results);
  if (asked_ && (!whole || left.outcome == "interrupted")) {
    return {};
  }
  if (!(code == 0 || code == 1) || !whole) {
    return exited ? "exit status " + std::to_string(code)
                  : "ended by signal " + std::to_string(WTERMSIG(status));
  }
  return has_settings_of(left, results) ? "" : "ran with other settings than were planned";
}

void Runs::take(const Running& run, int status) {
  const fs::path results = run.part / kRun;
  fs::create_directories(results);
  for (const char* file : {kInputsFile, kLogFile}) {
    if (fs::exists(run.part / file)) {
      fs::rename(run.part / file, results / file);
    }
  }
  if (const std::string how = broken_by(run, status); !how.empty()) {
    write_file(results / kEndFile, how);
  } else if (options_.keep == Keep::kMetrics) {
    keep_metrics(results);
  }
  publish(run);
  results_.take(*run.trial);
}

void Runs::publish(const Running& run) {
  const fs::path folder = folder_of(*run.trial, options_.out_dir);
  const fs::path before = run.part / "before";
  while (true) {
    Trial there = *run.trial;
    if (results_.take_finished(there)) {
      break;  // somebody was first
    }
    std::error_code ignored;
    fs::remove_all(before);
    fs::rename(folder, before, ignored);  // what was cut short
    std::error_code fault;
    fs::rename(run.part / kRun, folder, fault);
    if (!fault) {
      break;
    }
    if (fault != std::errc::directory_not_empty && fault != std::errc::file_exists) {
      throw IoError(folder.string() + ": cannot be made: " + fault.message());
    }
  }
  fs::remove_all(run.part);
}

std::vector<double> Runs::running_s() const {
  std::vector<double> all;
  for (const Running& run : running_) {
    all.push_back(steady_s() - run.started_s);
  }
  return all;
}

void Runs::ask() {
  asked_ = true;
  for (const Running& run : running_) {
    ::kill(run.process, SIGINT);
  }
}

Runs::~Runs() {
  ask();
  for (const Running& run : running_) {
    int status = 0;
    ::waitpid(run.process, &status, 0);
    try {
      take(run, status);
    } catch (const std::exception&) {  // it stays where it was written
    }
  }
}

void remove_left_over(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::map<fs::path, std::set<std::string>> done;  // the prefixes of each folder
  for (const Trial& trial : trials) {
    if (is_done(trial)) {
      done[folder_of(trial, options.out_dir).parent_path()].insert(part_prefix(trial));
    }
  }
  for (const auto& [folder, prefixes] : done) {
    std::vector<fs::path> left;
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename();
      const auto end = name.find(kPart);
      if (name.starts_with('.') && end != std::string::npos &&
          prefixes.contains(name.substr(0, end + kPart.size()))) {
        left.push_back(entry.path());
      }
    }
    for (const fs::path& part : left) {
      const auto lock = FolderLock::take(part / kRun);
      if (lock) {
        fs::remove_all(part);
      }
    }
  }
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/runs.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/command/folder_lock.h"
#include "apps/process/stage_clock.h"
#include "apps/trials/results.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

/// Removes what an interrupted run has left. One that still writes there is not to be run into.
void make_room(const std::filesystem::path& dir) {
  std::filesystem::create_directories(dir);
  const auto lock = FolderLock::take(dir);
  if (!lock) {
    throw ConfigError(dir.string() + ": a run is still writing there; wait until it has ended");
  }
  std::filesystem::remove_all(dir);
}

// kill(-1) would reach every process of the user: a run that was collected has none.
bool has_process(const Trial& trial) {
  return trial.status == TrialStatus::kRunning && trial.process > 0;
}

}  // namespace

void start(Trial& trial, const TrialsOptions& options) {
  make_room(trial.dir);
  std::filesystem::remove(inputs_file(trial));
  std::vector<std::string> words = {
      "panoptes", "explore",          trial.mission_file, "--quiet",
      "--out",    trial.dir.string(), "--inputs",         inputs_file(trial).string()};
  if (options.threads || options.jobs > 1) {  // several runs share the machine already
    words.emplace_back("--threads");
    words.push_back(std::to_string(options.threads.value_or(1)));
  }
  for (const std::string& setting : trial.set) {
    words.push_back("--set");
    words.push_back(setting);
  }
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);
  std::filesystem::path log = trial.dir;
  log += ".log";
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (output < 0) {
    throw IoError(log.string() + ": cannot be created: " + std::strerror(errno));
  }
  const std::string program = options.program.string();
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
  trial.process = process;
  trial.started_s = steady_s();
  trial.status = TrialStatus::kRunning;
}

void collect(Trial& trial) {
  int status = 0;
  const pid_t ended = ::waitpid(trial.process, &status, WNOHANG);
  if (ended != trial.process) {
    return;
  }
  trial.process = -1;
  trial.status = TrialStatus::kBroken;  // unless it has left figures
  const bool exited = WIFEXITED(status);
  const int code = exited ? WEXITSTATUS(status) : -1;
  if (!(code == 0 || code == 1) || !take_metrics(trial)) {
    trial.outcome = exited ? "exit status " + std::to_string(code)
                           : "ended by signal " + std::to_string(WTERMSIG(status));
  }
}

Runs::~Runs() {
  ask();
  for (Trial& trial : trials_) {
    if (has_process(trial)) {
      ::waitpid(trial.process, nullptr, 0);
    }
  }
}

void Runs::ask() const {
  for (const Trial& trial : trials_) {
    if (has_process(trial)) {
      ::kill(trial.process, SIGINT);
    }
  }
}

}  // namespace panoptes

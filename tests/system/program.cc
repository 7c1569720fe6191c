// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/program.h"

#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/io/file.h"

namespace panoptes {

namespace fs = std::filesystem;

namespace {

// In the child: as a shell in a new window would be.
bool before_terminal(int terminal) {
  return ::setsid() >= 0 && ::ioctl(terminal, TIOCSCTTY, 0) == 0 &&
         ::dup2(terminal, STDIN_FILENO) >= 0 && ::dup2(terminal, STDERR_FILENO) >= 0;
}

// In the child: does not return.
[[noreturn]] void become(const std::vector<std::string>& words, const fs::path& folder,
                         const Fate& fate) {
  const auto onto = [](const fs::path& file, int descriptor) {
    const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    return opened >= 0 && ::dup2(opened, descriptor) >= 0;
  };
  const bool ready =
      ::chdir((folder / "work").c_str()) == 0 &&
      onto(fate.out.empty() ? folder / "stdout" : fs::path(fate.out), STDOUT_FILENO) &&
      (fate.terminal >= 0 ? before_terminal(fate.terminal)
                          : onto(folder / "stderr", STDERR_FILENO) &&
                                ::dup2(::open("/dev/null", O_RDONLY), 0) == 0);
  for (const int heard : {SIGINT, SIGHUP, SIGTERM}) {  // though whoever tests may ignore them
    ::signal(heard, SIG_DFL);
  }
  if (fate.largest_file_bytes) {
    const struct rlimit limit = {*fate.largest_file_bytes, *fate.largest_file_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ::setenv("PANOPTES_DATA", PANOPTES_SOURCE_DIR, 1);
  ::setenv("XDG_CACHE_HOME", PANOPTES_TEST_CACHE, 1);
  for (const auto& [name, value] : fate.environment) {
    ::setenv(name.c_str(), value.c_str(), 1);
  }
  std::vector<std::string> all = words;
  if (!fate.script.empty()) {
    all.front() = PANOPTES_PROGRAM;
    all.insert(all.begin(), {"bash", "-c", fate.script});
  }
  std::vector<char*> argv;
  argv.reserve(all.size() + 1);
  for (std::string& word : all) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  if (ready) {
    ::execv(fate.script.empty() ? fate.program.c_str() : "/bin/bash", argv.data());
  }
  ::_exit(127);
}

Said run(std::vector<std::string> words, const fs::path& folder, const Fate& fate) {
  words.insert(words.begin(), "panoptes");
  const pid_t child = ::fork();
  if (child == 0) {
    become(words, folder, fate);
  }
  if (child < 0) {  // kill() would take it for every process
    throw std::runtime_error("the program cannot be started");
  }
  int ended = 0;
  bool sent = fate.signal == 0;
  while (::waitpid(child, &ended, sent ? 0 : WNOHANG) == 0) {
    if (fs::exists(folder / "work" / fate.signal_when)) {
      ::kill(child, fate.signal);
      sent = true;
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  Said said;
  said.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  said.out = fate.out.empty() ? read_file(folder / "stdout") : "";
  said.err = fate.terminal >= 0 ? "" : read_file(folder / "stderr");
  return said;
}

// The office's light takes seconds to bake: once for all tests, whichever comes first.
void bake(const fs::path& folder) {
  const fs::path cache = PANOPTES_TEST_CACHE;
  fs::create_directories(cache);
  const int lock = ::open((cache / "lock").c_str(), O_RDWR | O_CREAT, 0644);
  ::flock(lock, LOCK_EX);
  run({"render", kOffice, "--pose", "5,4.4,90", "--out", "baked"}, folder, {});
  fs::remove_all(folder / "work" / "baked");
  ::close(lock);
}

}  // namespace

Said SystemTest::panoptes(const std::vector<std::string>& words, const Fate& fate) const {
  fs::create_directories(folder_ / "work");
  static bool baked = false;
  if (!baked) {
    bake(folder_);
    baked = true;
  }
  return run(words, folder_, fate);
}

Said SystemTest::explore(const std::string& mission, const std::string& out,
                         const std::vector<std::string>& more, const Fate& fate) const {
  std::vector<std::string> words{"explore", mission, "--quiet", "--out", out};
  words.insert(words.end(), more.begin(), more.end());
  return panoptes(words, fate);
}

nlohmann::json SystemTest::metrics(const std::string& out) const {
  return nlohmann::json::parse(read_file(folder_ / "work" / out / "metrics.json"));
}

std::string SystemTest::write(const std::string& name, const std::string& text) const {
  fs::create_directories(folder_ / "work");
  write_file(folder_ / "work" / name, text);
  return name;
}

std::map<std::string, std::string> comparable(const fs::path& run) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(run)) {
    if (!entry.is_regular_file()) {
      continue;
    }
    std::string text = read_file(entry.path());
    if (entry.path().filename() == "metrics.json") {
      auto json = nlohmann::ordered_json::parse(text);
      for (const char* key : {"wall_s", "cpu_s", "real_time_factor", "peak_memory_mb", "timing_ms",
                              "timing_cpu_ms"}) {
        json.erase(key);
      }
      text = json.dump(2);
    }
    files[fs::relative(entry.path(), run)] = std::move(text);
  }
  return files;
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/process/stage_clock.h"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <string>

#include <sys/resource.h>

#include "core/base/check.h"
#include "core/eval/statistics.h"

namespace panoptes {
namespace {

std::int64_t read_ns(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

struct Spent {
  double wall_s = 0;
  double cpu_s = 0;
};

Spent spent() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  const auto seconds_of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  return {steady_s(), seconds_of(use.ru_utime) + seconds_of(use.ru_stime)};
}

/// When the program began: a script that becomes it by exec has spent time before, in the same
/// process.
const Spent kAtStart = spent();

/// The program's own: getrusage counts what ran in this process before it.
double peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (double kib = 0; word == "VmHWM:" && status >> kib) {
      return kib / 1024;
    }
  }
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_maxrss) / 1024;
}

}  // namespace

void StageClock::begin(std::string_view stage) {
  auto at = stages_.find(stage);
  if (at == stages_.end()) {
    at = stages_.emplace(std::string(stage), Stage{}).first;
    at->second.frames_ms.assign(frames_, 0.0);
    at->second.frames_cpu_ms.assign(frames_, 0.0);
  }
  at->second.cpu_from_ns = read_ns(CLOCK_PROCESS_CPUTIME_ID);
  at->second.wall_from_ns = read_ns(CLOCK_MONOTONIC);
}

void StageClock::end(std::string_view stage) {
  const auto at = stages_.find(stage);
  PANOPTES_CHECK(at != stages_.end(), "a stage begins before it ends");
  at->second.wall_ns += read_ns(CLOCK_MONOTONIC) - at->second.wall_from_ns;
  at->second.cpu_ns += read_ns(CLOCK_PROCESS_CPUTIME_ID) - at->second.cpu_from_ns;
}

void StageClock::end_frame() {
  ++frames_;
  for (auto& [name, stage] : stages_) {
    stage.frames_ms.push_back(static_cast<double>(stage.wall_ns) * 1e-6);
    stage.frames_cpu_ms.push_back(static_cast<double>(stage.cpu_ns) * 1e-6);
    stage.wall_ns = 0;
    stage.cpu_ns = 0;
  }
}

std::map<std::string, StageFigures> StageClock::figures() const {
  std::map<std::string, StageFigures> all;
  for (const auto& [name, stage] : stages_) {
    if (stage.frames_ms.empty()) {
      continue;
    }
    StageFigures& figures = all[name];
    figures.mean_ms = mean_interval(stage.frames_ms).mean;
    figures.p50_ms = quantile(stage.frames_ms, 0.5);
    figures.p99_ms = quantile(stage.frames_ms, 0.99);
    figures.max_ms = quantile(stage.frames_ms, 1);
    figures.cpu_mean_ms = mean_interval(stage.frames_cpu_ms).mean;
    figures.cpu_p99_ms = quantile(stage.frames_cpu_ms, 0.99);
  }
  return all;
}

ProcessUse process_use() {
  const Spent now = spent();
  return {now.wall_s - kAtStart.wall_s, now.cpu_s - kAtStart.cpu_s, peak_memory_mb()};
}

double steady_s() { return static_cast<double>(read_ns(CLOCK_MONOTONIC)) * 1e-9; }

}  // namespace panoptes

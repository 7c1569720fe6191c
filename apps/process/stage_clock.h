// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace panoptes {

/// What a stage of the loop cost, a frame set.
struct StageFigures {
  double mean_ms = 0;  ///< wall time
  double p50_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
  double cpu_mean_ms = 0;  ///< CPU time of all threads
  double cpu_p99_ms = 0;
};

/// Measures the stages of the loop. A stage may begin and end several times a frame set; one that
/// did not run counts nothing there.
class StageClock {
 public:
  void begin(std::string_view stage);
  void end(std::string_view stage);
  void end_frame();

  std::map<std::string, StageFigures> figures() const;

 private:
  struct Stage {
    std::int64_t wall_from_ns = 0;
    std::int64_t cpu_from_ns = 0;
    std::int64_t wall_ns = 0;  ///< in this frame set
    std::int64_t cpu_ns = 0;
    std::vector<double> frames_ms;
    std::vector<double> frames_cpu_ms;
  };
  std::map<std::string, Stage, std::less<>> stages_;
  std::size_t frames_ = 0;
};

/// For as long as it lives, a stage runs.
class TimedStage {
 public:
  TimedStage(StageClock& clock, std::string_view stage) : clock_(clock), stage_(stage) {
    clock_.begin(stage_);
  }
  ~TimedStage() { clock_.end(stage_); }
  TimedStage(const TimedStage&) = delete;
  TimedStage& operator=(const TimedStage&) = delete;

 private:
  StageClock& clock_;
  std::string_view stage_;
};

/// What the program has used since it was started.
struct ProcessUse {
  double wall_s = 0;
  double cpu_s = 0;  ///< of all threads
  double peak_memory_mb = 0;
};
ProcessUse process_use();

/// A clock that only goes forward, for differences.
double steady_s();

}  // namespace panoptes

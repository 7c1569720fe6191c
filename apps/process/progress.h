// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace panoptes {

/// A line on stderr: drawn again and again on a terminal, one plain line every 30 s elsewhere.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Whether it is time for another one. Cheap.
  bool due() const;
  void show(const std::string& text);

  double wall_s() const;  ///< since it was made

 private:
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  double started_s_;
  double shown_s_;
};

/// How far a run is, with the time left.
class Progress {
 public:
  Progress(Duration length, bool quiet);

  /// Cheap when nothing is due.
  void show(Time now, const std::string& doing);

 private:
  double length_s_;
  ProgressLine line_;
};

/// `1:05 of 10:00 (11 %), 2:10 left`: `wall_s` since the start. No estimate before there is one.
std::string progress_line(double now_s, double length_s, double wall_s);

/// How long it takes until runs that are like others are done, `jobs` at once: `took_s` of those
/// that are done, how long others have been running, how many wait. Empty before one is done, and
/// where only such are left as have run longer than any that is done.
std::optional<double> time_left_s(const std::vector<double>& took_s,
                                  const std::vector<double>& running_s, std::size_t waiting,
                                  int jobs);

/// `1:05`
std::string minutes_text(double seconds);

/// `light and shadow: 40 %, 0:12 left`
std::string share_line(const std::string& what, double done, double wall_s);

}  // namespace panoptes

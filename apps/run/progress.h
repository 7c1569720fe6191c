// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

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

/// `light and shadow: 40 %, 0:12 left`
std::string share_line(const std::string& what, double done, double wall_s);

}  // namespace panoptes

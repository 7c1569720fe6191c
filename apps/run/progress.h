// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/time.h"

namespace panoptes {

/// How far a run is, on stderr, with the time left: one line drawn again and again on a terminal,
/// one plain line every 30 s elsewhere.
class Progress {
 public:
  Progress(Duration length, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap when nothing is due.
  void show(Time now, const std::string& doing);

 private:
  bool due(double wall_s) const;

  double length_s_;
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  double started_s_;
  double shown_s_;
};

/// `1:05 of 10:00 (11 %), 2:10 left`: `wall_s` since the start. No estimate before there is one.
std::string progress_line(double now_s, double length_s, double wall_s);

}  // namespace panoptes

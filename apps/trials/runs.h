// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "apps/trials/plan.h"

namespace panoptes {

/// Runs it as a process of its own, whose words go to a log beside its folder.
void start(Trial& trial, const TrialsOptions& options);

/// Looks whether it has ended, and takes what it left.
void collect(Trial& trial);

/// Ends the runs that are under way, as Ctrl-C would, when trials end in an unusual way.
class Runs {
 public:
  explicit Runs(std::vector<Trial>& trials) : trials_(trials) {}
  ~Runs();
  Runs(const Runs&) = delete;
  Runs& operator=(const Runs&) = delete;

  /// Asks each of them to end.
  void ask() const;

 private:
  std::vector<Trial>& trials_;
};

}  // namespace panoptes

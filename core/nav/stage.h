// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string_view>

namespace panoptes {

/// Told where a stage of a step begins and ends, so that the caller can time it: core has no clock.
/// Stages are "odometry", "slam", "mapping" and "planning", and "rectifying" before them where a
/// lens bends; they do not overlap.
using StageListener = std::function<void(std::string_view stage, bool begins)>;

/// Reports one stage for as long as it lives.
class StageScope {
 public:
  StageScope(const StageListener& listener, std::string_view stage)
      : listener_(listener), stage_(stage) {
    if (listener_) {
      listener_(stage_, true);
    }
  }
  ~StageScope() {
    if (listener_) {
      listener_(stage_, false);
    }
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  const StageListener& listener_;
  std::string_view stage_;
};

}  // namespace panoptes

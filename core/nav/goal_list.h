// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/nav/pilot_step.h"

namespace panoptes {

/// Places to drive to in turn, in `map`, and what has become of each. The first that is neither
/// reached nor refused is the present one.
class GoalList {
 public:
  explicit GoalList(const std::vector<Vec2>& goals_map);

  bool empty() const { return goals_.empty(); }
  bool done() const { return present_ == goals_.size(); }
  const std::vector<GoalProgress>& all() const { return goals_; }

  /// Of the present one; there is one until it is done.
  const GoalProgress& present() const;
  std::size_t number() const { return present_ + 1; }  ///< as people count

  void begin(Time now);  ///< the present one, where it has not begun
  void reach(Time now);
  void refuse(Time now, std::string why);

 private:
  GoalProgress& end(Time now, GoalProgress::State state);

  std::vector<GoalProgress> goals_;
  std::size_t present_ = 0;
};

}  // namespace panoptes

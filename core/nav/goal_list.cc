// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/goal_list.h"

#include <string>
#include <utility>

#include "core/base/check.h"

namespace panoptes {

GoalList::GoalList(const std::vector<Vec2>& goals_map) {
  for (const Vec2& goal_map : goals_map) {
    goals_.emplace_back().goal_map = goal_map;
  }
}

const GoalProgress& GoalList::present() const {
  PANOPTES_CHECK(!done(), "a goal is left");
  return goals_[present_];
}

void GoalList::begin(Time now) {
  PANOPTES_CHECK(!done(), "a goal is left");
  GoalProgress& goal = goals_[present_];
  if (!goal.began) {
    goal.began = now;
    goal.state = GoalProgress::State::kPursued;
  }
}

GoalProgress& GoalList::end(Time now, GoalProgress::State state) {
  begin(now);
  GoalProgress& goal = goals_[present_++];
  goal.ended = now;
  goal.state = state;
  return goal;
}

void GoalList::reach(Time now) { end(now, GoalProgress::State::kReached); }

void GoalList::refuse(Time now, std::string why) {
  end(now, GoalProgress::State::kRefused).why = std::move(why);
}

}  // namespace panoptes

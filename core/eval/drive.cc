// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/drive.h"

#include <algorithm>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kProgress_m = 0.5;
constexpr Duration kWindow = std::chrono::seconds(60);

// Where the window without progress begins that ends with pose `end`; empty when there is none.
std::optional<Time> stuck_since(const std::vector<TruePose>& poses,
                                const std::vector<bool>& has_goal, std::size_t end) {
  const Vec2 p_scene = poses[end].T_scene_body.position();
  for (std::size_t i = end + 1; i-- > 0;) {
    if (!has_goal[i] || (poses[i].T_scene_body.position() - p_scene).norm() >= kProgress_m) {
      return std::nullopt;
    }
    if (poses[end].stamp - poses[i].stamp >= kWindow) {
      return poses[i].stamp;
    }
  }
  return std::nullopt;
}

}  // namespace

int collisions(const Truth& truth) {
  return static_cast<int>(std::count_if(truth.contacts.begin(), truth.contacts.end(),
                                        [](const TrueContact& c) { return c.while_moving; }));
}

int collisions_while_stopped(const Truth& truth) {
  return static_cast<int>(truth.contacts.size()) - collisions(truth);
}

std::optional<double> min_clearance_m(const Truth& truth) {
  if (truth.poses.empty()) {
    return std::nullopt;
  }
  return std::min_element(
             truth.poses.begin(), truth.poses.end(),
             [](const TruePose& a, const TruePose& b) { return a.clearance_m < b.clearance_m; })
      ->clearance_m;
}

double stuck_s(const std::vector<TruePose>& poses, const std::vector<bool>& has_goal) {
  PANOPTES_CHECK(poses.size() == has_goal.size(), "whether a goal was set at every pose");
  Duration stuck{0};
  Time counted_to = Time::min();  // windows overlap; their union counts
  for (std::size_t end = 0; end < poses.size(); ++end) {
    if (const auto since = stuck_since(poses, has_goal, end)) {
      stuck += poses[end].stamp - std::max(*since, counted_to);
      counted_to = poses[end].stamp;
    }
  }
  return to_seconds(stuck);
}

bool ends_stuck(const std::vector<TruePose>& poses, const std::vector<bool>& has_goal) {
  PANOPTES_CHECK(poses.size() == has_goal.size(), "whether a goal was set at every pose");
  return !poses.empty() && stuck_since(poses, has_goal, poses.size() - 1);
}

}  // namespace panoptes

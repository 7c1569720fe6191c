// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace panoptes {
namespace {

// More make it no better, and slow.
constexpr std::size_t kMostInstants = 400;
constexpr double kCoarser = 1.3;
// Where the body was twice, out and back, a third time shows nothing new.
constexpr int kVisits = 2;
constexpr double kInstant_m = 0.1;
constexpr double kInstant_rad = deg_to_rad(6);

using Place = std::array<long, 3>;

Place place_at(const WheelReadings& wheels, Time instant, double cells) {
  const Pose2 T = wheels(instant)->T_odom_body;
  const double turn_rad = std::remainder(T.theta_rad, 2 * std::numbers::pi);
  return {std::lround(T.x_m / (cells * kInstant_m)), std::lround(T.y_m / (cells * kInstant_m)),
          std::lround(turn_rad / (cells * kInstant_rad))};
}

// Of clocks that are not known better a picture may be so much earlier or later.
constexpr Duration kAbout = std::chrono::milliseconds(20);

/// Whether the body stood from one instant to another, and about both. No tick of the wheels is as
/// little as what may be told of rounding.
bool stood(const WheelReadings& wheels, Time from, Time to) {
  constexpr double kNothing = 1e-6;  // in m and rad
  const std::optional<Odometry> before = wheels(from - kAbout);
  for (const Time at : {from, to, to + kAbout}) {
    const std::optional<Odometry> now = wheels(at);
    if (!before || !now) {
      return false;
    }
    const Pose2 moved = before->T_odom_body.inverse() * now->T_odom_body;
    if (moved.position().norm() > kNothing || std::abs(moved.theta_rad) > kNothing) {
      return false;
    }
  }
  return true;
}

ChosenViews choose_views(const std::vector<TakenPicture>& taken, std::size_t cameras,
                         const WheelReadings& wheels, Duration same, double cells) {
  ChosenViews out;
  std::vector<std::map<Place, int>> been(cameras);
  std::vector<std::optional<Place>> last(cameras);
  for (std::size_t first = 0; first < taken.size();) {
    std::size_t end = first;
    std::vector<bool> has(cameras, false);
    while (end < taken.size() && !has[taken[end].camera] &&
           (taken[end].instant - taken[first].instant <= same ||
            stood(wheels, taken[first].instant, taken[end].instant))) {
      has[taken[end++].camera] = true;
    }
    const Time instant = taken[first].instant + (taken[end - 1].instant - taken[first].instant) / 2;
    const Place place = place_at(wheels, taken[first].instant, cells);
    const bool is_new =
        std::any_of(taken.begin() + static_cast<std::ptrdiff_t>(first),
                    taken.begin() + static_cast<std::ptrdiff_t>(end), [&](const auto& each) {
                      return last[each.camera] != place && been[each.camera][place] < kVisits;
                    });
    for (std::size_t i = first; i < end && is_new; ++i) {
      const std::size_t c = taken[i].camera;
      ++been[c][place];
      last[c] = place;
      out.views.push_back({c, out.instants.size(), taken[i].frame});
    }
    if (is_new) {
      out.instants.push_back(instant);
    }
    first = end;
  }
  return out;
}

}  // namespace

ChosenViews choose_views(const std::vector<TakenPicture>& taken, std::size_t cameras,
                         const WheelReadings& wheels, Duration same) {
  for (double cells = 1;; cells *= kCoarser) {
    ChosenViews chosen = choose_views(taken, cameras, wheels, same, cells);
    if (chosen.instants.size() <= kMostInstants) {
      return chosen;
    }
  }
}

std::vector<RigSeen> sightings(const std::vector<RigCamera>& rig, const std::vector<RigView>& views,
                               const std::vector<Pose3>& T_start_camera, const Vec3& p_start,
                               std::size_t point, std::size_t camera_of_point) {
  std::vector<RigSeen> seen;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Intrinsics& lens = rig[views[v].camera].intrinsics;
    const Vec3 p_camera = T_start_camera[v].inverse() * p_start;
    if (lens.sees(p_camera)) {
      seen.push_back({v, point, lens.project(p_camera), views[v].camera == camera_of_point, true});
    }
  }
  return seen;
}

std::vector<int> shared_points(const RigTracks& tracks, const std::vector<int>& map_of_point,
                               std::size_t cameras) {
  std::set<std::pair<std::size_t, std::size_t>> pairs;  // a camera, a point
  for (const RigSeen& seen : tracks.seen) {
    if (seen.believed && !seen.own) {
      pairs.emplace(tracks.views[seen.view].camera, seen.point);
      pairs.emplace(static_cast<std::size_t>(map_of_point[seen.point]), seen.point);
    }
  }
  std::vector<int> shared(cameras, 0);
  for (const auto& [camera, point] : pairs) {
    ++shared[camera];
  }
  return shared;
}

}  // namespace panoptes

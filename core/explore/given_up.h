// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/base/time.h"
#include "core/graph/anchored_pose.h"
#include "core/map/occupancy.h"

namespace panoptes {

/// Places that are left alone because nothing got on there. One comes back only when the map about
/// it has changed since, and not before its time, which is twice as long whenever the place is
/// given up again. Held by the keyframes nearest to them.
class GivenUp {
 public:
  /// What lies within `within_m` of a place is given up with it. `for_s` is the first time.
  GivenUp(double within_m, double for_s);

  /// What is known of a point of the map.
  using Known = std::function<Cell(const Vec2& p_map)>;

  /// `known` is what it was given up for.
  void add(Time now, const Pose2& T_map_place, const Known& known,
           std::span<const Pose2> T_map_keyframes);

  /// The places go with the keyframes, and those come back whose time is over and about which the
  /// map has changed.
  void update(Time now, const Known& known, std::span<const Pose2> T_map_keyframes);

  bool contains(const Vec2& p_map) const;

  /// Those come back about which the map has changed, however lately they were given up.
  void reopen_changed(const Known& known);

  /// Those that have been given up only once come back, changed or not. False where there are none.
  bool try_again();

  /// Those that are left alone now.
  std::vector<Vec2> places_map() const;

 private:
  struct Place {
    AnchoredPose at;
    std::vector<Cell> around;  // as sampled about it when it was given up
    Time until;
    double for_s = 0;
    bool left_alone = true;
  };

  double within_m_;
  double for_s_;
  std::vector<Place> places_;
};

}  // namespace panoptes

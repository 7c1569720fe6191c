// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/map/floor_mapper.h"
#include "core/map/occupancy.h"

namespace panoptes {

/// What stands now where there was floor before: somebody who came, a door that was shut. The local
/// map sums up what many pictures said and takes a second to learn otherwise; the robot is told at
/// once, by this. Who comes is wider than his feet, which are what is seen of him.
class Newcomers {
 public:
  /// `reading`: of a floor camera that was at `T_odom_body` then. `known_odom`: the local map as it
  /// was a second or two before.
  void add(const FloorReading& reading, const Pose2& T_odom_body, const OccupancyMap& known_odom,
           Time stamp);

  /// Where they stood that the last picture showed to have gone, in `odom`: it is floor again.
  const std::vector<Vec2>& left_odom() const { return left_odom_; }

  /// Whether there was any so far.
  bool ever() const { return ever_; }

  /// Where they stand, in `odom`.
  std::vector<Vec2> places_odom() const;

  /// Makes discs about them occupied.
  void occupy(OccupancyMap& local_odom) const;

 private:
  using Key = std::pair<int, int>;  // of a cell of kPlace_m
  struct Place {
    Time first;
    Time last;
    int seen_free = 0;  // pictures in a row
  };
  struct Seen {  // of a cell, in one picture
    int standing = 0;
    int floor = 0;
  };

  bool ever_ = false;
  std::map<Key, Place> places_;
  std::vector<Vec2> left_odom_;
  std::deque<std::vector<Key>> late_;  // what stood in the last pictures, the latest last
};

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/newcomers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace panoptes {
namespace {

constexpr double kPlace_m = 0.05;
constexpr double kFar_m = 2;          // from the camera's foot: farther away there is time
constexpr double kEdge_m = 0.10;      // nearer to what is known to stand it may be that
constexpr double kLeast_m2 = 0.0006;  // of a place must show it
constexpr int kClearly = 4;           // eighths of a nat
constexpr int kPictures = 3;          // of the last
constexpr int kLate = 4;              // ones must show it
constexpr int kStep = 3;              // places that it may have gone in between
constexpr int kFree = 2;              // pictures in a row that show floor: it has gone
constexpr double kKept_s = 10;        // while it is out of view
constexpr double kNew_s = 60;         // what stands longer is no newcomer
constexpr double kRadius_m = 0.15;    // beyond what is seen of it

bool near_known(const OccupancyMap& map, int column, int row) {
  constexpr int kDirections = 8;
  static constexpr int kColumns[kDirections] = {1, 1, 0, -1, -1, -1, 0, 1};
  static constexpr int kRows[kDirections] = {0, 1, 1, 1, 0, -1, -1, -1};
  const int reach = static_cast<int>(std::lround(kEdge_m / map.cell_m));
  for (const int step : {reach / 2, reach}) {
    for (int k = 0; k < kDirections; ++k) {
      if (map.at(column + step * kColumns[k], row + step * kRows[k]) == Cell::kOccupied) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

void Newcomers::add(const FloorReading& reading, const Pose2& T_odom_body,
                    const OccupancyMap& known_odom, Time stamp) {
  const FloorProjection& p = *reading.projection;
  const Pose2 T_odom_view = T_odom_body * p.T_body_view;
  const Mat2 R_odom_view = T_odom_view.rotation();
  const Vec2 view_odom = T_odom_view.position();
  const auto key = [](const Vec2& p_odom) {
    return Key(static_cast<int>(std::floor(p_odom.x() / kPlace_m)),
               static_cast<int>(std::floor(p_odom.y() / kPlace_m)));
  };
  std::map<Key, Seen> seen;
  for (int row = 0; row < p.cell_rows; ++row) {
    for (int column = 0; column < p.cell_columns; ++column) {
      const int evidence =
          reading.evidence[static_cast<std::size_t>(row * p.cell_columns + column)];
      if (evidence > -kClearly && (evidence < kClearly || places_.empty())) {
        continue;
      }
      const Vec2 p_view = p.origin_view + p.cell_m * Vec2(column + 0.5, row + 0.5);
      if ((p_view - p.foot_view).norm() > kFar_m) {
        continue;
      }
      const Vec2 p_odom = view_odom + R_odom_view * p_view;
      const Key at = key(p_odom);
      const bool is_place = places_.contains(at);
      if (evidence > 0) {
        if (is_place) {
          ++seen[at].floor;
        }
        continue;
      }
      const int map_column = known_odom.column(p_odom);
      const int map_row = known_odom.row(p_odom);
      if (is_place || (known_odom.at(map_column, map_row) == Cell::kFree &&
                       !near_known(known_odom, map_column, map_row))) {
        ++seen[at].standing;
      }
    }
  }
  const int least = static_cast<int>(std::ceil(kLeast_m2 / (p.cell_m * p.cell_m)));
  std::vector<Key> now;
  for (const auto& [at, counts] : seen) {
    if (counts.standing >= least) {
      now.push_back(at);
    }
  }
  for (const Key& at : now) {
    const auto pictures = std::count_if(late_.begin(), late_.end(), [&](const auto& before) {
      return std::any_of(before.begin(), before.end(), [&](const Key& other) {
        return std::abs(other.first - at.first) <= kStep &&
               std::abs(other.second - at.second) <= kStep;
      });
    });
    if (pictures >= kPictures - 1) {
      ever_ = true;
      Place& place = places_.try_emplace(at, Place{stamp, stamp, 0}).first->second;
      place.last = stamp;
      place.seen_free = 0;
    }
  }
  for (auto& [at, place] : places_) {
    const auto counts = seen.find(at);
    if (counts != seen.end() && counts->second.standing == 0 && counts->second.floor >= least) {
      ++place.seen_free;
    }
  }
  left_odom_.clear();
  for (const auto& [at, place] : places_) {
    if (place.seen_free >= kFree) {
      for (const Vec2& part :
           {Vec2(0.25, 0.25), Vec2(0.25, 0.75), Vec2(0.75, 0.25), Vec2(0.75, 0.75)}) {
        left_odom_.push_back(kPlace_m * (Vec2(at.first, at.second) + part));
      }
    }
  }
  std::erase_if(places_, [&](const auto& entry) {
    const Place& place = entry.second;
    return place.seen_free >= kFree || to_seconds(stamp - place.last) > kKept_s ||
           to_seconds(stamp - place.first) > kNew_s;
  });
  late_.push_back(std::move(now));
  while (late_.size() >= kLate) {
    late_.pop_front();
  }
}

std::vector<Vec2> Newcomers::places_odom() const {
  std::vector<Vec2> places;
  places.reserve(places_.size());
  for (const auto& [at, place] : places_) {
    places.push_back(kPlace_m * Vec2(at.first + 0.5, at.second + 0.5));
  }
  return places;
}

void Newcomers::occupy(OccupancyMap& local_odom) const {
  for (const Vec2& p : places_odom()) {
    occupy_disc(local_odom, p, kRadius_m);
  }
}

}  // namespace panoptes

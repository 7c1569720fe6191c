// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/shadows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace panoptes {
namespace {

// Sightings in one cell are of one place.
constexpr double kPlace_m = 0.05;
constexpr int kSightings = 2;

// How far from a camera a place may be to hide what it sees.
constexpr double kNear_m = 4;

// Places are known to some centimetres. Their shadows begin behind them by so much, and are no
// wider than what surely belongs to them, so that no floor is lost before a wall.
constexpr double kBehind_m = 0.05;
constexpr double kHalfWidth_m = 0.03;

struct Place {
  StandingPoint at_map;
  int sightings = 0;
};

std::vector<StandingPoint> standing_places(std::span<const PlacedGrid> grids) {
  std::map<std::pair<int, int>, Place> places;
  for (const PlacedGrid& grid : grids) {
    for (const StandingPoint& point : grid.grid->standing) {
      const Vec2 p = grid.T_map_keyframe * point.p;
      Place& place = places[{static_cast<int>(std::floor(p.x() / kPlace_m)),
                             static_cast<int>(std::floor(p.y() / kPlace_m))}];
      place.at_map.p = (place.sightings * place.at_map.p + p) / (place.sightings + 1);
      place.at_map.height_m = std::max(place.at_map.height_m, point.height_m);
      ++place.sightings;
    }
  }
  std::vector<StandingPoint> standing;
  for (const auto& [cell, place] : places) {
    if (place.sightings >= kSightings) {
      standing.push_back(place.at_map);
    }
  }
  for (const PlacedGrid& grid : grids) {
    for (const Vec2& body : grid.grid->traversed) {
      const Vec2 p = grid.T_map_keyframe * body;
      std::erase_if(standing, [&](const StandingPoint& place) {
        return (place.p - p).norm() < grid.grid->body_radius_m;
      });
    }
  }
  return standing;
}

}  // namespace

std::vector<PlacedGrid> without_shadows(std::span<const PlacedGrid> grids) {
  const std::vector<StandingPoint> places_map = standing_places(grids);
  std::vector<PlacedGrid> out(grids.begin(), grids.end());
  for (PlacedGrid& grid : out) {
    const Pose2 T_keyframe_map = grid.T_map_keyframe.inverse();
    std::vector<StandingPoint> standing;
    for (const StandingPoint& place : places_map) {
      const StandingPoint at{T_keyframe_map * place.p, place.height_m};
      if (std::any_of(
              grid.grid->cameras.begin(), grid.grid->cameras.end(),
              [&](const CameraPlace& camera) { return (camera.foot - at.p).norm() < kNear_m; })) {
        standing.push_back(at);
      }
    }
    auto hidden = std::make_shared<GridCrop>(*grid.grid);
    if (hide_behind(*hidden, standing, kHalfWidth_m, kBehind_m)) {
      grid.grid = std::move(hidden);
    }
  }
  return out;
}

}  // namespace panoptes

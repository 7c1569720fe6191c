// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "sim/world/load.h"
#include "sim/world/passability_grid.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {

enum class RoomKind { kHall, kLiving, kKitchen, kBedroom, kStudy, kBath };

/// A room of a home, its walls standing.
struct HomeRoom {
  RoomKind kind = RoomKind::kHall;
  Rectangle area;
  std::vector<WallFace> faces;        ///< south, east, north, west
  std::vector<bool> is_outside;       ///< of each face
  std::vector<Rectangle> keep_clear;  ///< floor where nothing may stand: before doors
  std::vector<Rectangle> solid = {};  ///< what of the area is no floor
  std::vector<std::pair<std::size_t, Rectangle>> bare = {};  ///< of a face, where nothing hangs
  double clutter = 0;  ///< things that stand about, of what fits
};

/// The faces of a room's four walls in the order of HomeRoom.
std::vector<WallFace> faces_of(const Rectangle& area);

/// The picture of its walls, and of its floor.
std::string wall_picture(RoomKind kind);
std::string floor_picture(RoomKind kind);

/// Lamps, windows, furniture for what the room is, and what hangs on its walls. Leaves passages of
/// 0.9 m.
void furnish(WorldSettings& into, HomeRoom room, PassabilityGrid& passability, Rng rng);

}  // namespace panoptes::sim

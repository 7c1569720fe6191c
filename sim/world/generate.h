// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/config/fields.h"
#include "core/geometry/pose2.h"

namespace panoptes::sim {

struct WorldSettings;

/// A room of desks in blocks with aisles between them, cupboards, shelves and boards along walls.
struct OfficePlan {
  static constexpr std::string_view kName = "office";
  Vec2 size_m = Vec2(10, 10);
  int desks = 16;
  bool overhangs = false;  ///< desks on legs, table edges, chair seats that reach over the floor
  double texture = 1;      ///< share of what hangs and lies about: papers, posters, books; 0: bare
  std::uint64_t seed = 1;
};

/// A flat: rooms with doorways around a hall, each furnished for what it is.
struct HomePlan {
  static constexpr std::string_view kName = "home";
  Vec2 size_m = Vec2(11, 9);
  int rooms = 4;
  std::uint64_t seed = 1;
};

/// Two halves, each the other turned by half a turn, alike to the posters: made to be confused.
struct MirroredPlan {
  static constexpr std::string_view kName = "mirrored";
  Vec2 size_m = Vec2(14, 9);
  int desks = 16;
  std::uint64_t seed = 1;
};

/// Corridors that meet at right angles and close rings, with doors, notice boards and alcoves that
/// repeat.
struct CorridorsPlan {
  static constexpr std::string_view kName = "corridors";
  Vec2 size_m = Vec2(20, 14);
  int loops = 2;
  double width_m = 1.8;
  std::uint64_t seed = 1;
};

/// A hall of pallet racks with aisles, pallets on the floor, marked lanes.
struct WarehousePlan {
  static constexpr std::string_view kName = "warehouse";
  Vec2 size_m = Vec2(18, 12);
  int racks = 4;
  std::uint64_t seed = 1;
};

/// A street around one block of houses, under the sky.
struct StreetPlan {
  static constexpr std::string_view kName = "street";
  double length_m = 300;  ///< of the path around the block
  std::uint64_t seed = 1;
};

/// A building from a ROS map_server map of one floor of it: walls of all that is not its largest
/// piece of free floor, straightened (sim/world/map_walls.h), with papers by room, doors, boards
/// and pictures, a floor, a ceiling and lamps. In the map's own frame times `scale`.
struct BuildingPlan {
  static constexpr std::string_view kName = "building";
  std::string map;   ///< the yaml
  double scale = 1;  ///< on its lengths
  /// Corners of the part that is taken, in the map's frame; all of it where they are left out.
  std::optional<Vec2> low_m = {};
  std::optional<Vec2> high_m = {};
  std::uint64_t seed = 1;  ///< of what hangs on its walls, and of its floor
};

/// One small furnished room with its door shut: rectangular or with a corner cut off, from tidy to
/// cluttered. There is a place to start with room to turn, and a passage of 0.9 m from it to the
/// door; other gaps are as wide as chance has it.
struct RoomPlan {
  static constexpr std::string_view kName = "room";
  std::optional<Vec2> size_m = {};  ///< else drawn by the seed,
  Vec2 drawn_size_m{4, 6};          ///< each way from the first to the second of these
  /// Share of what fits of things that stand about; else 0 to 1 by the seed.
  std::optional<double> clutter = {};
  double blank = 0.05;         ///< share of the walls that is plain paint with nothing on it
  double start_clear_m = 0.7;  ///< to each side of the place to start
  /// One half is the other turned by half a turn, and all paintings are of one kind: made to be
  /// confused, as seen from a start in the middle.
  bool alike = false;
  std::optional<std::uint64_t> seed = {};  ///< else the mission's, and 1 where there is none
};

using GenerateOptions = std::variant<OfficePlan, HomePlan, MirroredPlan, CorridorsPlan,
                                     WarehousePlan, StreetPlan, BuildingPlan, RoomPlan>;

void bind(Fields& f, OfficePlan& o);
void bind(Fields& f, HomePlan& o);
void bind(Fields& f, MirroredPlan& o);
void bind(Fields& f, CorridorsPlan& o);
void bind(Fields& f, WarehousePlan& o);
void bind(Fields& f, StreetPlan& o);
void bind(Fields& f, BuildingPlan& o);
void bind(Fields& f, RoomPlan& o);

/// Adds the place to a world's settings: lights, boxes, objects, doors. The same plan gives the
/// same place. Throws ConfigError for one that does not fit into its size, ConfigError
/// or IoError for a map that cannot be used.
void generate(const OfficePlan& plan, WorldSettings& into);
void generate(const HomePlan& plan, WorldSettings& into);
void generate(const MirroredPlan& plan, WorldSettings& into);
void generate(const CorridorsPlan& plan, WorldSettings& into);
void generate(const WarehousePlan& plan, WorldSettings& into);
void generate(const StreetPlan& plan, WorldSettings& into);
void generate(const BuildingPlan& plan, WorldSettings& into);
void generate(const RoomPlan& plan, WorldSettings& into);

}  // namespace panoptes::sim

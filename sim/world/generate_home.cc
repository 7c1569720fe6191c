// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "sim/world/generate.h"
#include "sim/world/home_rooms.h"
#include "sim/world/load.h"
#include "sim/world/passability_grid.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr int kMostRooms = 8;
constexpr double kMostSize_m = 40;
constexpr double kHall_m = 1.6;
constexpr double kLeastRoom_m = 3.0;  // each way
constexpr double kDoorway_m = 1.06;   // 1 m between the frames
constexpr double kFrame_m = 0.03;
constexpr double kFrameDepth_m = kWallThickness_m + 0.03;
constexpr double kDoorHeight_m = 2.1;
constexpr double kLeaf_m = 1.05;
constexpr double kArch_m = 1.5;  // between living room and kitchen
constexpr double kBeforeDoor_m = 1.1;
constexpr double kWallHalf_m = kWallThickness_m / 2;

/// Rooms above and below the hall; a flat of one room has none below.
std::array<int, 2> rows_of(const HomePlan& plan) { return {(plan.rooms + 1) / 2, plan.rooms / 2}; }

bool has_place(const HomePlan& plan) {
  const int rows = plan.rooms > 1 ? 2 : 1;
  const double width_m =
      (plan.size_m.x() - (rows_of(plan)[0] - 1) * kWallThickness_m) / rows_of(plan)[0];
  const double depth_m = (plan.size_m.y() - kHall_m) / rows - kWallThickness_m;
  return width_m >= kLeastRoom_m && depth_m >= kLeastRoom_m &&
         plan.size_m.maxCoeff() <= kMostSize_m;
}

std::string size_rule(const HomePlan& plan) {
  const int rows = plan.rooms > 1 ? 2 : 1;
  return fmt::format(
      "must be at most {:g} m each way and leave every room {:g} m: for {} rooms beside a hall of "
      "{:g} m at least [{:g}, {:g}]",
      kMostSize_m, kLeastRoom_m, plan.rooms, kHall_m,
      rows_of(plan)[0] * (kLeastRoom_m + kWallThickness_m) - kWallThickness_m,
      rows * (kLeastRoom_m + kWallThickness_m) + kHall_m);
}

/// How wide a room is beside others in its row.
double weight(RoomKind kind) {
  switch (kind) {
    case RoomKind::kLiving:
      return 1.3;
    case RoomKind::kBath:
      return 0.75;
    case RoomKind::kBedroom:
      return 1.1;
    default:
      return 1;
  }
}

std::vector<RoomKind> kinds_of_row(int row, int count) {
  const std::array<std::vector<RoomKind>, 2> kinds{
      {{RoomKind::kLiving, RoomKind::kKitchen, RoomKind::kBath, RoomKind::kBedroom},
       {RoomKind::kBedroom, RoomKind::kStudy, RoomKind::kBedroom, RoomKind::kStudy}}};
  const auto& all = kinds[static_cast<std::size_t>(row)];
  return {all.begin(), all.begin() + count};
}

/// The widths of a row's rooms: by weight and chance, none below the least.
std::vector<double> widths_of(const std::vector<RoomKind>& kinds, double total_m, Rng& rng) {
  std::vector<double> parts;
  parts.reserve(kinds.size());
  for (const RoomKind kind : kinds) {
    parts.push_back(weight(kind) * rng.uniform(0.94, 1.06));
  }
  const double sum = std::accumulate(parts.begin(), parts.end(), 0.0);
  const double spare_m = total_m - kWallThickness_m * static_cast<double>(kinds.size() - 1) -
                         kLeastRoom_m * static_cast<double>(kinds.size());
  for (double& part : parts) {
    part = kLeastRoom_m + spare_m * part / sum;
  }
  return parts;
}

/// A flat under construction.
struct Home {
  WorldSettings& into;
  PassabilityGrid passability;
  std::vector<HomeRoom> rooms;  // the hall first
  std::vector<Vec2> doorways;   // their middles
};

/// A wall with a wallpaper on each side.
void put_papered_wall(WorldSettings& into, const WallSettings& wall) {
  const std::size_t first = into.boxes.size();
  put_wall(into, wall);
  for (std::size_t i = first; i < into.boxes.size(); ++i) {
    into.boxes[i].picture_m = Vec2(kPaper_m, kPaper_m);
  }
}

/// The frame of a way through a wall along x or y, its middle and heading on the wall's line.
void put_frame(WorldSettings& into, const Pose2& middle, double width_m) {
  for (const double side : {-1.0, 1.0}) {
    const Vec2 p = middle * Vec2(side * (width_m - kFrame_m) / 2, 0);
    put_box(into, "frame", Vec3(kFrame_m, kFrameDepth_m, kDoorHeight_m),
            {p.x(), p.y(), middle.theta_rad}, 0, "home/ceiling", Vec2(1.2, 1.2));
  }
  put_box(into, "lintel", Vec3(width_m - 2 * kFrame_m - 0.002, kFrameDepth_m, kFrame_m), middle,
          kDoorHeight_m - kFrame_m, "home/ceiling", Vec2(1.2, 1.2));
}

/// Keeps the walls and the floor of a room clear about a way through one of its walls.
void open_into(HomeRoom& room, std::size_t face, const Vec2& middle, double width_m) {
  WallFace& wall = room.faces[face];
  const double s_m = wall.along(middle);
  wall.take({{s_m - width_m / 2 - 0.03, 0}, {s_m + width_m / 2 + 0.03, kDoorHeight_m + 0.05}});
  const Pose2 at = wall.at(s_m);
  const Vec2 before = at * Vec2(kBeforeDoor_m / 2, 0);
  room.keep_clear.push_back(
      FloorSpace::outline({before.x(), before.y(), at.theta_rad}, {kBeforeDoor_m, width_m + 0.1}));
}

/// The leaf of a door, open and turned back against the wall of the room, on the side of the
/// doorway where there is more of it.
void put_leaf(Home& home, HomeRoom& room, std::size_t face, const Vec2& middle) {
  WallFace& wall = room.faces[face];
  const double s_m = wall.along(middle);
  const bool to_right = wall.length_m() - s_m > s_m;
  const double side = to_right ? 1 : -1;
  const double hinge_s_m = s_m + side * (kDoorway_m / 2 + 0.02);
  const double end_s_m = hinge_s_m + side * kLeaf_m;
  if (end_s_m < 0.02 || end_s_m > wall.length_m() - 0.02) {
    return;
  }
  constexpr double kOff_m = 0.06;     // the hinge from the wall
  constexpr double kAjar_rad = 0.10;  // the leaf from the wall
  const Pose2 at = wall.at(hinge_s_m);
  const Vec2 hinge = at * Vec2(kOff_m, 0);
  const double heading_rad = wrap_angle(at.theta_rad + side * (std::numbers::pi / 2 - kAjar_rad));
  ObjectSettings& leaf = put(home.into, "home/door", {hinge.x(), hinge.y(), heading_rad});
  leaf.name = fmt::format("door-{}", home.rooms.size());  // of the room that is being built
  leaf.movable = true;
  const Vec2 depth = at * Vec2(kOff_m + kLeaf_m * kAjar_rad + 0.03, side * kLeaf_m);
  const Rectangle outline{at.position().cwiseMin(depth), at.position().cwiseMax(depth)};
  home.passability.block(outline);
  room.keep_clear.push_back(outline);
  wall.take({{std::min(hinge_s_m, end_s_m), 0}, {std::max(hinge_s_m, end_s_m), kDoorHeight_m}});
}

/// The rooms of one row with their walls, from west to east; y_low to y_high is the row's inside,
/// the hall lies below (row 0) or above it.
void build_row(Home& home, int row, std::vector<RoomKind> kinds, double y_low, double y_high,
               double size_x_m, Rng rng) {
  if (rng.uniform() < 0.5) {
    std::reverse(kinds.begin(), kinds.end());
  }
  const std::vector<double> widths = widths_of(kinds, size_x_m, rng);
  const bool is_upper = row == 0;
  const std::size_t to_hall = is_upper ? 0 : 2;
  double x = 0;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    HomeRoom room;
    room.kind = kinds[i];
    room.area = {{x, y_low}, {x + widths[i], y_high}};
    room.faces = faces_of(room.area);
    room.is_outside = {!is_upper, i + 1 == kinds.size(), is_upper, i == 0};
    const double wall_y = is_upper ? y_low - kWallHalf_m : y_high + kWallHalf_m;
    // The wall to the hall, its left side towards it for the lower row.
    const double from_side_m = kDoorway_m / 2 + 0.12;
    const double door_x = x + rng.uniform(from_side_m, widths[i] - from_side_m);
    const Vec2 middle(door_x, wall_y);
    WallSettings wall;
    const double before_m = i == 0 ? 0 : kWallHalf_m;
    const double after_m = i + 1 == kinds.size() ? 0 : kWallHalf_m;
    wall.from = Vec2(x - before_m, wall_y);
    wall.to = Vec2(x + widths[i] + after_m, wall_y);
    wall.left = wall_picture(is_upper ? room.kind : RoomKind::kHall);
    wall.right = wall_picture(is_upper ? RoomKind::kHall : room.kind);
    const double s_m = door_x - wall.from.x();
    wall.openings = {{s_m - kDoorway_m / 2, s_m + kDoorway_m / 2, kDoorHeight_m}};
    put_papered_wall(home.into, wall);
    put_frame(home.into, {middle.x(), middle.y(), 0}, kDoorway_m);
    const Rectangle beside{{x - kWallThickness_m, wall_y - kWallHalf_m},
                           {door_x - kDoorway_m / 2 + kFrame_m, wall_y + kWallHalf_m}};
    home.passability.block(beside);
    home.passability.block({{door_x + kDoorway_m / 2 - kFrame_m, beside.low.y()},
                            {x + widths[i] + kWallThickness_m, beside.high.y()}});
    open_into(room, to_hall, middle, kDoorway_m);
    open_into(home.rooms.front(), is_upper ? 2 : 0, middle, kDoorway_m);  // the hall
    home.doorways.push_back(middle);
    if (rng.uniform() < 0.75) {
      put_leaf(home, room, to_hall, middle);
    }
    home.rooms.push_back(room);
    x += widths[i] + kWallThickness_m;
  }
  // Walls between neighbours; some have a wide way through, always that of living room and kitchen.
  const std::size_t first = home.rooms.size() - kinds.size();
  for (std::size_t i = 0; i + 1 < kinds.size(); ++i) {
    HomeRoom& west = home.rooms[first + i];
    HomeRoom& east = home.rooms[first + i + 1];
    const bool is_open = (west.kind == RoomKind::kLiving || east.kind == RoomKind::kLiving) &&
                         (west.kind == RoomKind::kKitchen || east.kind == RoomKind::kKitchen);
    const double wall_x = west.area.high.x() + kWallHalf_m;
    WallSettings wall;
    wall.from = Vec2(wall_x, y_low);
    wall.to = Vec2(wall_x, y_high);
    wall.left = wall_picture(west.kind);
    wall.right = wall_picture(east.kind);
    const Vec2 middle(wall_x, rng.uniform(y_low + 1.2, y_high - 1.2));
    if (is_open) {
      const double s_m = middle.y() - y_low;
      wall.openings = {{s_m - kArch_m / 2, s_m + kArch_m / 2, kDoorHeight_m}};
      put_frame(home.into, {middle.x(), middle.y(), std::numbers::pi / 2}, kArch_m);
      open_into(west, 1, middle, kArch_m);
      open_into(east, 3, middle, kArch_m);
      home.doorways.push_back(middle);
      home.passability.block({{wall_x - kWallHalf_m, y_low},
                              {wall_x + kWallHalf_m, middle.y() - kArch_m / 2 + kFrame_m}});
      home.passability.block({{wall_x - kWallHalf_m, middle.y() + kArch_m / 2 - kFrame_m},
                              {wall_x + kWallHalf_m, y_high}});
    } else {
      home.passability.block({{wall_x - kWallHalf_m, y_low}, {wall_x + kWallHalf_m, y_high}});
    }
    put_papered_wall(home.into, wall);
  }
}

/// The wall about everything: its left side is the inside, with the paper of what lies there.
void put_outer_walls(Home& home, const Vec2& size) {
  for (const HomeRoom& room : home.rooms) {
    const Rectangle wide = room.area.grown(kWallHalf_m);
    const std::array<Vec2, 4> corners{wide.low, Vec2(wide.high.x(), wide.low.y()), wide.high,
                                      Vec2(wide.low.x(), wide.high.y())};
    for (std::size_t f = 0; f < 4; ++f) {
      if (!room.is_outside[f]) {
        continue;
      }
      Vec2 from = corners[f];
      Vec2 to = corners[(f + 1) % 4];
      const Vec2 along = (to - from).normalized();
      // At the corners of the house walls along x reach around those along y.
      const auto is_corner = [&](const Vec2& p) {
        return (p.x() < 0 || p.x() > size.x()) && (p.y() < 0 || p.y() > size.y());
      };
      const double reach_m = f % 2 == 0 ? kWallHalf_m : -kWallHalf_m;
      from -= is_corner(from) ? Vec2(along * reach_m) : Vec2(0, 0);
      to += is_corner(to) ? Vec2(along * reach_m) : Vec2(0, 0);
      const std::size_t first = home.into.boxes.size();
      put_papered_wall(home.into, {.from = from,
                                   .to = to,
                                   .left = wall_picture(room.kind),
                                   .right = wall_picture(room.kind)});
      for (std::size_t i = first; i < home.into.boxes.size(); ++i) {
        home.into.boxes[i].faces["right"] = "";  // nobody sees the house from outside
      }
    }
  }
}

}  // namespace

void bind(Fields& f, HomePlan& o) {
  f("size_m", o.size_m, positive);
  f("rooms", o.rooms, between(1, kMostRooms));
  f("seed", o.seed);
  f.require(o.rooms < 1 || o.rooms > kMostRooms || has_place(o), "size_m", size_rule(o));
}

void generate(const HomePlan& plan, WorldSettings& into) {
  if (plan.rooms < 1 || plan.rooms > kMostRooms) {
    throw ConfigError(fmt::format("home.rooms: must be between 1 and {}", kMostRooms));
  }
  if (!has_place(plan)) {
    throw ConfigError("home.size_m: " + size_rule(plan));
  }
  Rng rng = Rng(plan.seed).fork("home");
  into.ambient = 0.5;
  const Vec2 size = plan.size_m;
  const std::array<int, 2> rows = rows_of(plan);
  const bool has_lower = rows[1] > 0;
  const bool is_swapped = has_lower && rng.uniform() < 0.5;  // which row lies above the hall
  const double depth_m = (size.y() - kHall_m) / (has_lower ? 2 : 1) - kWallThickness_m;
  const double hall_low = has_lower ? depth_m + kWallThickness_m : 0;

  Home home{into, PassabilityGrid({0, 0}, size), {}, {}};
  HomeRoom hall;
  hall.kind = RoomKind::kHall;
  hall.area = {{0, hall_low}, {size.x(), hall_low + kHall_m}};
  hall.faces = faces_of(hall.area);
  hall.is_outside = {!has_lower, true, false, true};
  home.rooms.push_back(hall);
  const double upper_low = hall_low + kHall_m + kWallThickness_m;
  build_row(home, 0, kinds_of_row(is_swapped ? 1 : 0, rows[0]), upper_low, size.y(), size.x(),
            rng.fork("upper"));
  if (has_lower) {
    build_row(home, 1, kinds_of_row(is_swapped ? 0 : 1, rows[1]), 0, depth_m, size.x(),
              rng.fork("lower"));
  }
  put_outer_walls(home, size);
  home.passability.keep_open(home.doorways);
  for (std::size_t i = 0; i < home.rooms.size(); ++i) {
    const HomeRoom& room = home.rooms[i];
    const Rectangle wide = room.area.grown(kWallHalf_m);
    put_floor(into, wide.low, wide.high, floor_picture(room.kind),
              room.kind == RoomKind::kKitchen || room.kind == RoomKind::kBath ? 1.2 : 1.6);
    put_ceiling(into, wide.low, wide.high, "home/ceiling", 1.2);
    furnish(into, room, home.passability, rng.fork(fmt::format("room {}", i)));
  }
}

}  // namespace panoptes::sim

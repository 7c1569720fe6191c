// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/rng.h"
#include "sim/world/generate.h"
#include "sim/world/home_rooms.h"
#include "sim/world/load.h"
#include "sim/world/passability_grid.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr double kLeast_m = 3.5;
constexpr double kMost_m = 12;
constexpr double kHalf_m = kWallThickness_m / 2;
constexpr double kPanel_m = 0.9;         // of wall that is plain or not, about
constexpr double kBesideStart_m = 0.08;  // so that a start may be drawn some way off
constexpr double kLeastStart_m = 0.7;    // clear about every start
constexpr double kBeforeDoor_m = 1.0;
constexpr double kDoor_m = 1.02;
constexpr double kDoorHeight_m = 2.14;

const std::array<FloorPicture, 5> kFloors{{{"home/parquet", 1.6},
                                           {"home/floor_tiles", 1.2},
                                           {"office/carpet_sand", 2.0},
                                           {"office/carpet_blue", 2.0},
                                           {"corridors/linoleum", 2.0}}};
const std::array<const char*, 6> kPapers{"home/wallpaper_leaves", "home/wallpaper_stripes",
                                         "home/wallpaper_retro",  "office/wall_b",
                                         "office/wall",           "corridors/wall_a"};

bool is_range(const Vec2& drawn_size_m) {
  return drawn_size_m.x() >= kLeast_m && drawn_size_m.x() <= drawn_size_m.y() &&
         drawn_size_m.y() <= kMost_m;
}

bool is_sensible(const Vec2& size_m) {
  return size_m.minCoeff() >= kLeast_m && size_m.maxCoeff() <= kMost_m;
}

std::string size_rule() {
  return fmt::format("must be between {:g} m and {:g} m each way", kLeast_m, kMost_m);
}

Vec2 picture_size(const std::string& paper) { return Vec2::Constant(wall_repeat_m(paper)); }

/// A room's four walls, in panels of paper and of plain paint. The walls along x reach around those
/// along y.
void put_walls(WorldSettings& into, HomeRoom& room, const std::string& paper, double blank,
               Rng rng) {
  for (std::size_t f = 0; f < 4; ++f) {
    const WallFace& face = room.faces[f];
    const int panels = std::max(1, static_cast<int>(std::lround(face.length_m() / kPanel_m)));
    const double panel_m = face.length_m() / panels;
    std::vector<bool> is_bare;
    for (int k = 0; k < panels; ++k) {
      is_bare.push_back(rng.uniform() < blank);
    }
    for (int k = 0; k < panels;) {
      const int first = k;
      while (k < panels &&
             is_bare[static_cast<std::size_t>(k)] == is_bare[static_cast<std::size_t>(first)]) {
        ++k;
      }
      const bool bare = is_bare[static_cast<std::size_t>(first)];
      if (bare) {
        room.bare.push_back({f, {{first * panel_m, 0}, {k * panel_m, kRoomHeight_m}}});
      }
      const double over_m = f % 2 == 0 ? kWallThickness_m : 0;
      const double from_m = first * panel_m - (first == 0 ? over_m : 0);
      const double to_m = k * panel_m + (k == panels ? over_m : 0);
      const Pose2 at = face.at((from_m + to_m) / 2);
      const Vec2 middle = at * Vec2(-kHalf_m, 0);
      const std::string picture = bare ? "office/wall_plain" : paper;
      BoxSettings& box =
          put_box(into, "wall", Vec3(kWallThickness_m, to_m - from_m, kRoomHeight_m),
                  {middle.x(), middle.y(), at.theta_rad}, 0, picture, picture_size(picture));
      box.faces = {{"back", ""}, {"left", ""}, {"right", ""}, {"top", ""}, {"bottom", ""}};
    }
  }
}

/// A corner of the room that is another one's, walled off.
void cut_corner(WorldSettings& into, HomeRoom& room, PassabilityGrid& passability,
                const std::string& paper, Rng rng) {
  const Vec2 size = room.area.high - room.area.low;
  const Vec2 most = (size - Vec2(2.6, 2.6)).cwiseMin(Vec2(2.0, 2.0));
  if (most.minCoeff() < 0.6) {
    return;
  }
  const Vec2 cut(rng.uniform(0.6, most.x()), rng.uniform(0.6, most.y()));
  const bool is_east = rng.index(2) == 0;
  const bool is_north = rng.index(2) == 0;
  Rectangle corner;
  corner.low = Vec2(is_east ? room.area.high.x() - cut.x() : room.area.low.x(),
                    is_north ? room.area.high.y() - cut.y() : room.area.low.y());
  corner.high = corner.low + cut;
  const Vec2 middle = (corner.low + corner.high) / 2;
  BoxSettings& box = put_box(into, "corner", Vec3(cut.x(), cut.y(), kRoomHeight_m),
                             {middle.x(), middle.y(), 0}, 0, paper, picture_size(paper));
  box.faces = {{is_east ? "front" : "back", ""},
               {is_north ? "left" : "right", ""},
               {"top", ""},
               {"bottom", ""}};
  room.solid.push_back(corner);
  passability.block(corner);
  for (WallFace& face : room.faces) {  // the walls behind it
    const double s_m = face.along(middle);
    const bool is_along_x = std::abs(std::cos(face.at(0).theta_rad)) < 0.5;
    const double off_m = std::abs((face.at(s_m).inverse() * middle).x());
    const Vec2 half = cut / 2;
    if (off_m < (is_along_x ? half.y() : half.x()) + 0.01) {
      const double half_m = is_along_x ? half.x() : half.y();
      face.take({{s_m - half_m, 0}, {s_m + half_m, kRoomHeight_m}});
    }
  }
  // Its two sides, as they are seen from the room.
  const double x = is_east ? corner.low.x() : corner.high.x();
  const double y = is_north ? corner.low.y() : corner.high.y();
  const Vec2 south(x, corner.low.y());
  const Vec2 north(x, corner.high.y());
  const Vec2 west(corner.low.x(), y);
  const Vec2 east(corner.high.x(), y);
  room.faces.push_back(is_east ? WallFace(north, south) : WallFace(south, north));
  room.faces.push_back(is_north ? WallFace(west, east) : WallFace(east, west));
  room.is_outside.resize(room.faces.size(), false);
}

/// What stands and hangs in the western half, in both; the walls are papered all around.
void make_alike(WorldSettings& into, const Vec2& size_m) {
  const auto is_east = [&size_m](double x_m) { return x_m >= size_m.x() / 2; };
  const auto is_shell = [](const BoxSettings& box) {
    return box.name.starts_with("wall-") || box.name.starts_with("floor") ||
           box.name.starts_with("ceiling");
  };
  WorldSettings half;
  std::string painting;
  for (ObjectSettings& object : into.objects) {
    if (object.mesh.find("painting") != std::string::npos) {
      painting = painting.empty() ? object.mesh : painting;
      object.mesh = painting;
    }
    if (!is_east(object.at.x_m)) {
      half.objects.push_back(std::move(object));
    }
  }
  std::vector<BoxSettings> shell;
  for (BoxSettings& box : into.boxes) {
    if (is_shell(box)) {
      shell.push_back(std::move(box));
    } else if (!is_east(box.at.x_m)) {
      half.boxes.push_back(std::move(box));
    }
  }
  for (const AreaLight& light : into.lights) {
    if (!is_east(light.at_m.x())) {
      half.lights.push_back(light);
    }
  }
  into.objects.clear();
  into.boxes = std::move(shell);
  into.lights.clear();
  put_both_halves(into, half, size_m);
}

}  // namespace

void bind(Fields& f, RoomPlan& o) {
  f("size_m", o.size_m, positive);
  f("drawn_size_m", o.drawn_size_m, positive);
  f("clutter", o.clutter, between(0, 1));
  f("blank", o.blank, between(0, 1));
  f("start_clear_m", o.start_clear_m, between(kLeastStart_m, kLeast_m / 2 - kBesideStart_m));
  f("alike", o.alike);
  f("seed", o.seed);
  f.require(!o.size_m || is_sensible(*o.size_m), "size_m", size_rule());
  f.require(is_range(o.drawn_size_m), "drawn_size_m",
            fmt::format("must be the least and the most that is drawn, from {:g} m to {:g} m",
                        kLeast_m, kMost_m));
}

void generate(const RoomPlan& plan, WorldSettings& into) {
  if (plan.size_m && !is_sensible(*plan.size_m)) {
    throw ConfigError("room.size_m: " + size_rule());
  }
  PANOPTES_CHECK(is_range(plan.drawn_size_m), "a range of sizes that a room may have");
  Rng rng = Rng(plan.seed.value_or(1)).fork("room");
  into.ambient = 0.5;
  Rng shape = rng.fork("shape");
  const double least_m = plan.drawn_size_m.x();
  const double most_m = plan.drawn_size_m.y();
  const Vec2 drawn(shape.uniform(least_m, most_m), shape.uniform(least_m, most_m));
  const double drawn_clutter = shape.uniform();
  const Vec2 size = plan.size_m.value_or(drawn);
  constexpr std::array<RoomKind, 4> kKinds{RoomKind::kLiving, RoomKind::kKitchen,
                                           RoomKind::kBedroom, RoomKind::kStudy};
  HomeRoom room;
  room.kind = one_of(kKinds, shape);
  room.area = {{0, 0}, size};
  room.faces = faces_of(room.area);
  room.is_outside.assign(4, false);
  room.clutter = plan.clutter.value_or(drawn_clutter);
  Rng surfaces = rng.fork("surfaces");
  const FloorPicture& floor = one_of(kFloors, surfaces);
  const std::string paper =
      room.kind == RoomKind::kKitchen ? wall_picture(room.kind) : one_of(kPapers, surfaces);
  PassabilityGrid passability({0, 0}, size);
  put_walls(into, room, paper, plan.alike ? 0 : plan.blank, rng.fork("panels"));
  if (shape.uniform() < 0.4 && !plan.alike) {
    cut_corner(into, room, passability, paper, rng.fork("corner"));
  }
  put_floor(into, {0, 0}, size, floor.picture, floor.tile_m);
  put_ceiling(into, {0, 0}, size, "home/ceiling", 1.2);

  // The door, and one or two other walls to the outside.
  Rng openings = rng.fork("openings");
  std::vector<Vec2> places;
  const auto door_face = static_cast<std::size_t>(openings.index(4));
  for (int i = 0; i < 50 && places.empty(); ++i) {
    const std::size_t f = (door_face + static_cast<std::size_t>(i / 10)) % 4;
    WallFace& face = room.faces[f];
    const double s_m = openings.uniform(kDoor_m / 2 + 0.1, face.length_m() - kDoor_m / 2 - 0.1);
    const Pose2 at = face.at(s_m);
    const Rectangle before =
        FloorSpace::outline(at * Pose2{kBeforeDoor_m / 2, 0, 0}, {kBeforeDoor_m, kDoor_m + 0.1});
    if (std::any_of(room.solid.begin(), room.solid.end(),
                    [&before](const Rectangle& r) { return r.overlaps(before); }) ||
        !put_door(into, face, s_m, "office/door")) {
      continue;
    }
    face.take({{s_m - kDoor_m / 2 - 0.05, 0}, {s_m + kDoor_m / 2 + 0.05, kDoorHeight_m}});
    room.keep_clear.push_back(before);
    places.push_back(at * Vec2(0.6, 0));
    room.is_outside[(f + 2) % 4] = true;
    room.is_outside[(f + 1 + 2 * static_cast<std::size_t>(openings.index(2))) % 4] =
        openings.uniform() < 0.4;
  }
  // Where a robot can start.
  Rng starts = rng.fork("start");
  const double half_start_m = plan.start_clear_m + kBesideStart_m;
  const Rectangle inside = room.area.grown(-half_start_m);
  for (int i = 0; i < 1000; ++i) {
    const Vec2 drawn_at(starts.uniform(inside.low.x(), inside.high.x()),
                        starts.uniform(inside.low.y(), inside.high.y()));
    const Vec2 p = plan.alike ? Vec2(size / 2) : drawn_at;
    const Rectangle around = Rectangle{p, p}.grown(half_start_m);
    if (std::none_of(room.solid.begin(), room.solid.end(),
                     [&around](const Rectangle& r) { return r.overlaps(around); })) {
      room.keep_clear.push_back(around);
      places.push_back(p);
      break;
    }
  }
  passability.keep_open(places);
  furnish(into, std::move(room), passability, rng.fork("furniture"));
  if (plan.alike) {
    make_alike(into, size);
  }
}

}  // namespace panoptes::sim

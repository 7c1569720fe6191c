// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "sim/world/generate.h"
#include "sim/world/load.h"
#include "sim/world/passability_grid.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr int kMostRacks = 20;
constexpr double kMostSize_m = 80;
constexpr double kHeight_m = 5.0;
constexpr double kBrick_m = 2.25;  // so high the walls are of brick
constexpr double kBay_m = 2.70;    // of a rack
constexpr double kRackDepth_m = 1.06;
constexpr double kBackToBack_m = 0.10;
constexpr double kLeastAisle_m = 1.9;  // between racks, pallets may stand along walls
constexpr double kCrossAisle_m = 2.2;  // at the ends of the racks, at least
constexpr double kLane_m = 0.10;
constexpr double kLaneHeight_m = 0.004;

/// Racks stand back to back, two and two.
int groups_of(int racks) { return (racks + 1) / 2; }

double depth_of(int racks, int group) {
  return 2 * group + 2 <= racks ? 2 * kRackDepth_m + kBackToBack_m : kRackDepth_m;
}

double aisle_of(const WarehousePlan& plan) {
  double depths_m = 0;
  for (int group = 0; group < groups_of(plan.racks); ++group) {
    depths_m += depth_of(plan.racks, group);
  }
  return (plan.size_m.y() - depths_m) / (groups_of(plan.racks) + 1);
}

int bays_of(const WarehousePlan& plan) {
  return static_cast<int>(std::floor((plan.size_m.x() - 2 * kCrossAisle_m) / kBay_m));
}

bool has_place(const WarehousePlan& plan) {
  return aisle_of(plan) >= kLeastAisle_m && bays_of(plan) >= 1 &&
         plan.size_m.maxCoeff() <= kMostSize_m;
}

std::string size_rule(const WarehousePlan& plan) {
  return fmt::format(
      "must be at most {:g} m each way and hold {} racks with aisles of {:g} m: at least [{:g}, "
      "{:g}]",
      kMostSize_m, plan.racks, kLeastAisle_m, kBay_m + 2 * kCrossAisle_m,
      plan.size_m.y() + (kLeastAisle_m - aisle_of(plan)) * (groups_of(plan.racks) + 1));
}

/// Brick below, corrugated sheets above; one face each.
void put_hall_wall(WorldSettings& into, const WallFace& face) {
  const Pose2 at = face.at(face.length_m() / 2);
  const Vec2 middle = at * Vec2(-kWallThickness_m / 2, 0);
  const auto piece = [&](double z_m, double height_m, const char* picture, double picture_m) {
    BoxSettings& box = put_box(
        into, "wall", Vec3(kWallThickness_m, face.length_m() + 2 * kWallThickness_m, height_m),
        {middle.x(), middle.y(), at.theta_rad}, z_m, picture, Vec2(picture_m, picture_m));
    box.faces = {{"back", ""}, {"left", ""}, {"right", ""}, {"top", ""}, {"bottom", ""}};
  };
  piece(0, kBrick_m, "warehouse/brick", 1.8);
  piece(kBrick_m, kHeight_m - kBrick_m, "warehouse/corrugated", 2.5);
}

/// A line on the floor along x or y.
void paint_lane(WorldSettings& into, const Vec2& from, const Vec2& to) {
  const Vec2 middle = (from + to) / 2;
  const Vec2 size = (to - from).cwiseAbs() + Vec2(kLane_m, kLane_m);
  BoxSettings& box = put_box(into, "lane", Vec3(size.x(), size.y(), kLaneHeight_m),
                             {middle.x(), middle.y(), 0}, 0, "warehouse/lane", Vec2(1, 1));
  box.faces = {{"front", ""}, {"back", ""}, {"left", ""}, {"right", ""}};
}

/// The hall under construction.
struct Hall {
  WorldSettings& into;
  PassabilityGrid passability;
  FloorSpace floor;
};

bool stand(Hall& hall, const std::string& mesh, const Pose2& at, const Vec2& size_m) {
  const Rectangle outline = FloorSpace::outline(at, size_m);
  if (!hall.floor.is_clear(outline, 0.02) || !hall.passability.block_if_passable(outline)) {
    return false;
  }
  hall.floor.take(outline);
  put(hall.into, mesh, at);
  return true;
}

/// Two rows of racks back to back, or the last one alone, from x_low on; a bay left out of some is
/// a way through.
void put_racks(Hall& hall, double x_low, double y_low, int rows, int bays, Rng rng) {
  const int gap = bays >= 4 ? 1 + rng.index(bays - 2) : -1;
  for (int row = 0; row < rows; ++row) {
    const double heading_rad = row == 0 ? -std::numbers::pi / 2 : std::numbers::pi / 2;
    const double y = y_low + kRackDepth_m / 2 + row * (kRackDepth_m + kBackToBack_m);
    for (int bay = 0; bay < bays; ++bay) {
      if (bay == gap) {
        continue;
      }
      const Pose2 at{x_low + (bay + 0.5) * kBay_m, y, heading_rad};
      put(hall.into, fmt::format("warehouse/rack_{}", 1 + rng.index(5)), at);
      const Rectangle outline = FloorSpace::outline(at, {kRackDepth_m, kBay_m});
      hall.floor.take(outline);
      hall.passability.block(outline);
    }
  }
}

/// Pallets, barrels, pillars along the walls, gates and signs on them.
void furnish_walls(Hall& hall, std::vector<WallFace>& faces, Rng rng) {
  for (WallFace& face : faces) {
    for (double s_m = rng.uniform(2.5, 4.5); s_m < face.length_m() - 2;
         s_m += rng.uniform(5.5, 8.5)) {
      const Rectangle gate{{s_m - 1.55, 0}, {s_m + 1.55, 3.05}};
      if (rng.uniform() < 0.55 && face.is_clear(gate)) {
        face.take(gate);
        put(hall.into, "warehouse/gate", face.at(s_m), 1.5);
      }
    }
    for (double s_m = rng.uniform(0.6, 2.0); s_m < face.length_m() - 0.5;
         s_m += rng.uniform(3.8, 5.2)) {
      const Rectangle pillar{{s_m - 0.2, 0}, {s_m + 0.2, kHeight_m}};
      const Vec2 p = face.at(s_m) * Vec2(0.2, 0);
      if (face.is_clear(pillar) &&
          stand(hall, "warehouse/pillar", {p.x(), p.y(), face.at(s_m).theta_rad}, {0.38, 0.38})) {
        face.take(pillar);
      }
    }
  }
  for (WallFace& face : faces) {
    for (double s_m = rng.uniform(0.3, 1.5); s_m < face.length_m(); s_m += rng.uniform(1.3, 3.4)) {
      std::string mesh;
      Vec2 size(0.82, 1.24);
      double height_m = 1.5;
      const double kind = rng.uniform();
      if (kind < 0.45) {
        mesh = fmt::format("warehouse/loaded_{}", 1 + rng.index(5));
      } else if (kind < 0.6) {
        mesh = "warehouse/stack";
        height_m = 1.35;
      } else if (kind < 0.78) {
        mesh = "warehouse/barrels";
        height_m = 1.05;
      } else {
        mesh = "warehouse/barrel";
        size = Vec2(0.60, 0.60);
        height_m = 0.9;
      }
      const Pose2 on_face = face.at(s_m);
      const Vec2 p = on_face * Vec2(0.05 + size.x() / 2, 0);
      const Rectangle hidden{{s_m - size.y() / 2, 0}, {s_m + size.y() / 2, height_m}};
      // Nothing stands before a gate.
      if (face.is_clear(hidden) && stand(hall, mesh, {p.x(), p.y(), on_face.theta_rad}, size)) {
        face.take(hidden);
      }
    }
    for (double s_m = rng.uniform(0.5, 2); s_m < face.length_m(); s_m += rng.uniform(1.2, 3)) {
      hang(hall.into, face, {std::string("warehouse/plate_") + "abcd" [rng.index(4)], { 0.6, 0.6 }},
           s_m, rng.uniform(1.6, 2.2));
    }
    dress(hall.into, face, 0.5, rng);
  }
}

}  // namespace

void bind(Fields& f, WarehousePlan& o) {
  f("size_m", o.size_m, positive);
  f("racks", o.racks, between(1, kMostRacks));
  f("seed", o.seed);
  f.require(o.racks < 1 || o.racks > kMostRacks || has_place(o), "size_m", size_rule(o));
}

void generate(const WarehousePlan& plan, WorldSettings& into) {
  if (plan.racks < 1 || plan.racks > kMostRacks) {
    throw ConfigError(fmt::format("warehouse.racks: must be between 1 and {}", kMostRacks));
  }
  if (!has_place(plan)) {
    throw ConfigError("warehouse.size_m: " + size_rule(plan));
  }
  Rng rng = Rng(plan.seed).fork("warehouse");
  into.ambient = 0.5;
  const Vec2 size = plan.size_m;
  put_floor(into, {0, 0}, size, "warehouse/concrete", 2.5);
  put_ceiling(into, {0, 0}, size, "warehouse/roof", 2.4, kHeight_m);
  std::vector<WallFace> faces{
      WallFace({size.x(), 0}, {0, 0}, kHeight_m), WallFace(size, {size.x(), 0}, kHeight_m),
      WallFace({0, size.y()}, size, kHeight_m), WallFace({0, 0}, {0, size.y()}, kHeight_m)};
  for (const WallFace& face : faces) {
    put_hall_wall(into, face);
  }

  Hall hall{into, PassabilityGrid({0, 0}, size), FloorSpace({0, 0}, size)};
  const int bays = bays_of(plan);
  const double free_m = size.x() - bays * kBay_m;
  const double aisle_m = aisle_of(plan);
  std::vector<Vec2> open;
  double y = aisle_m;
  for (int group = 0; group < groups_of(plan.racks); ++group) {
    const int rows = 2 * group + 2 <= plan.racks ? 2 : 1;
    const double x = rng.uniform(kCrossAisle_m, free_m - kCrossAisle_m);
    put_racks(hall, x, y, rows, bays, rng.fork(fmt::format("racks {}", group)));
    const double depth_m = depth_of(plan.racks, group);
    for (const double lane_y : {y - 0.25, y + depth_m + 0.25}) {
      paint_lane(into, {x - 0.25, lane_y}, {x + bays * kBay_m + 0.25, lane_y});
    }
    for (const double lane_x : {x - 0.25, x + bays * kBay_m + 0.25}) {
      paint_lane(into, {lane_x, y - 0.25 + kLane_m}, {lane_x, y + depth_m + 0.25 - kLane_m});
    }
    for (const double end_x : {x - 1.0, x + bays * kBay_m + 1.0}) {
      open.emplace_back(end_x, y + depth_m / 2);
    }
    open.emplace_back(x + bays * kBay_m / 2, y - aisle_m / 2 + 0.1);
    y += depth_m + aisle_m;
  }
  open.emplace_back(size.x() / 2, y - aisle_m / 2);
  hall.passability.keep_open(open);
  Rng parking = rng.fork("forklift");
  for (int k = 0; k < 12; ++k) {
    const Pose2 at{parking.uniform(2, size.x() - 2), parking.uniform(1, size.y() - 1),
                   parking.index(2) == 0 ? 0.0 : std::numbers::pi / 2};
    if (stand(hall, "warehouse/forklift", at, {2.90, 1.24})) {
      break;
    }
  }
  furnish_walls(hall, faces, rng.fork("walls"));

  const auto lamps = [](double length_m, double pitch_m) {
    return std::max(1, static_cast<int>(std::lround(length_m / pitch_m)));
  };
  for (int j = 0; j < lamps(size.y(), 3.6); ++j) {
    for (int i = 0; i < lamps(size.x(), 4.2); ++i) {
      const Vec2 p((i + 0.5) * size.x() / lamps(size.x(), 4.2),
                   (j + 0.5) * size.y() / lamps(size.y(), 3.6));
      put(into, "warehouse/lamp", {p.x(), p.y(), 0}, kHeight_m);
      AreaLight light;
      light.at_m = Vec3(p.x(), p.y(), kHeight_m - 0.08);
      light.size_m = Vec2(1.4, 0.5);
      light.power = 3;
      light.group = "lamps";
      into.lights.push_back(light);
    }
  }
}

}  // namespace panoptes::sim

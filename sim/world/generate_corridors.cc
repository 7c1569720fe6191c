// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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

constexpr int kMostLoops = 12;
constexpr double kMostSize_m = 80;
constexpr double kLeastWidth_m = 1.2;
constexpr double kMostWidth_m = 5;
constexpr double kLeastBlock_m = 2.4;  // each way, of what a corridor runs around
constexpr double kSlab_m = 0.60;       // depth of alcoves
constexpr double kAlcove_m = 1.30;
constexpr double kBack_m = 0.05;
constexpr double kBeforeThings_m = 0.95;  // what is left of a corridor beside them
constexpr double kFloorTile_m = 2.0;

/// Blocks beside and above each other.
std::array<int, 2> blocks_of(const CorridorsPlan& plan) {
  const int rows = plan.loops >= 4 && plan.loops % 2 == 0 ? 2 : 1;
  return {plan.loops / rows, rows};
}

Vec2 block_size(const CorridorsPlan& plan) {
  const std::array<int, 2> blocks = blocks_of(plan);
  return {(plan.size_m.x() - (blocks[0] + 1) * plan.width_m) / blocks[0],
          (plan.size_m.y() - (blocks[1] + 1) * plan.width_m) / blocks[1]};
}

bool is_sensible(const CorridorsPlan& plan) {
  return plan.loops >= 1 && plan.loops <= kMostLoops && plan.width_m >= kLeastWidth_m &&
         plan.width_m <= kMostWidth_m;
}

bool has_place(const CorridorsPlan& plan) {
  return block_size(plan).minCoeff() >= kLeastBlock_m && plan.size_m.maxCoeff() <= kMostSize_m;
}

std::string size_rule(const CorridorsPlan& plan) {
  const std::array<int, 2> blocks = blocks_of(plan);
  return fmt::format(
      "must be at most {:g} m each way and hold {} x {} blocks of {:g} m with corridors of {:g} m "
      "around them: at least "
      "[{:g}, {:g}]",
      kMostSize_m, blocks[0], blocks[1], kLeastBlock_m, plan.width_m,
      blocks[0] * (kLeastBlock_m + plan.width_m) + plan.width_m,
      blocks[1] * (kLeastBlock_m + plan.width_m) + plan.width_m);
}

/// Corridors under construction.
struct Corridors {
  WorldSettings& into;
  PassabilityGrid passability;
  double width_m = 1.8;
};

/// A wall's face and its picture, for what hangs on it.
struct Side {
  WallFace face;
  std::vector<Rectangle> niches;  // along the face, from the floor up
};

/// A side of a block, its face in the corridor, its slab behind: pieces of wall between alcoves.
/// `inset_m` of the slab at each end belongs to the neighbours.
Side put_side(Corridors& corridors, const Vec2& left, const Vec2& right, double inset_m,
              const std::string& picture, Rng& rng) {
  Side side{WallFace(left, right), {}};
  const double length_m = side.face.length_m();
  std::vector<double> alcoves;  // where they begin
  const double margin_m = kSlab_m + 0.5;
  for (double s_m = margin_m + rng.uniform(0, 2.5); s_m + kAlcove_m + margin_m <= length_m;
       s_m += kAlcove_m + rng.uniform(2.2, 5.0)) {
    alcoves.push_back(s_m);
  }
  const auto wall = [&](double from_m, double to_m) {
    const Pose2 at = side.face.at((from_m + to_m) / 2);
    const Vec2 middle = at * Vec2(-kSlab_m / 2, 0);
    BoxSettings& box = put_box(corridors.into, "wall", Vec3(kSlab_m, to_m - from_m, kRoomHeight_m),
                               {middle.x(), middle.y(), at.theta_rad}, 0, picture,
                               Vec2(kRoomHeight_m, kRoomHeight_m));
    box.faces = {{"back", ""}, {"top", ""}, {"bottom", ""}};
    const Vec2 a = at * Vec2(0, (to_m - from_m) / 2);
    const Vec2 b = at * Vec2(-kSlab_m, -(to_m - from_m) / 2);
    corridors.passability.block({a.cwiseMin(b), a.cwiseMax(b)});
  };
  double reached_m = inset_m;
  for (const double s_m : alcoves) {
    wall(reached_m, s_m);
    const Pose2 at = side.face.at(s_m + kAlcove_m / 2);
    const Vec2 back = at * Vec2(-kSlab_m + kBack_m / 2, 0);
    BoxSettings& box =
        put_box(corridors.into, "alcove", Vec3(kBack_m, kAlcove_m, kRoomHeight_m),
                {back.x(), back.y(), at.theta_rad}, 0, picture, Vec2(kRoomHeight_m, kRoomHeight_m));
    box.faces = {{"back", ""}, {"left", ""}, {"right", ""}, {"top", ""}, {"bottom", ""}};
    reached_m = s_m + kAlcove_m;
    side.face.take({{s_m, 0}, {reached_m, kRoomHeight_m}});
    side.niches.push_back({{s_m, 0}, {reached_m, kRoomHeight_m}});
  }
  wall(reached_m, length_m - inset_m);
  return side;
}

/// Something that stands with its back `behind_m` behind the face (in an alcove) or on it.
bool stand(Corridors& corridors, Side& side, const std::string& mesh, const Vec2& size_m,
           double s_m, double behind_m, double height_m) {
  const Pose2 at = side.face.at(s_m);
  const Vec2 middle = at * Vec2(kSkirting_m - behind_m + size_m.x() / 2, 0);
  const Rectangle outline = FloorSpace::outline({middle.x(), middle.y(), at.theta_rad}, size_m);
  const Rectangle on_face{{s_m - size_m.y() / 2, 0}, {s_m + size_m.y() / 2, height_m}};
  if (behind_m == 0 && (!side.face.is_clear(on_face) ||
                        corridors.width_m - size_m.x() - kSkirting_m < kBeforeThings_m)) {
    return false;
  }
  if (!corridors.passability.block_if_passable(outline)) {
    return false;
  }
  if (behind_m == 0) {
    side.face.take(on_face);
  }
  put(corridors.into, mesh, {middle.x(), middle.y(), at.theta_rad});
  return true;
}

/// What stands in an alcove, in one of its corners so that beside it there is room for a robot or
/// clearly none.
void fill_alcove(Corridors& corridors, Side& side, const Rectangle& niche, Rng& rng) {
  constexpr double kIn_m = kSlab_m - kBack_m;
  struct Filling {
    const char* mesh;
    Vec2 size_m;
  };
  const std::array<Filling, 5> fillings{{{"corridors/vending", {0.70, 0.95}},
                                         {"office/plant", {0.42, 0.42}},
                                         {"office/printer", {0.58, 0.62}},
                                         {"corridors/sand", {0.40, 0.40}},
                                         {"office/cupboard_tall", {0.46, 0.92}}}};
  const Filling& filling = fillings[static_cast<std::size_t>(rng.index(5))];
  const double from_jamb_m = kSkirting_m + filling.size_m.y() / 2;
  const double s_m = rng.index(2) == 0 ? niche.low.x() + from_jamb_m : niche.high.x() - from_jamb_m;
  stand(corridors, side, filling.mesh, filling.size_m, s_m, kIn_m, 0);
}

/// What stands and hangs along a side: furniture that leaves the corridor wide enough, doors,
/// boards, hoses, and what hangs in offices.
void dress_side(Corridors& corridors, Side& side, Rng rng) {
  for (const Rectangle& niche : side.niches) {
    fill_alcove(corridors, side, niche, rng);
  }
  WallFace& face = side.face;
  const std::array<const char*, 4> doors{"corridors/door_a", "corridors/door_b", "corridors/door_c",
                                         "corridors/door_d"};
  const std::array<const char*, 3> boards{"corridors/board_a", "corridors/board_b",
                                          "corridors/board_c"};
  for (double s_m = rng.uniform(0.9, 2.2); s_m < face.length_m(); s_m += rng.uniform(2.4, 5.0)) {
    const Rectangle leaf{{s_m - 0.53, 0}, {s_m + 0.53, 2.14}};
    if (face.is_clear(leaf)) {
      face.take(leaf);
      put(corridors.into, doors[static_cast<std::size_t>(rng.index(4))], face.at(s_m), 1.07);
    }
  }
  for (double s_m = rng.uniform(0.6, 3); s_m < face.length_m(); s_m += rng.uniform(2.0, 5.0)) {
    switch (rng.index(4)) {
      case 0:
        stand(corridors, side, "corridors/lockers", {0.44, 1.60}, s_m, 0, 1.92);
        break;
      case 1:
        stand(corridors, side, "corridors/bench", {0.44, 1.56}, s_m, 0, 0.5);
        break;
      case 2:
        stand(corridors, side, "corridors/extinguisher", {0.28, 0.28}, s_m, 0, 0.7);
        break;
      default:
        stand(corridors, side, "office/plant", {0.54, 0.54}, s_m, 0, 1.8);
        break;
    }
  }
  for (double s_m = rng.uniform(0.5, 2); s_m < face.length_m(); s_m += rng.uniform(0.8, 3.2)) {
    if (rng.uniform() < 0.8) {
      hang(corridors.into, face, {boards[static_cast<std::size_t>(rng.index(3))], {1.60, 1.10}},
           s_m, 1.55);
    } else {
      hang(corridors.into, face, {"corridors/hose", {0.62, 0.80}}, s_m, 1.30);
    }
  }
  dress(corridors.into, face, 0.9, rng);
}

/// Where blocks begin and end along one axis, corridors of the same width between them.
std::vector<std::array<double, 2>> spans(int count, double size_m, double width_m, Rng& rng) {
  const double block_m = (size_m - (count + 1) * width_m) / count;
  const double shift_m = std::min(0.15 * block_m, (block_m - kLeastBlock_m) / 2);
  std::vector<std::array<double, 2>> all;
  double begin = width_m;
  for (int k = 0; k < count; ++k) {
    const double end = k + 1 == count
                           ? size_m - width_m
                           : (k + 1) * (block_m + width_m) + rng.uniform(-shift_m, shift_m);
    all.push_back({begin, end});
    begin = end + width_m;
  }
  return all;
}

}  // namespace

void bind(Fields& f, CorridorsPlan& o) {
  f("size_m", o.size_m, positive);
  f("loops", o.loops, between(1, kMostLoops));
  f("width_m", o.width_m, between(kLeastWidth_m, kMostWidth_m));
  f("seed", o.seed);
  f.require(!is_sensible(o) || has_place(o), "size_m", size_rule(o));
}

void generate(const CorridorsPlan& plan, WorldSettings& into) {
  if (!is_sensible(plan)) {
    throw ConfigError(
        fmt::format("corridors: loops must be between 1 and {}, width_m between {:g} and {:g}",
                    kMostLoops, kLeastWidth_m, kMostWidth_m));
  }
  if (!has_place(plan)) {
    throw ConfigError("corridors.size_m: " + size_rule(plan));
  }
  Rng rng = Rng(plan.seed).fork("corridors");
  into.ambient = 0.5;
  const Vec2 size = plan.size_m;
  put_floor(into, {0, 0}, size, "corridors/linoleum", kFloorTile_m);
  put_ceiling(into, {0, 0}, size);

  Corridors corridors{into, PassabilityGrid({0, 0}, size), plan.width_m};
  const std::array<int, 2> blocks = blocks_of(plan);
  Rng places = rng.fork("places");
  const auto columns = spans(blocks[0], size.x(), plan.width_m, places);
  const auto rows = spans(blocks[1], size.y(), plan.width_m, places);
  std::vector<Side> sides;
  std::vector<Vec2> corners;
  for (const auto& row : rows) {
    for (const auto& column : columns) {
      const Vec2 low(column[0], row[0]);
      const Vec2 high(column[1], row[1]);
      const std::string picture = rng.uniform() < 0.5 ? "corridors/wall_a" : "corridors/wall_b";
      // Seen from the corridor; the sides along x reach to the corners.
      sides.push_back(put_side(corridors, low, {high.x(), low.y()}, 0, picture, rng));
      sides.push_back(put_side(corridors, {high.x(), low.y()}, high, kSlab_m, picture, rng));
      sides.push_back(put_side(corridors, high, {low.x(), high.y()}, 0, picture, rng));
      sides.push_back(put_side(corridors, {low.x(), high.y()}, low, kSlab_m, picture, rng));
      // What lies behind the walls fills the block, up to the backs of the alcoves.
      const Vec2 inside = high - low - 2 * Vec2(kSlab_m, kSlab_m);
      const Vec2 middle = (low + high) / 2;
      BoxSettings& core = put_box(into, "core", Vec3(inside.x(), inside.y(), kRoomHeight_m),
                                  {middle.x(), middle.y(), 0}, 0, picture);
      core.faces = {{"front", ""}, {"back", ""}, {"left", ""}, {"right", ""}, {"bottom", ""}};
      corridors.passability.block({low + Vec2(kSlab_m, kSlab_m) - Vec2(kBack_m, kBack_m),
                                   high - Vec2(kSlab_m, kSlab_m) + Vec2(kBack_m, kBack_m)});
      const double half_m = plan.width_m / 2;
      corners.insert(corners.end(), {low - Vec2(half_m, half_m), high + Vec2(half_m, half_m),
                                     Vec2(low.x() - half_m, high.y() + half_m),
                                     Vec2(high.x() + half_m, low.y() - half_m)});
    }
  }
  corridors.passability.keep_open(corners);

  // The outer walls, anticlockwise, their left sides towards the corridors.
  const double half_m = kWallThickness_m / 2;
  const std::array<Vec2, 4> outer{Vec2(-half_m, -half_m), Vec2(size.x() + half_m, -half_m),
                                  size + Vec2(half_m, half_m), Vec2(-half_m, size.y() + half_m)};
  const std::array<Vec2, 4> inner{Vec2(0, 0), Vec2(size.x(), 0), size, Vec2(0, size.y())};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2& from = outer[k];
    const Vec2& to = outer[(k + 1) % 4];
    const Vec2 along = (to - from).normalized() * (k % 2 == 0 ? half_m : -half_m);
    const std::string picture = k % 2 == 0 ? "corridors/wall_a" : "corridors/wall_b";
    put_wall(into, {.from = from - along, .to = to + along, .left = picture, .right = picture});
    into.boxes.back().faces["right"] = "";
    sides.push_back({WallFace(inner[(k + 1) % 4], inner[k]), {}});
  }
  for (std::size_t k = 0; k < sides.size(); ++k) {
    dress_side(corridors, sides[k], rng.fork(fmt::format("side {}", k)));
  }

  // A lamp about every 3.5 m of each corridor.
  const auto light_corridor = [&into](const Vec2& from, const Vec2& to) {
    const int count = std::max(1, static_cast<int>(std::lround((to - from).norm() / 3.5)));
    const Vec2 along = to - from;
    for (int k = 0; k < count; ++k) {
      const Vec2 p = from + along * (k + 0.5) / count;
      put_lamp(into, {p.x(), p.y(), std::atan2(along.y(), along.x())}, 0.8);
    }
  };
  const double w = plan.width_m / 2;
  for (std::size_t i = 0; i <= rows.size(); ++i) {
    const double y = i == 0 ? w : rows[i - 1][1] + w;
    light_corridor({0, y}, {size.x(), y});
  }
  for (std::size_t i = 0; i <= columns.size(); ++i) {
    const double x = i == 0 ? w : columns[i - 1][1] + w;
    for (const auto& row : rows) {
      light_corridor({x, row[0]}, {x, row[1]});
    }
  }
}

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "sim/world/generate.h"
#include "sim/world/load.h"
#include "sim/world/office_room.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr double kLeast_m = 4.0;
constexpr double kMost_m = 40.0;
constexpr double kDoorway_m = 1.3;

Vec2 half_of(const Vec2& size_m) { return {(size_m.x() - kWallThickness_m) / 2, size_m.y()}; }

bool is_sensible(const Vec2& size_m) {
  return half_of(size_m).minCoeff() >= kLeast_m && size_m.maxCoeff() <= kMost_m;
}

std::string size_rule() {
  return fmt::format(
      "must leave two halves of at least {:g} m each way side by side along x, and be at most {:g} "
      "m "
      "each way",
      kLeast_m, kMost_m);
}

std::string desks_rule(const MirroredPlan& plan) {
  return fmt::format(
      "must be even and at most {}, which is what fits into the halves of {:g} m x {:g} m; take "
      "fewer "
      "desks or a larger size_m",
      2 * most_desks(half_of(plan.size_m)), plan.size_m.x(), plan.size_m.y());
}

bool has_place(const MirroredPlan& plan) {
  return plan.desks % 2 == 0 && plan.desks / 2 <= most_desks(half_of(plan.size_m));
}

/// The half of the room below x = size / 2, without the wall in the middle.
WorldSettings western_half(const MirroredPlan& plan, const Rng& rng) {
  WorldSettings half;
  const Vec2 size = half_of(plan.size_m);
  const double t = kWallThickness_m;
  const double x_middle = plan.size_m.x() / 2;
  const double y = plan.size_m.y();
  put_wall(half, {.from = {-t, -t / 2}, .to = {x_middle, -t / 2}});
  put_wall(half, {.from = {-t / 2, y}, .to = {-t / 2, 0}});
  put_wall(half, {.from = {x_middle, y + t / 2}, .to = {-t, y + t / 2}});
  OfficeRoom room;
  room.low = Vec2(0, 0);
  room.high = size;
  room.desks = plan.desks / 2;
  room.faces.emplace_back(Vec2(size.x(), 0), Vec2(0, 0));
  room.faces.emplace_back(Vec2(0, 0), Vec2(0, y));
  room.faces.emplace_back(Vec2(0, y), Vec2(size.x(), y));
  WallFace divided(Vec2(size.x(), y), Vec2(size.x(), 0));
  for (const double share : {0.25, 0.75}) {
    divided.take(
        {{share * y - kDoorway_m / 2 - 0.05, 0}, {share * y + kDoorway_m / 2 + 0.05, 2.15}});
    room.kept_free.push_back(
        {{size.x() - 1.2, share * y - kDoorway_m / 2}, {size.x(), share * y + kDoorway_m / 2}});
  }
  room.faces.push_back(divided);
  put_door(half, room.faces[1], 0.5 * y);
  room.kept_free.push_back({{0, 0.5 * y - 0.55}, {1, 0.5 * y + 0.55}});
  furnish(half, std::move(room), rng);
  // The floor and the ceiling meet their likes under the wall in the middle.
  put_floor(half, {size.x(), 0}, {x_middle, y}, "office/carpet_blue", 2);
  return half;
}

}  // namespace

void bind(Fields& f, MirroredPlan& o) {
  f("size_m", o.size_m, positive);
  f("desks", o.desks, at_least(0));
  f("seed", o.seed);
  f.require(is_sensible(o.size_m), "size_m", size_rule());
  if (is_sensible(o.size_m)) {
    f.require(has_place(o), "desks", desks_rule(o));
  }
}

void generate(const MirroredPlan& plan, WorldSettings& into) {
  if (!is_sensible(plan.size_m)) {
    throw ConfigError("mirrored.size_m: " + size_rule());
  }
  if (!has_place(plan)) {
    throw ConfigError("mirrored.desks: " + desks_rule(plan));
  }
  into.ambient = 0.5;
  const double x_middle = plan.size_m.x() / 2;
  const double y = plan.size_m.y();
  WallSettings divide{.from = {x_middle, 0}, .to = {x_middle, y}};
  for (const double share : {0.25, 0.75}) {
    divide.openings.push_back({share * y - kDoorway_m / 2, share * y + kDoorway_m / 2, 2.1});
  }
  put_wall(into, divide);
  const WorldSettings half = western_half(plan, Rng(plan.seed).fork("mirrored"));
  put_both_halves(into, half, plan.size_m);
}

}  // namespace panoptes::sim

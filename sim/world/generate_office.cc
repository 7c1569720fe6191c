// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "sim/world/generate.h"
#include "sim/world/load.h"
#include "sim/world/office_room.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr double kLeast_m = 3.0;
constexpr double kMost_m = 40.0;

bool is_sensible(const Vec2& size_m) {
  return size_m.minCoeff() >= kLeast_m && size_m.maxCoeff() <= kMost_m;
}

std::string size_rule() {
  return fmt::format("must be between {:g} m and {:g} m each way", kLeast_m, kMost_m);
}

std::string desks_rule(const OfficePlan& plan) {
  return fmt::format(
      "must be at most {}, which is what fits into {:g} m x {:g} m with aisles of {:g} m; take "
      "fewer "
      "desks or a larger size_m",
      most_desks(plan.size_m), plan.size_m.x(), plan.size_m.y(), kOfficeAisle_m);
}

}  // namespace

void bind(Fields& f, OfficePlan& o) {
  f("size_m", o.size_m, positive);
  f("desks", o.desks, at_least(0));
  f("overhangs", o.overhangs);
  f("texture", o.texture, between(0, 1));
  f("seed", o.seed);
  f.require(is_sensible(o.size_m), "size_m", size_rule());
  if (is_sensible(o.size_m)) {
    f.require(o.desks <= most_desks(o.size_m), "desks", desks_rule(o));
  }
}

void generate(const OfficePlan& plan, WorldSettings& into) {
  if (!is_sensible(plan.size_m)) {
    throw ConfigError("office.size_m: " + size_rule());
  }
  if (plan.desks > most_desks(plan.size_m)) {
    throw ConfigError("office.desks: " + desks_rule(plan));
  }
  Rng rng = Rng(plan.seed).fork("office");
  into.ambient = 0.5;
  const double x = plan.size_m.x();
  const double y = plan.size_m.y();
  const double half = kWallThickness_m / 2;
  const char* const paint = office_wall(plan.texture);
  // The walls stand outside of the room, anticlockwise, their left sides towards it.
  const std::array<Vec2, 4> corners{Vec2(-half, -half), Vec2(x + half, -half),
                                    Vec2(x + half, y + half), Vec2(-half, y + half)};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& from = corners[i];
    const Vec2& to = corners[(i + 1) % corners.size()];
    // East and west walls end at the others; those reach over the corners.
    const Vec2 over = (to - from).normalized() * (i % 2 == 0 ? half : -half);
    put_wall(into, {.from = from - over, .to = to + over, .left = paint, .right = paint});
  }
  OfficeRoom room;
  room.low = Vec2(0, 0);
  room.high = plan.size_m;
  room.desks = plan.desks;
  room.overhangs = plan.overhangs;
  room.texture = plan.texture;
  const std::array<Vec2, 4> inner{Vec2(0, 0), Vec2(x, 0), Vec2(x, y), Vec2(0, y)};
  for (std::size_t i = 0; i < inner.size(); ++i) {  // seen from inside, left is the later corner
    room.faces.emplace_back(inner[(i + 1) % inner.size()], inner[i]);
  }
  Rng doors = rng.fork("door");
  WallFace& entrance = room.faces[static_cast<std::size_t>(doors.index(4))];
  const double at_m = doors.uniform(0.8, entrance.length_m() - 0.8);
  put_door(into, entrance, at_m, plan.texture > 0 ? "office/door" : "office/plain_wood");
  room.kept_free.push_back(FloorSpace::outline(entrance.at(at_m) * Pose2{0.5, 0, 0}, {1.0, 1.1}));
  furnish(into, std::move(room), rng);
}

}  // namespace panoptes::sim

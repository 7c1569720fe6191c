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
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr double kLeastLength_m = 100;
constexpr double kMostLength_m = 1000;
constexpr double kStreet_m = 8.0;  // from front to front
constexpr double kPavement_m = 1.5;
constexpr double kKerb_m = 0.15;
constexpr double kHouseDepth_m = 1.0;  // of a front; what lies behind is one solid block
constexpr double kEaves_m = 6.2;
constexpr double kPlinth_m = 0.50;
constexpr double kPlinthDepth_m = 0.05;
constexpr double kFromKerb_m = 0.28;  // trees and posts, onto the pavement
constexpr double kCornerFree_m = 5;   // nothing is parked or planted so near a corner of the block
constexpr double kPaintHeight_m = 0.004;

std::string length_rule() {
  return fmt::format("must be between {:g} and {:g} m", kLeastLength_m, kMostLength_m);
}

bool is_sensible(double length_m) {
  return length_m >= kLeastLength_m && length_m <= kMostLength_m;
}

/// A box of which only some faces are there.
BoxSettings& put_faces(WorldSettings& into, const std::string& kind, const Vec3& size_m,
                       const Pose2& at, double z_m, const std::string& picture, double picture_m,
                       const std::vector<std::string>& seen) {
  BoxSettings& box = put_box(into, kind, size_m, at, z_m, picture, Vec2(picture_m, picture_m));
  for (const char* face : {"front", "back", "left", "right", "top", "bottom"}) {
    if (std::find(seen.begin(), seen.end(), face) == seen.end()) {
      box.faces[face] = "";
    }
  }
  return box;
}

/// Four strips of floor between two rectangles, one inside the other.
void put_ring(WorldSettings& into, const Rectangle& inner, const Rectangle& outer,
              const std::string& picture, double tile_m) {
  put_floor(into, outer.low, {outer.high.x(), inner.low.y()}, picture, tile_m);
  put_floor(into, {outer.low.x(), inner.high.y()}, outer.high, picture, tile_m);
  put_floor(into, {outer.low.x(), inner.low.y()}, {inner.low.x(), inner.high.y()}, picture, tile_m);
  put_floor(into, {inner.high.x(), inner.low.y()}, {outer.high.x(), inner.high.y()}, picture,
            tile_m);
}

/// One row of houses along a side of the street.
struct Row {
  WallFace front;  ///< as seen from the street
  bool is_inner = true;
};

const std::array<const char*, 4> kWalls{"street/brick_red", "street/brick_yellow",
                                        "street/plaster_ochre", "street/plaster_blue"};

/// What is on the front of a house, its middle at s along the row.
void dress_front(WorldSettings& into, const WallFace& row, double from_m, double width_m, Rng rng) {
  const Pose2 left = row.at(from_m);
  const Pose2 right = row.at(from_m + width_m);
  WallFace face(left.position(), right.position(), kEaves_m);
  const int bays = static_cast<int>(std::floor(width_m / 2.0));
  const double bay_m = width_m / bays;
  const std::string window = fmt::format("street/window_{}", 1 + rng.index(4));
  const Hanging pane{window, {1.5, 1.6}};
  const int kind = rng.index(5);  // 0: shop, 1: garage, else flats
  const auto on_floor = [&](const std::string& mesh, const Vec2& size, double s_m,
                            const std::map<std::string, std::string>& textures = {}) {
    const Rectangle what{{s_m - size.x() / 2, 0}, {s_m + size.x() / 2, size.y()}};
    if (!face.is_clear(what)) {
      return;
    }
    face.take(what);
    put(into, mesh, face.at(s_m), size.y() / 2, textures);
  };
  if (kind == 0) {
    const std::string shop = std::string("street/shop_") + "abc"[rng.index(3)];
    on_floor("street/shop", {3.6, 3.0}, rng.uniform(2.0, width_m - 2.0), {{"picture", shop}});
  } else if (kind == 1) {
    on_floor("street/garage", {2.6, 2.3}, bay_m * (0.5 + rng.index(2) * (bays - 1)));
  }
  const int door_bay = rng.index(bays);
  for (int k = 0; k < bays; ++k) {
    const int bay = (door_bay + k) % bays;
    const double s_m = (bay + 0.5) * bay_m;
    if (k == 0) {
      on_floor(fmt::format("street/door_{}", 1 + rng.index(4)), {1.25, 2.35}, s_m);
    } else {
      hang(into, face, pane, s_m, 1.72);
    }
    hang(into, face, pane, s_m, 4.55);
  }
  for (double s_m = rng.uniform(0.4, 1.2); s_m < width_m; s_m += rng.uniform(0.6, 2.0)) {
    switch (rng.index(4)) {
      case 0:
        hang(into, face, {"street/house_letterbox", {0.35, 0.40}}, s_m, 1.25);
        break;
      case 1:
        hang(into, face, {"street/house_sign", {0.50, 0.50}}, s_m, rng.uniform(2.4, 2.9));
        break;
      case 2:
        hang(into, face, {"street/dish", {0.60, 0.60}}, s_m, rng.uniform(3.2, 3.4));
        break;
      default:
        hang(into, face, {fmt::format("office/poster_{:02}", 1 + rng.index(16)), {0.70, 0.70}}, s_m,
             rng.uniform(1.3, 1.6));
        break;
    }
  }
  const Pose2 end = row.at(from_m + 0.08);
  put(into, "street/downpipe", end, 3.0 + 0.1);
  const Rectangle plinth{{0, 0}, {width_m, kPlinth_m}};
  // The plinth runs between what reaches the ground.
  constexpr double kStep_m = 0.05;
  const int steps = static_cast<int>(std::floor(width_m / kStep_m));
  int first = -1;
  for (int k = 0; k <= steps; ++k) {
    const bool clear =
        k < steps && face.is_clear({{k * kStep_m, 0.0}, {(k + 1) * kStep_m, plinth.high.y()}});
    if (clear && first < 0) {
      first = k;
    }
    if (!clear && first >= 0) {
      const Pose2 at = face.at((first + k) * kStep_m / 2);
      const Vec2 middle = at * Vec2(kPlinthDepth_m / 2, 0);
      put_faces(into, "plinth", Vec3(kPlinthDepth_m, (k - first) * kStep_m, kPlinth_m),
                {middle.x(), middle.y(), at.theta_rad}, 0, "street/plinth", 1.6,
                {"front", "left", "right", "top"});
      first = -1;
    }
  }
}

/// Houses wall to wall from one end of a side to the other; what is left over is hedges.
void build_row(WorldSettings& into, const WallFace& row, Rng rng) {
  constexpr std::array<double, 3> kFronts_m{6, 8, 10};
  double s_m = 0;
  int before = -1;
  while (s_m < row.length_m() - 1e-9) {
    const double left_m = row.length_m() - s_m;
    const int choice = rng.index(3);
    double width_m = kFronts_m[static_cast<std::size_t>(choice)];
    const bool is_hedge = left_m < kFronts_m[0] || (s_m > 0 && rng.uniform() < 0.12);
    if (is_hedge) {
      width_m = std::min(left_m, rng.uniform(3.0, 5.5));
      const Pose2 at = row.at(s_m + width_m / 2);
      const Vec2 middle = at * Vec2(-0.4, 0);
      put_faces(into, "hedge", Vec3(0.8, width_m, 1.7), {middle.x(), middle.y(), at.theta_rad}, 0,
                "street/hedge", 1.2, {"front", "left", "right", "top"});
      s_m += width_m;
      continue;
    }
    while (width_m > left_m) {
      width_m -= 2;
    }
    const Pose2 at = row.at(s_m + width_m / 2);
    const Vec2 middle = at * Vec2(-kHouseDepth_m / 2, 0);
    int wall = rng.index(static_cast<int>(kWalls.size()));
    wall = wall == before ? (wall + 1) % static_cast<int>(kWalls.size()) : wall;
    before = wall;
    put_faces(into, "house", Vec3(kHouseDepth_m, width_m, kEaves_m),
              {middle.x(), middle.y(), at.theta_rad}, 0, kWalls[static_cast<std::size_t>(wall)],
              1.8, {"front", "left", "right"});
    put(into, fmt::format("street/roof_{}", static_cast<int>(width_m)), at, kEaves_m);
    dress_front(into, row, s_m, width_m, rng.fork(fmt::format("front {:.1f}", s_m)));
    s_m += width_m;
  }
}

/// What stands along the kerb before a row of houses, on the pavement: trees, lamp posts, bins.
void plant_kerb(WorldSettings& into, const WallFace& row, bool is_inner, Rng rng) {
  const double from_front_m = kPavement_m - kFromKerb_m;
  const double margin_m = is_inner ? 1.0 : kCornerFree_m + kStreet_m;
  int k = rng.index(3);
  for (double s_m = margin_m + rng.uniform(0, 3); s_m < row.length_m() - margin_m;
       s_m += rng.uniform(4.5, 7.5), ++k) {
    const Pose2 on_front = row.at(s_m);
    const Vec2 p = on_front * Vec2(from_front_m, 0);
    const Pose2 to_street{p.x(), p.y(), on_front.theta_rad};
    const Pose2 along{p.x(), p.y(), wrap_angle(on_front.theta_rad + std::numbers::pi / 2)};
    if (k % 3 == 0) {
      put(into, fmt::format("street/tree_{}", 1 + rng.index(2)),
          {p.x(), p.y(), rng.uniform(-3, 3)});
    } else if (k % 3 == 1 && is_inner) {
      put(into, "street/lamp_post", along);
    } else {
      switch (rng.index(7)) {
        case 0:
          put(into, "street/bin", to_street);
          break;
        case 1:
          put(into, "street/meter", to_street);
          break;
        case 2:
          put(into, "street/letterbox", to_street);
          break;
        case 3:
          put(into, "street/bench", to_street);
          break;
        case 4:
          put(into, "street/a_board", along);
          break;
        case 5:
          put(into, "street/sign_name", along);
          break;
        default:
          put(into, "street/planter", to_street);
          break;
      }
    }
  }
}

/// Cars parked along the outer kerb.
void park_cars(WorldSettings& into, const WallFace& row, Rng rng) {
  constexpr double kCar_m = 4.3;
  constexpr double kFromFront_m = kPavement_m + 0.25 + 0.90;
  const double margin_m = kStreet_m + kCornerFree_m;
  for (double s_m = margin_m + rng.uniform(0, 4); s_m + kCar_m < row.length_m() - margin_m;
       s_m += kCar_m + (rng.uniform() < 0.5 ? rng.uniform(0.9, 1.6) : rng.uniform(4, 12))) {
    const Pose2 on_front = row.at(s_m + kCar_m / 2);
    const Vec2 p = on_front * Vec2(kFromFront_m + rng.uniform(-0.05, 0.08), 0);
    const double turn_rad = rng.uniform() < 0.8 ? std::numbers::pi / 2 : -std::numbers::pi / 2;
    const std::array<const char*, 3> colours{"street/car_red", "street/car_blue",
                                             "street/car_grey"};
    put(into, "street/car",
        {p.x(), p.y(), wrap_angle(on_front.theta_rad + turn_rad + rng.uniform(-0.02, 0.02))}, 0,
        {{"paint", colours[static_cast<std::size_t>(rng.index(3))]}});
  }
}

/// Dashes along the middle of the road, zebra stripes before the corners, lids of manholes.
void paint_road(WorldSettings& into, const Rectangle& middle_line, Rng rng) {
  const auto paint = [&into](const Vec2& at, const Vec2& size) {
    put_faces(into, "paint", Vec3(size.x(), size.y(), kPaintHeight_m), {at.x(), at.y(), 0}, 0,
              "street/paint", 0.8, {"top"});
  };
  const Vec2 size = middle_line.high - middle_line.low;
  constexpr double kZebra_m = 6.5;  // from the corner of the middle line
  for (const bool is_x : {true, false}) {
    for (const double side : {0.0, 1.0}) {
      const double length_m = is_x ? size.x() : size.y();
      const auto place = [&](double along_m, double across_m) {
        return is_x ? Vec2(middle_line.low.x() + along_m,
                           middle_line.low.y() + side * size.y() + across_m)
                    : Vec2(middle_line.low.x() + side * size.x() + across_m,
                           middle_line.low.y() + along_m);
      };
      const auto turned = [is_x](double along_m, double across_m) {
        return is_x ? Vec2(along_m, across_m) : Vec2(across_m, along_m);
      };
      for (double s_m = kZebra_m + 3.5; s_m < length_m - kZebra_m - 3.5; s_m += 4) {
        paint(place(s_m, 0), turned(1.8, 0.12));
      }
      for (const double s_m : {kZebra_m, length_m - kZebra_m}) {
        for (double across_m = -1.75; across_m < 2; across_m += 0.875) {
          paint(place(s_m, across_m), turned(2.2, 0.45));
        }
      }
      for (double s_m = rng.uniform(9, 16); s_m < length_m - 8; s_m += rng.uniform(12, 25)) {
        const Vec2 p = place(s_m, rng.uniform(-1.2, -0.6));
        put(into, "street/manhole", {p.x(), p.y(), rng.uniform(-3, 3)}, kPaintHeight_m);
      }
    }
  }
}

}  // namespace

void bind(Fields& f, StreetPlan& o) {
  f("length_m", o.length_m, between(kLeastLength_m, kMostLength_m));
  f("seed", o.seed);
}

void generate(const StreetPlan& plan, WorldSettings& into) {
  if (!is_sensible(plan.length_m)) {
    throw ConfigError("street.length_m: " + length_rule());
  }
  Rng rng = Rng(plan.seed).fork("street");
  // Outdoors: everything shines and darkens with the day.
  into.ambient = 0.55;
  into.ambient_group = "daylight";
  into.sky_bgr = Vec3(0.86, 0.68, 0.48);
  const double sun_rad = rng.uniform(0, 2 * std::numbers::pi);
  into.sun = Sun{Vec3(0.6 * std::cos(sun_rad), 0.6 * std::sin(sun_rad), 1), 0.9, "daylight"};

  // The middle of the road goes once around the block.
  const double half_length_m = plan.length_m / 2;
  const double middle_x_m = half_length_m * rng.uniform(0.52, 0.64);
  const Rectangle middle_line{
      {kStreet_m / 2, kStreet_m / 2},
      {kStreet_m / 2 + middle_x_m, kStreet_m / 2 + half_length_m - middle_x_m}};
  const Rectangle outer = middle_line.grown(kStreet_m / 2);
  const Rectangle inner = middle_line.grown(-kStreet_m / 2);
  put_ring(into, inner, inner.grown(kPavement_m), "street/paving", 2);
  put_ring(into, inner.grown(kPavement_m), inner.grown(kPavement_m + kKerb_m), "street/kerb", 1);
  put_ring(into, inner.grown(kPavement_m + kKerb_m), outer.grown(-kPavement_m - kKerb_m),
           "street/asphalt", 2);
  put_ring(into, outer.grown(-kPavement_m - kKerb_m), outer.grown(-kPavement_m), "street/kerb", 1);
  put_ring(into, outer.grown(-kPavement_m), outer, "street/paving", 2);
  paint_road(into, middle_line, rng.fork("paint"));

  // The block: fronts before one solid core. Seen from the street, south, east, north, west.
  const Vec2 south_east(inner.high.x(), inner.low.y());
  const Vec2 north_west(inner.low.x(), inner.high.y());
  const std::array<WallFace, 4> block{
      WallFace(inner.low, south_east, kEaves_m), WallFace(south_east, inner.high, kEaves_m),
      WallFace(inner.high, north_west, kEaves_m), WallFace(north_west, inner.low, kEaves_m)};
  const Vec2 outer_south_east(outer.high.x(), outer.low.y());
  const Vec2 outer_north_west(outer.low.x(), outer.high.y());
  const std::array<WallFace, 4> across{WallFace(outer_south_east, outer.low, kEaves_m),
                                       WallFace(outer.high, outer_south_east, kEaves_m),
                                       WallFace(outer_north_west, outer.high, kEaves_m),
                                       WallFace(outer.low, outer_north_west, kEaves_m)};
  const Rectangle core = inner.grown(-kHouseDepth_m);
  const Vec2 core_size = core.high - core.low;
  const Vec2 core_middle = (core.low + core.high) / 2;
  put_faces(into, "core", Vec3(core_size.x(), core_size.y(), kEaves_m),
            {core_middle.x(), core_middle.y(), 0}, 0, "street/brick_yellow", 1.8,
            {"front", "back", "left", "right"});
  for (std::size_t k = 0; k < 4; ++k) {
    const Rng side = rng.fork(fmt::format("side {}", k));
    build_row(into, block[k], side.fork("inner houses"));
    build_row(into, across[k], side.fork("outer houses"));
    plant_kerb(into, block[k], true, side.fork("inner kerb"));
    plant_kerb(into, across[k], false, side.fork("outer kerb"));
    park_cars(into, across[k], side.fork("cars"));
  }

  // Clouds come and go.
  Rng sky = rng.fork("sky");
  double power = 1;
  for (double at_s = sky.uniform(20, 60); at_s < 1800;) {
    EventSettings event;
    event.at_s = at_s;
    event.over_s = sky.uniform(20, 60);
    event.lights = "daylight";
    power = power > 0.85 ? sky.uniform(0.55, 0.75) : sky.uniform(0.9, 1.1);
    event.power = power;
    into.events.push_back(event);
    at_s += event.over_s + sky.uniform(20, 90);
  }
}

}  // namespace panoptes::sim

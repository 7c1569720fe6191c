// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/home_rooms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace panoptes::sim {
namespace {

constexpr double kQuarter_rad = std::numbers::pi / 2;
constexpr double kBeforeFurniture_m = 0.9;
constexpr double kNearWall_m = 0.35;  // furniture so near a wall hides what hangs there
constexpr double kRugHeight_m = 0.008;
constexpr double kLampDepth_m = 0.06;
const Hanging kWindow{"home/window", {2.12, 1.58}};
constexpr double kWindowMiddle_m = 1.72;
constexpr double kWindowDepth_m = 0.03;

/// A piece of furniture that stands with its back to a wall.
struct Piece {
  std::string mesh;
  Vec2 size_m;  ///< ahead and across
  double height_m = 1;
};

const Piece kSofa{"home/sofa", {0.92, 2.12}, 0.86};
const Piece kTelevision{"home/tv_bench", {0.44, 1.72}, 1.22};
const Piece kArmchair{"home/armchair", {0.92, 0.97}, 0.86};
const Piece kBed{"home/bed", {2.08, 1.70}, 1.06};
const Piece kNightstand{"home/nightstand", {0.42, 0.46}, 0.94};
const Piece kWardrobe{"home/wardrobe", {0.64, 1.66}, 2.4};
const Piece kDresser{"home/dresser", {0.48, 1.02}, 1.68};
const Piece kTub{"home/tub", {0.80, 1.70}, 0.8};
const Piece kToilet{"home/toilet", {0.68, 0.44}, 0.86};
const Piece kBasin{"home/basin", {0.50, 0.86}, 0.9};
const Piece kWasher{"home/unit_washer", {0.62, 0.61}, 0.9};
const Piece kBasket{"home/basket", {0.48, 0.48}, 0.56};
const Piece kShoes{"home/shoe_rack", {0.32, 0.92}, 0.96};
const Piece kPlant{"office/plant", {0.56, 0.56}, 1.8};
const Piece kRadiator{"home/radiator", {0.10, 1.12}, 0.74};

/// Furnishes one room.
class Furnisher {
 public:
  Furnisher(WorldSettings& into, HomeRoom& room, PassabilityGrid& passability, Rng& rng)
      : into_(into),
        room_(room),
        passability_(passability),
        rng_(rng),
        floor_(room.area.low, room.area.high),
        doors_(room.keep_clear) {
    for (const Rectangle& solid : room.solid) {
      floor_.take(solid);
    }
  }

  Rng& rng() { return rng_; }
  WallFace& face(std::size_t f) { return room_.faces[f]; }
  WorldSettings& into() { return into_; }

  /// Floor with its back to a face, its middle at s, with room before it.
  struct Stand {
    Rectangle outline;
    Rectangle before;
  };
  Stand stand_at(std::size_t f, double s_m, const Vec2& size_m, double before_m,
                 double gap_m) const {
    const Pose2 at = room_.faces[f].at(s_m);
    const auto outline_at = [&](double from_m, double depth_m) {
      const Vec2 middle = at * Vec2(from_m + depth_m / 2, 0);
      return FloorSpace::outline({middle.x(), middle.y(), at.theta_rad}, {depth_m, size_m.y()});
    };
    return {outline_at(gap_m, size_m.x()), outline_at(gap_m + size_m.x(), before_m)};
  }

  /// Whether wall and floor are clear there; passages are another matter.
  bool fits(std::size_t f, double s_m, const Vec2& size_m, double height_m,
            double before_m = kBeforeFurniture_m, double gap_m = kSkirting_m) const {
    const double half_m = size_m.y() / 2;
    const Stand there = stand_at(f, s_m, size_m, before_m, gap_m);
    return room_.faces[f].is_clear({{s_m - half_m, 0}, {s_m + half_m, height_m}}) &&
           is_clear(there.outline, there.before);
  }

  /// Takes it; returns the pose on the face, or nothing without room.
  std::optional<Pose2> claim(std::size_t f, double s_m, const Vec2& size_m, double height_m,
                             double before_m = kBeforeFurniture_m, double gap_m = kSkirting_m) {
    const Stand there = stand_at(f, s_m, size_m, before_m, gap_m);
    if (!fits(f, s_m, size_m, height_m, before_m, gap_m) ||
        !take(there.outline, there.before, height_m)) {
      return std::nullopt;
    }
    return room_.faces[f].at(s_m);
  }

  /// The piece itself; false without room.
  bool stand(const Piece& piece, std::size_t f, double s_m,
             const std::map<std::string, std::string>& textures = {}) {
    const std::optional<Pose2> at = claim(f, s_m, piece.size_m, piece.height_m);
    if (!at) {
      return false;
    }
    const Vec2 middle = *at * Vec2(kSkirting_m + piece.size_m.x() / 2, 0);
    put(into_, piece.mesh, {middle.x(), middle.y(), at->theta_rad}, 0, textures);
    return true;
  }

  /// Places along the walls where something of that width could stand: corners and some between, in
  /// random order.
  std::vector<std::pair<std::size_t, double>> places(double width_m) {
    std::vector<std::pair<std::size_t, double>> all;
    for (std::size_t f = 0; f < room_.faces.size(); ++f) {
      const double free_m = room_.faces[f].length_m() - width_m;
      if (free_m < 0.04) {
        continue;
      }
      all.emplace_back(f, width_m / 2 + 0.02);
      all.emplace_back(f, width_m / 2 + free_m - 0.02);
      for (int k = 0; k < 5; ++k) {
        all.emplace_back(f, width_m / 2 + rng_.uniform(0.02, free_m - 0.02));
      }
    }
    for (std::size_t k = all.size(); k > 1; --k) {
      std::swap(all[k - 1], all[static_cast<std::size_t>(rng_.index(static_cast<int>(k)))]);
    }
    return all;
  }

  /// Somewhere along the walls; where, if there was room.
  std::optional<std::pair<std::size_t, double>> stand(
      const Piece& piece, const std::map<std::string, std::string>& textures = {}) {
    for (const auto& [f, s_m] : places(piece.size_m.y())) {
      if (stand(piece, f, s_m, textures)) {
        return std::pair(f, s_m);
      }
    }
    return std::nullopt;
  }

  /// Free in the room, with a passage all around.
  bool stand_free(const std::string& mesh, const Pose2& at, const Vec2& size_m, double height_m) {
    const Rectangle outline = FloorSpace::outline(at, size_m);
    if (!room_.area.contains(outline.grown(kBeforeFurniture_m)) ||
        !floor_.is_clear(outline, kBeforeFurniture_m) || !take(outline, outline, height_m)) {
      return false;
    }
    put(into_, mesh, at);
    return true;
  }

  void lay_rug(const std::string& picture, const Pose2& at, const Vec2& size_m) {
    const Rectangle outline = FloorSpace::outline(at, size_m);
    if (!room_.area.grown(-0.05).contains(outline)) {
      return;
    }
    put_box(into_, "rug", Vec3(size_m.x(), size_m.y(), kRugHeight_m), at, 0, picture);
  }

  /// What stands about without a place of its own, anywhere but before doors: gaps between things
  /// are as wide as chance has it, too narrow ones too.
  void strew(double share) {
    constexpr int kMostThings = 16;
    constexpr int kTries = 12;
    constexpr double kApart_m = 0.02;
    static const std::array<Piece, 9> kThings{{{"office/boxes", {0.44, 0.60}, 0.9},
                                               {"office/bin", {0.32, 0.32}, 0.4},
                                               {"home/basket", {0.48, 0.48}, 0.56},
                                               {"home/chair", {0.50, 0.50}, 0.96},
                                               {"office/chair", {0.56, 0.56}, 1.0},
                                               {"office/plant", {0.56, 0.56}, 1.8},
                                               {"office/boxes", {0.44, 0.60}, 0.9},
                                               {"home/nightstand", {0.44, 0.48}, 0.94},
                                               {"corridors/sand", {0.42, 0.42}, 0.9}}};
    const int count = static_cast<int>(std::lround(share * kMostThings));
    for (int k = 0; k < count; ++k) {
      const Piece& thing = one_of(kThings, rng_);
      for (int i = 0; i < kTries; ++i) {
        const Pose2 at{rng_.uniform(room_.area.low.x(), room_.area.high.x()),
                       rng_.uniform(room_.area.low.y(), room_.area.high.y()),
                       rng_.uniform(-std::numbers::pi, std::numbers::pi)};
        const Rectangle outline = FloorSpace::outline(at, thing.size_m);
        if (!room_.area.grown(-kSkirting_m).contains(outline) ||
            !floor_.is_clear(outline, kApart_m) ||
            std::any_of(doors_.begin(), doors_.end(),
                        [&outline](const Rectangle& r) { return r.overlaps(outline); }) ||
            !passability_.block_if_passable(outline)) {
          continue;
        }
        floor_.take(outline);
        put(into_, thing.mesh, at);
        break;
      }
    }
  }

  void leave_bare() {
    for (const auto& [f, where] : room_.bare) {
      room_.faces[f].take(where);
    }
  }

  /// Windows in walls to the outside, with radiators below some.
  void put_windows() {
    for (std::size_t f = 0; f < room_.faces.size(); ++f) {
      WallFace& wall = room_.faces[f];
      if (!room_.is_outside[f]) {
        continue;
      }
      const int count = std::max(1, static_cast<int>(std::floor(wall.length_m() / 3.2)));
      for (int k = 0; k < count; ++k) {
        const double s_m = wall.length_m() * (k + 0.5) / count + rng_.uniform(-0.2, 0.2);
        if (!hang(into_, wall, kWindow, s_m, kWindowMiddle_m)) {
          continue;
        }
        const Pose2 at = wall.at(s_m);
        const Vec2 middle = at * Vec2(kWindowDepth_m, 0);
        AreaLight light;
        light.at_m = Vec3(middle.x(), middle.y(), kWindowMiddle_m);
        light.size_m = Vec2(1.40, 1.30);
        light.normal = Vec3(std::cos(at.theta_rad), std::sin(at.theta_rad), 0);
        light.power = 0.9;
        light.group = "daylight";
        into_.lights.push_back(light);
        if (rng_.uniform() < 0.5 && room_.kind != RoomKind::kKitchen &&
            claim(f, s_m, kRadiator.size_m, kRadiator.height_m, 0.3, 0)) {
          put(into_, kRadiator.mesh, at, kRadiator.height_m / 2 - 0.01);
        }
      }
    }
  }

  void put_ceiling_lamps() {
    const Vec2 size = room_.area.high - room_.area.low;
    const auto count = [](double length_m) {
      return std::max(1, static_cast<int>(std::lround(length_m / 3.4)));
    };
    for (int j = 0; j < count(size.y()); ++j) {
      for (int i = 0; i < count(size.x()); ++i) {
        const Vec2 p = room_.area.low + Vec2((i + 0.5) * size.x() / count(size.x()),
                                             (j + 0.5) * size.y() / count(size.y()));
        put(into_, "home/lamp", {p.x(), p.y(), 0}, kRoomHeight_m);
        AreaLight light;
        light.at_m = Vec3(p.x(), p.y(), kRoomHeight_m - kLampDepth_m);
        light.size_m = Vec2(0.5, 0.5);
        light.power = 1.1;
        light.group = "lamps";
        into_.lights.push_back(light);
      }
    }
  }

  /// Shelves, paintings, clocks at the height of the eyes; sockets below.
  void hang_things() {
    std::vector<Hanging> choice;
    for (int k = 1; k <= 16; ++k) {
      choice.push_back({fmt::format("home/painting_{:02}", k), {0.60, 0.60}});
    }
    choice.push_back({"home/wall_shelf", {1.00, 0.36}});
    choice.push_back({"home/wall_shelf", {1.00, 0.36}});
    choice.push_back({"home/mirror", {0.60, 0.80}});
    choice.push_back({"home/clock", {0.36, 0.36}});
    choice.push_back({"home/cat", {0.50, 0.50}});
    if (room_.kind == RoomKind::kHall) {
      choice.insert(choice.end(), 6, {"home/coats", {1.10, 1.06}});
    }
    if (room_.kind == RoomKind::kBath) {
      choice.insert(choice.end(), 6, {"home/towels", {0.70, 0.60}});
    }
    for (WallFace& wall : room_.faces) {
      for (double s_m = rng_.uniform(0.1, 0.5); s_m < wall.length_m();) {
        const Hanging& what =
            choice[static_cast<std::size_t>(rng_.index(static_cast<int>(choice.size())))];
        const bool hangs =
            hang(into_, wall, what, s_m + what.size_m.x() / 2, rng_.uniform(1.42, 1.62));
        s_m += hangs ? what.size_m.x() + rng_.uniform(0.15, 0.8) : 0.1;
      }
      for (double s_m = rng_.uniform(0.3, 1.2); s_m < wall.length_m();
           s_m += rng_.uniform(1.2, 2.4)) {
        hang(into_, wall, {"office/socket", {0.20, 0.10}}, s_m, 0.30);
      }
      put_skirting(into_, wall);
    }
  }

 private:
  bool is_clear(const Rectangle& outline, const Rectangle& before) const {
    return room_.area.contains(before) && floor_.is_clear(outline) && floor_.is_clear(before) &&
           std::none_of(room_.keep_clear.begin(), room_.keep_clear.end(),
                        [&outline](const Rectangle& r) { return r.overlaps(outline); });
  }

  bool take(const Rectangle& outline, const Rectangle& before, double height_m) {
    if (!is_clear(outline, before) || !passability_.block_if_passable(outline)) {
      return false;
    }
    floor_.take(outline);
    room_.keep_clear.push_back(before);
    for (WallFace& wall : room_.faces) {  // what stands here hides this much of the walls about it
      const Vec2 middle = (outline.low + outline.high) / 2;
      const Pose2 on_wall = wall.at(wall.along(middle));
      const Vec2 half = (outline.high - outline.low) / 2;
      const bool is_along_x = std::abs(std::cos(on_wall.theta_rad)) < 0.5;
      const double off_m =
          (middle - on_wall.position()).norm() - (is_along_x ? half.y() : half.x());
      if (off_m < kNearWall_m) {
        const double s_m = wall.along(middle);
        const double half_m = is_along_x ? half.x() : half.y();
        wall.take({{s_m - half_m, 0}, {s_m + half_m, height_m}});
      }
    }
    return true;
  }

  WorldSettings& into_;
  HomeRoom& room_;
  PassabilityGrid& passability_;
  Rng& rng_;
  FloorSpace floor_;
  const std::vector<Rectangle> doors_;  // where nothing at all may stand
};

void stand_shelves(Furnisher& room, int count) {
  for (int k = 0; k < count; ++k) {
    const int variant = 1 + room.rng().index(5);
    const bool calm = room.rng().uniform() < 0.5;
    room.stand({fmt::format("office/shelf_{}", variant), {0.38, 0.91}, 2.13},
               {{"books", calm ? "office/books_b" : "office/books_a"},
                {"wood", calm ? "office/wood_dark" : "office/wood_shelf"}});
  }
}

/// A sofa and a television that look at each other, a rug and a low table between them.
void stand_sofa(Furnisher& room) {
  struct Seat {
    std::size_t face;
    double s_m;
    double television_s_m;
  };
  std::vector<Seat> seats;
  for (const auto& [f, s_m] : room.places(kSofa.size_m.y())) {
    const std::size_t opposite = (f + 2) % 4;
    for (const double aside_m : {0.0, -0.3, 0.3, -0.6, 0.6}) {
      const double television_s_m = room.face(opposite).length_m() - s_m + aside_m;
      if (room.fits(f, s_m, kSofa.size_m, kSofa.height_m) &&
          room.fits(opposite, television_s_m, kTelevision.size_m, kTelevision.height_m)) {
        seats.push_back({f, s_m, television_s_m});
        break;
      }
    }
  }
  for (const Seat& seat : seats) {
    if (!room.stand(kSofa, seat.face, seat.s_m)) {
      continue;
    }
    room.stand(kTelevision, (seat.face + 2) % 4, seat.television_s_m);
    const Pose2 at = room.face(seat.face).at(seat.s_m);
    const auto ahead = [&at](double by_m) {
      const Vec2 p = at * Vec2(by_m, 0);
      return Pose2{p.x(), p.y(), at.theta_rad};
    };
    room.stand_free("home/coffee_table", ahead(kSofa.size_m.x() + kBeforeFurniture_m + 0.34),
                    {0.64, 1.04}, 0.45);
    const Pose2 rug = ahead(kSofa.size_m.x() + 0.95);
    room.lay_rug("home/rug_a", {rug.x_m, rug.y_m, wrap_angle(rug.theta_rad + kQuarter_rad)},
                 {2.2, 1.5});
    return;
  }
  room.stand(kSofa);
  room.stand(kTelevision);
}

void furnish_living(Furnisher& room) {
  stand_sofa(room);
  stand_shelves(room, 3);
  room.stand(kArmchair);
  room.stand(kPlant);
  room.stand(kDresser);
  room.stand(kPlant);
}

/// Units in a row below a worktop, cupboards above them.
void stand_units(Furnisher& room) {
  constexpr double kUnit_m = 0.60;
  constexpr double kDepth_m = 0.62;
  const std::array<const char*, 7> units{
      "home/fridge",    "home/unit_drawers", "home/unit_sink",  "home/unit_cupboard",
      "home/unit_oven", "home/unit_drawers", "home/unit_washer"};
  const std::array<const char*, 3> above{"home/wall_unit_glass", "home/wall_unit_jars",
                                         "home/wall_unit_cupboard"};
  for (int count = static_cast<int>(units.size()); count >= 4; --count) {
    for (const auto& [f, s_m] : room.places(count * kUnit_m)) {
      const std::optional<Pose2> at = room.claim(f, s_m, {kDepth_m, count * kUnit_m}, 0.91);
      if (!at) {
        continue;
      }
      for (int k = 0; k < count; ++k) {
        const double along_m = (k - (count - 1) / 2.0) * kUnit_m;
        const Vec2 p = *at * Vec2(kSkirting_m + kDepth_m / 2 - 0.01, along_m);
        put(room.into(), units[static_cast<std::size_t>(k)], {p.x(), p.y(), at->theta_rad});
        const Rectangle over{{s_m + along_m - kUnit_m / 2 + 0.01, 1.45},
                             {s_m + along_m + kUnit_m / 2 - 0.01, 2.2}};
        if (k > 0 && room.face(f).is_clear(over)) {
          put(room.into(), above[static_cast<std::size_t>(room.rng().index(3))],
              room.face(f).at(s_m + along_m), 1.83);
          room.face(f).take(over);
        } else if (k == 0) {
          room.face(f).take({over.low - Vec2(0, 0.6), over.high});
        }
      }
      return;
    }
  }
}

/// A table with its end to the wall and two chairs on each side.
void stand_table(Furnisher& room) {
  constexpr double kChairs_m = 0.72;  // from the middle of the table
  const Vec2 size(1.48, 2 * kChairs_m + 0.48);
  for (const auto& [f, s_m] : room.places(size.y())) {
    const std::optional<Pose2> at = room.claim(f, s_m, size, 0.96);
    if (!at) {
      continue;
    }
    const Vec2 middle = *at * Vec2(kSkirting_m + 0.74, 0);
    put(room.into(), "home/table",
        {middle.x(), middle.y(), wrap_angle(at->theta_rad + kQuarter_rad)});
    int chairs = 0;
    for (const double side : {-1.0, 1.0}) {
      for (const double along_m : {-0.35, 0.35}) {
        const Vec2 p = *at * Vec2(kSkirting_m + 0.74 + along_m, side * kChairs_m);
        ObjectSettings& chair =
            put(room.into(), "home/chair",
                {p.x(), p.y(), wrap_angle(at->theta_rad - side * kQuarter_rad)});
        chair.name = fmt::format("kitchen-chair-{}", ++chairs);
        chair.movable = true;
      }
    }
    return;
  }
}

void furnish_bedroom(Furnisher& room) {
  for (const auto& [f, s_m] : room.places(kBed.size_m.y())) {
    if (!room.stand(kBed, f, s_m)) {
      continue;
    }
    for (const double side : {-1.0, 1.0}) {
      room.stand(kNightstand, f,
                 s_m + side * (kBed.size_m.y() + kNightstand.size_m.y() + 0.06) / 2);
    }
    const Pose2 at = room.face(f).at(s_m);
    const Vec2 rug = at * Vec2(kBed.size_m.x() + 0.5, 0);
    room.lay_rug("home/rug_b", {rug.x(), rug.y(), wrap_angle(at.theta_rad + kQuarter_rad)},
                 {1.8, 0.9});
    break;
  }
  room.stand(kWardrobe);
  room.stand(kDresser);
  room.stand(kBasket);
  room.stand(kPlant);
}

void furnish_study(Furnisher& room) {
  constexpr double kDesk_m = 0.80;
  constexpr double kChair_m = 0.56;
  const Vec2 size(kDesk_m + kChair_m, 1.62);
  for (const auto& [f, s_m] : room.places(size.y())) {
    const std::optional<Pose2> at = room.claim(f, s_m, size, 0.9);
    if (!at) {
      continue;
    }
    const auto from_wall = [&at](double by_m, double across_m, double turn_rad = 0) {
      const Vec2 p = *at * Vec2(kSkirting_m + by_m, across_m);
      return Pose2{p.x(), p.y(), wrap_angle(at->theta_rad + turn_rad)};
    };
    put(room.into(), "office/desk", from_wall(kDesk_m / 2, 0));
    put(room.into(), "office/monitor", from_wall(0.24, 0.1), 0.74);
    put(room.into(), "office/keyboard", from_wall(0.56, 0.1), 0.74);
    put(room.into(), "office/book_pile", from_wall(0.4, -0.55), 0.74);
    put(room.into(), "office/chair", from_wall(kDesk_m + kChair_m / 2, 0, std::numbers::pi))
        .movable = true;
    break;
  }
  stand_shelves(room, 4);
  room.stand(kArmchair);
  room.stand(kBasket);
  room.stand(kPlant);
}

void furnish_bath(Furnisher& room) {
  room.stand(kTub);
  if (const auto at = room.stand(kBasin)) {
    hang(room.into(), room.face(at->first), {"home/mirror", {0.60, 0.80}}, at->second, 1.5);
  }
  room.stand(kToilet);
  room.stand(kWasher);
  room.stand(kBasket);
}

void furnish_kitchen(Furnisher& room) {
  stand_units(room);
  stand_table(room);
  room.stand(kBasket);
  room.stand(kPlant);
}

void furnish_hall(Furnisher& room) {
  room.stand(kShoes);
  room.stand(kShoes);
}

}  // namespace

std::vector<WallFace> faces_of(const Rectangle& area) {
  const Vec2 south_east(area.high.x(), area.low.y());
  const Vec2 north_west(area.low.x(), area.high.y());
  return {WallFace(south_east, area.low), WallFace(area.high, south_east),
          WallFace(north_west, area.high), WallFace(area.low, north_west)};
}

std::string wall_picture(RoomKind kind) {
  switch (kind) {
    case RoomKind::kHall:
    case RoomKind::kLiving:
      return "home/wallpaper_leaves";
    case RoomKind::kBedroom:
      return "home/wallpaper_stripes";
    case RoomKind::kStudy:
      return "home/wallpaper_retro";
    case RoomKind::kKitchen:
    case RoomKind::kBath:
      break;
  }
  return "home/wall_tiles";
}

std::string floor_picture(RoomKind kind) {
  return kind == RoomKind::kKitchen || kind == RoomKind::kBath ? "home/floor_tiles"
                                                               : "home/parquet";
}

void furnish(WorldSettings& into, HomeRoom room, PassabilityGrid& passability, Rng rng) {
  Furnisher furnisher(into, room, passability, rng);
  furnisher.put_ceiling_lamps();
  furnisher.put_windows();
  switch (room.kind) {
    case RoomKind::kHall:
      furnish_hall(furnisher);
      break;
    case RoomKind::kLiving:
      furnish_living(furnisher);
      break;
    case RoomKind::kKitchen:
      furnish_kitchen(furnisher);
      break;
    case RoomKind::kBedroom:
      furnish_bedroom(furnisher);
      break;
    case RoomKind::kStudy:
      furnish_study(furnisher);
      break;
    case RoomKind::kBath:
      furnish_bath(furnisher);
      break;
  }
  furnisher.strew(room.clutter);
  furnisher.leave_bare();
  furnisher.hang_things();
}

}  // namespace panoptes::sim

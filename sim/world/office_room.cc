// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/office_room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

using Pictures = std::map<std::string, std::string>;

// As the meshes are (assets/furniture.py), sizes ahead and to the left.
const Vec2 kDesk_m(0.80, 1.60);
const Vec2 kShelf_m(0.36, 0.90);
const Vec2 kCupboard_m(0.42, 0.90);
const Vec2 kBoxes_m(0.42, 0.58);
const Vec2 kPlant_m(0.42, 0.42);
constexpr double kDeskHeight_m = 0.74;
constexpr double kChairDepth_m = 0.52;
constexpr double kChairOut_m = 0.28;   // of its desk
constexpr double kPartition_m = 0.04;  // between desks back to back
constexpr double kBlockDepth_m = 2 * (0.80 + kChairOut_m) + kPartition_m;
constexpr double kAlongWalls_m = 0.44;  // cupboards and what else stands at the walls
constexpr int kMostInARow = 3;          // desks side by side in a block
constexpr double kBandedWindow_m = 2.1;
constexpr int kPlates = 40;
constexpr int kSheets = 16;

constexpr double kQuarter_rad = std::numbers::pi / 2;

/// How the blocks of desks fill a room: rows of blocks, `columns` pairs of desks in each row.
struct Grid {
  bool turned = false;  ///< the rows run along y
  int rows = 0;
  int columns = 0;
  int blocks = 0;  ///< in a row

  int desks() const { return 2 * rows * columns; }
};

double inside_m(double wall_to_wall_m) {
  return wall_to_wall_m - 2 * (kAlongWalls_m + kOfficeAisle_m);
}

Grid grid_for(const Vec2& size_m, bool turned) {
  const double along_m = inside_m(turned ? size_m.y() : size_m.x());
  const double across_m = inside_m(turned ? size_m.x() : size_m.y());
  Grid grid;
  grid.turned = turned;
  grid.rows =
      std::max(0, static_cast<int>((across_m + kOfficeAisle_m) / (kBlockDepth_m + kOfficeAisle_m)));
  for (int blocks = 1; along_m > 0; ++blocks) {
    const double left_m = along_m - (blocks - 1) * kOfficeAisle_m;
    if (left_m < blocks * kDesk_m.y()) {
      break;
    }
    const int columns = std::min(kMostInARow * blocks, static_cast<int>(left_m / kDesk_m.y()));
    if (columns > grid.columns) {
      grid.columns = columns;
      grid.blocks = blocks;
    }
  }
  return grid;
}

/// Shares `slack_m` out among `count` gaps by chance.
std::vector<double> shared_out(double slack_m, int count, Rng& rng) {
  std::vector<double> parts(static_cast<std::size_t>(count));
  double sum = 0;
  for (double& part : parts) {
    part = rng.uniform(0.05, 1);
    sum += part;
  }
  for (double& part : parts) {
    part *= slack_m / sum;
  }
  return parts;
}

class Furnisher {
 public:
  Furnisher(WorldSettings& into, OfficeRoom room, const Rng& rng)
      : into_(into),
        room_(std::move(room)),
        rng_(rng.fork("furniture")),
        floor_(room_.low, room_.high),
        is_bare_(room_.texture <= 0) {
    for (const Rectangle& free : room_.kept_free) {
      floor_.take(free);
    }
  }

  void everything() {
    floor_and_ceiling();
    windows();
    along_the_walls();
    desks();
    Rng hanging = rng_.fork("walls");
    for (WallFace& face : room_.faces) {
      put_skirting(into_, face);
      dress(into_, face, room_.texture, hanging);
    }
  }

 private:
  bool chance(double share) { return rng_.uniform() < share; }

  /// The textures of an object, or plain paint.
  Pictures dressed(const Pictures& pictures, const Pictures& plain) const {
    return is_bare_ ? plain : pictures;
  }

  void floor_and_ceiling() {
    const Vec2& low = room_.low;
    const Vec2& high = room_.high;
    if (is_bare_) {
      put_floor(into_, low, high, "office/floor_plain", 1);
    } else {  // two carpets
      const double seam_m = low.x() + (high.x() - low.x()) * rng_.uniform(0.3, 0.7);
      const bool sand_first = rng_.index(2) == 0;
      const std::array<const char*, 2> carpets{"office/carpet_sand", "office/carpet_blue"};
      put_floor(into_, low, {seam_m, high.y()}, carpets[sand_first ? 0 : 1], 2);
      put_floor(into_, {seam_m, low.y()}, high, carpets[sand_first ? 1 : 0], 2);
    }
    put_ceiling(into_, low, high, is_bare_ ? "office/wall_plain" : "office/ceiling");
    put_lamps(into_, low, high, 2.9, 1.2);
  }

  void windows() {
    std::size_t longest = 0;
    for (std::size_t i = 1; i < room_.faces.size(); ++i) {
      if (room_.faces[i].length_m() > room_.faces[longest].length_m() + 1e-9) {
        longest = i;
      }
    }
    WallFace& face = room_.faces[longest];
    const int count = static_cast<int>((face.length_m() - 0.6) / kBandedWindow_m);
    for (int k = 0; k < count; ++k) {
      const double s_m = face.length_m() * (k + 0.5) / count;
      put_window(
          into_, face, s_m, 1.1,
          is_bare_ ? "office/plain_grey" : std::string("office/window_") + "abcd"[rng_.index(4)]);
    }
  }

  void plate(const Pose2& at, double z_m) {
    if (!is_bare_ && plates_ < kPlates && chance(room_.texture)) {
      put(into_, fmt::format("office/plate_{:02}", ++plates_), at, z_m);
    }
  }
  void sheet(const Pose2& at, double z_m) {
    if (!is_bare_ && chance(room_.texture)) {
      put(into_, fmt::format("office/sheet_{:02}", 1 + rng_.index(kSheets)), at, z_m);
    }
  }

  void shelf(const Pose2& at) {
    if (is_bare_) {
      cupboard(at, true);
      return;
    }
    static constexpr std::array<const char*, 3> kWoods{"office/wood_shelf", "office/wood_dark",
                                                       "office/laminate"};
    put(into_, fmt::format("office/shelf_{}", 1 + rng_.index(5)), at, 0,
        {{"books", rng_.index(2) == 0 ? "office/books_a" : "office/books_b"},
         {"wood", one_of(kWoods, rng_)}});
    plate(at * Pose2{kShelf_m.x() / 2 - 0.002, 0, 0}, 1.80);
  }

  void cupboard(const Pose2& at, bool tall) {
    const int kind = tall ? rng_.index(4) : rng_.index(2);
    static constexpr std::array<const char*, 4> kSides{"office/wood_shelf", "office/laminate",
                                                       "office/plain_steel", "office/wood_shelf"};
    put(into_, tall ? "office/cupboard_tall" : "office/cupboard_low", at, 0,
        dressed({{"front", std::string("office/cupboard_") + "abcd"[kind]},
                 {"side", kSides[static_cast<std::size_t>(kind)]}},
                {{"front", "office/plain_white"}, {"side", "office/plain_grey"}}));
    if (tall) {
      const double front_m = kCupboard_m.x() / 2 - 0.0005;
      plate(at * Pose2{front_m, 0.22, 0}, 1.42);
      sheet(at * Pose2{front_m, -0.2, 0}, rng_.uniform(1.35, 1.55));
    }
  }

  /// Stands something of this size at a wall, its middle at s, if there is room; low things may
  /// stand under windows.
  bool at_wall(WallFace& face, double s_m, const Vec2& size_m, double height_m, Pose2& at) {
    const double out_m = kSkirting_m + size_m.x() / 2;
    at = face.at(s_m) * Pose2{out_m, 0, 0};
    const Rectangle behind{{s_m - size_m.y() / 2, 0}, {s_m + size_m.y() / 2, height_m}};
    const Rectangle outline = FloorSpace::outline(at, size_m);
    if (!face.is_clear(behind) || !floor_.is_clear(outline, 0.005)) {
      return false;
    }
    face.take(behind);
    floor_.take(outline);
    return true;
  }

  void along_the_walls() {
    Pose2 at;
    for (WallFace& face : room_.faces) {
      double s_m = rng_.uniform(0.2, 0.6);
      int run = 2 + rng_.index(3);  // things side by side, then a gap of bare wall
      while (s_m < face.length_m()) {
        const double gap_m = run == 0 ? rng_.uniform(0.7, 1.6) : 0.0;
        if (run == 0) {
          corner_thing(face, s_m + rng_.uniform(0.3, 0.5));
          run = 2 + rng_.index(3);
          s_m += gap_m;
          continue;
        }
        const double width_m = kShelf_m.y();
        const double middle_m = s_m + width_m / 2;
        const bool wants_shelf = rng_.uniform() < 0.55;
        if (at_wall(face, middle_m, wants_shelf ? kShelf_m : kCupboard_m, 2.14, at)) {
          wants_shelf ? shelf(at) : cupboard(at, true);
          --run;
        } else if (at_wall(face, middle_m, kCupboard_m, 0.85, at)) {  // under a window
          cupboard(at, false);
          --run;
        } else {
          s_m += 0.1;
          continue;
        }
        s_m += width_m;
      }
    }
  }

  /// What gathers where nothing else stands.
  void corner_thing(WallFace& face, double s_m) {
    Pose2 at;
    const int kind = rng_.index(4);
    if (kind == 0 && at_wall(face, s_m, kPlant_m, 0.9, at)) {
      put(into_, "office/plant", at);
    } else if (kind == 1 && at_wall(face, s_m, kBoxes_m, 0.9, at)) {
      put(into_, "office/boxes", at, 0, dressed({}, {{"card", "office/plain_wood"}}));
    } else if (kind == 2 && !is_bare_) {
      hang(into_, face, {"office/extinguisher", {0.16, 0.56}}, s_m, 1.1);
    }
  }

  void desks() {
    const Vec2 size_m = room_.high - room_.low;
    std::vector<Grid> fitting;
    for (const bool turned : {false, true}) {
      const Grid grid = grid_for(size_m, turned);
      if (grid.desks() >= room_.desks && grid.rows > 0) {
        fitting.push_back(grid);
      }
    }
    if (room_.desks == 0 || fitting.empty()) {
      PANOPTES_CHECK(room_.desks == 0, "not more desks than fit");
      return;
    }
    const Grid grid = one_of(fitting, rng_);
    const double along_m = inside_m(grid.turned ? size_m.y() : size_m.x());
    const double across_m = inside_m(grid.turned ? size_m.x() : size_m.y());
    const std::vector<int> seats = seats_of(grid);
    const std::vector<double> between_rows =
        shared_out(across_m - grid.rows * kBlockDepth_m - (grid.rows - 1) * kOfficeAisle_m,
                   grid.rows + 1, rng_);
    // Row coordinates: s along the row, t across, from the corner of what the aisle along the walls
    // leaves.
    const Vec2 corner = room_.low + Vec2(1, 1) * (kAlongWalls_m + kOfficeAisle_m);
    const auto place = [&](double s_m, double t_m, double theta_rad) {
      return grid.turned ? Pose2{corner.x() + t_m, corner.y() + s_m, kQuarter_rad - theta_rad}
                         : Pose2{corner.x() + s_m, corner.y() + t_m, theta_rad};
    };
    double t_m = 0;
    std::size_t seat = 0;
    for (int row = 0; row < grid.rows; ++row) {
      t_m += between_rows[static_cast<std::size_t>(row)];
      const double middle_m = t_m + kBlockDepth_m / 2;
      const std::vector<double> between_blocks =
          shared_out(along_m - grid.columns * kDesk_m.y() - (grid.blocks - 1) * kOfficeAisle_m,
                     grid.blocks + 1, rng_);
      double s_m = 0;
      for (int block = 0; block < grid.blocks; ++block) {
        s_m += between_blocks[static_cast<std::size_t>(block)];
        const int columns = (grid.columns + grid.blocks - 1 - block) / grid.blocks;
        const char wood = "ab"[rng_.index(2)];
        for (int k = 0; k < columns; ++k) {
          const double s_middle_m = s_m + kDesk_m.y() / 2;
          pair_of_desks(seats[seat++], wood, [&](double ahead_m, double theta_rad) {
            return place(s_middle_m, middle_m + ahead_m, theta_rad);
          });
          s_m += kDesk_m.y();
        }
        s_m += kOfficeAisle_m;
      }
      t_m += kBlockDepth_m + kOfficeAisle_m;
    }
  }

  /// How many desks, 0 to 2, stand in each place for a pair.
  std::vector<int> seats_of(const Grid& grid) {
    std::vector<int> seats(static_cast<std::size_t>(grid.rows * grid.columns), 0);
    std::vector<std::size_t> order(seats.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
      std::swap(order[i], order[static_cast<std::size_t>(rng_.index(static_cast<int>(i) + 1))]);
    }
    int left = room_.desks;
    for (const std::size_t i : order) {
      seats[i] = std::min(left, 2);
      left -= seats[i];
    }
    return seats;
  }

  /// Two desks back to back with a screen between them; `at` is a place so far across the middle.
  template <class At>
  void pair_of_desks(int count, char wood, const At& at) {
    if (count == 0) {
      if (chance(0.5)) {  // bookcases back to back stand there instead
        shelf(at(-kShelf_m.x() / 2 - 0.005, -kQuarter_rad));
        shelf(at(kShelf_m.x() / 2 + 0.005, kQuarter_rad));
      }
      return;
    }
    for (int k = 0; k < count; ++k) {
      const double side = k == 0 ? -1 : 1;
      desk(at(side * (kPartition_m + kDesk_m.x()) / 2, side * kQuarter_rad), wood);
    }
    put(into_, "office/partition", at(0, kQuarter_rad), 0,
        dressed({{"fabric", std::string("office/partition_") + "ab"[rng_.index(2)]}},
                {{"fabric", "office/plain_grey"}}));
  }

  void desk(const Pose2& at, char wood) {
    const std::string kind(1, wood);
    put(into_, room_.overhangs ? "office/desk_legs" : "office/desk", at, 0,
        dressed({{"top", std::string("office/desk_top_") + "ab"[rng_.index(2)]},
                 {"front", "office/desk_front_" + kind},
                 {"side", "office/desk_side_" + kind}},
                {{"top", "office/plain_wood"},
                 {"front", "office/plain_grey"},
                 {"side", "office/plain_grey"}}));
    const double out_m = kDesk_m.x() / 2 + kChairOut_m - rng_.uniform(0, 0.04) - kChairDepth_m / 2;
    const char* const fabric = rng_.uniform() < 0.2 ? "office/chair_red" : "office/chair_blue";
    put(into_, room_.overhangs ? "office/chair_star" : "office/chair",
        at * Pose2{out_m, rng_.uniform(-0.02, 0.02), std::numbers::pi}, 0,
        room_.overhangs ? dressed({{"fabric", fabric}}, {{"fabric", "office/plain_blue"}})
                        : dressed({{"fabric", fabric}}, {{"fabric", "office/plain_blue"},
                                                         {"skirt", "office/plain_grey"}}));
    const bool two_screens = rng_.uniform() < 0.25;
    for (const double side_m : two_screens ? std::vector<double>{-0.32, 0.32}
                                           : std::vector<double>{rng_.uniform(-0.1, 0.1)}) {
      const std::string picture = fmt::format("office/screen_{}", 1 + rng_.index(6));
      put(into_, "office/monitor", at * Pose2{-0.17, side_m, rng_.uniform(-0.2, 0.2)},
          kDeskHeight_m,
          dressed({{"screen", picture}},
                  {{"screen", "office/plain_blue"}, {"back", "office/plain_grey"}}));
    }
    put(into_, "office/keyboard",
        at * Pose2{0.18, rng_.uniform(-0.06, 0.06), rng_.uniform(-0.1, 0.1)}, kDeskHeight_m);
    for (const auto& [mesh, side_m] :
         {std::pair("office/phone", -0.52), {"office/mug", 0.38}, {"office/book_pile", 0.60}}) {
      const Pose2 there = at * Pose2{rng_.uniform(-0.12, 0.2), side_m + rng_.uniform(-0.06, 0.06),
                                     rng_.uniform(-0.4, 0.4)};
      if (chance(0.65 * room_.texture)) {
        put(into_, mesh, there, kDeskHeight_m);
      }
    }
    if (!room_.overhangs) {
      for (const double side : {-1.0, 1.0}) {  // on its ends, where they are seen
        const Pose2 end = at * Pose2{0, side * (kDesk_m.y() / 2 - 0.0205), side * kQuarter_rad};
        plate_or_sheet(end);
      }
    }
  }

  void plate_or_sheet(const Pose2& at) {
    if (rng_.index(2) == 0) {
      plate(at * Pose2{0, 0.15, 0}, 0.58);
    } else {
      sheet(at * Pose2{0, -0.1, 0}, 0.44);
    }
  }

  WorldSettings& into_;
  OfficeRoom room_;
  Rng rng_;
  FloorSpace floor_;
  bool is_bare_;
  int plates_ = 0;
};

}  // namespace

int most_desks(const Vec2& size_m) {
  return std::max(grid_for(size_m, false).desks(), grid_for(size_m, true).desks());
}

void furnish(WorldSettings& into, OfficeRoom room, const Rng& rng) {
  Furnisher(into, std::move(room), rng).everything();
}

const char* office_wall(double texture) {
  return texture > 0 ? "office/wall" : "office/wall_plain";
}

}  // namespace panoptes::sim

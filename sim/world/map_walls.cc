// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/map_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <utility>

namespace panoptes::sim {
namespace {

using Mask = Grid2<std::uint8_t>;

constexpr double kSpeck_m2 = 0.02;
constexpr double kSlit_m = 0.3;
constexpr double kFarClearance_m = 1.5;
// A doorway is up to 1 m wide; rooms whose middles are no wider than that belong to a neighbour.
constexpr double kHalfDoorway_m = 0.5;
constexpr double kLeastRoom_m2 = 0.5;  // of the floor that is left of it with its doorways shut
// What stairs and noise of a scan are off a straight wall; coarse cells are meant as they are.
constexpr double kFaceOff_cells = 1.0;
constexpr double kFaceOff_m = 0.06;
constexpr double kFilled_m = 0.2;  // blocks of this raster fill what is no floor

constexpr std::array<std::array<int, 2>, 4> kBeside{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
constexpr std::array<std::array<int, 2>, 8> kAround{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

/// The cells that hang together with one of them, by those steps, as long as `belongs`.
template <class Steps, class Belongs>
std::vector<std::size_t> piece_at(const Mask& grid, int column, int row, const Steps& steps,
                                  std::vector<std::uint8_t>& visited, const Belongs& belongs) {
  std::vector<std::size_t> piece{grid.index(column, row)};
  visited[piece.front()] = 1;
  for (std::size_t k = 0; k < piece.size(); ++k) {
    const int c = static_cast<int>(piece[k]) % grid.columns;
    const int r = static_cast<int>(piece[k]) / grid.columns;
    for (const auto& [dc, dr] : steps) {
      if (!grid.contains(c + dc, r + dr)) {
        continue;
      }
      const std::size_t next = grid.index(c + dc, r + dr);
      if (visited[next] == 0 && belongs(next)) {
        visited[next] = 1;
        piece.push_back(next);
      }
    }
  }
  return piece;
}

template <class Steps, class Belongs, class Use>
void for_each_piece(const Mask& grid, const Steps& steps, const Belongs& belongs, const Use& use) {
  std::vector<std::uint8_t> visited(grid.cells.size(), 0);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const std::size_t here = grid.index(column, row);
      if (visited[here] == 0 && belongs(here)) {
        use(piece_at(grid, column, row, steps, visited, belongs));
      }
    }
  }
}

/// Unknown cells among free ones: rays of a scanner that passed on both sides.
void close_rays(const OccupancyMap& map, Mask& floor) {
  constexpr int kRounds = 3;
  constexpr int kMostOfEight = 5;
  for (int round = 0; round < kRounds; ++round) {
    const Mask before = floor;
    for (int row = 1; row + 1 < floor.rows; ++row) {
      for (int column = 1; column + 1 < floor.columns; ++column) {
        if (before(column, row) != 0 || map.at(column - 1, row - 1) != Cell::kUnknown) {
          continue;
        }
        int free = 0;
        for (const auto& [dc, dr] : kAround) {
          free += before(column + dc, row + dr);
        }
        floor(column, row) = free >= kMostOfEight ? 1 : 0;
      }
    }
  }
}

void drop_specks(Mask& floor) {
  const auto most = static_cast<std::size_t>(kSpeck_m2 / (floor.cell_m * floor.cell_m));
  const Mask before = floor;
  for_each_piece(
      before, kAround, [&before](std::size_t at) { return before.cells[at] == 0; },
      [&](const std::vector<std::size_t>& piece) {
        if (piece.size() < most) {
          for (const std::size_t at : piece) {
            floor.cells[at] = 1;
          }
        }
      });
}

/// Whether all cells of a square with that corner are floor, by sums over rectangles.
class Sums {
 public:
  explicit Sums(const Mask& mask) : columns_(mask.columns + 1) {
    sums_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(mask.rows + 1), 0);
    for (int row = 0; row < mask.rows; ++row) {
      for (int column = 0; column < mask.columns; ++column) {
        at(column + 1, row + 1) = at(column, row + 1) + at(column + 1, row) - at(column, row) +
                                  (mask(column, row) != 0 ? 1 : 0);
      }
    }
  }
  int over(int column, int row, int end_column, int end_row) {
    return at(end_column, end_row) - at(column, end_row) - at(end_column, row) + at(column, row);
  }

 private:
  int& at(int column, int row) {
    return sums_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                 static_cast<std::size_t>(column)];
  }
  int columns_;
  std::vector<int> sums_;
};

/// What a square of that side covers where it lies on floor alone.
Mask opened(const Mask& floor, int side) {
  Sums sums(floor);
  Mask out = floor;
  std::fill(out.cells.begin(), out.cells.end(), std::uint8_t{0});
  for (int row = 0; row + side <= floor.rows; ++row) {
    for (int column = 0; column + side <= floor.columns; ++column) {
      if (sums.over(column, row, column + side, row + side) != side * side) {
        continue;
      }
      for (int r = row; r < row + side; ++r) {
        for (int c = column; c < column + side; ++c) {
          out(c, r) = 1;
        }
      }
    }
  }
  return out;
}

void keep_largest(Mask& floor) {
  std::vector<std::size_t> largest;
  for_each_piece(
      floor, kBeside, [&floor](std::size_t at) { return floor.cells[at] != 0; },
      [&largest](std::vector<std::size_t> piece) {
        if (piece.size() > largest.size()) {
          largest = std::move(piece);
        }
      });
  std::fill(floor.cells.begin(), floor.cells.end(), std::uint8_t{0});
  for (const std::size_t at : largest) {
    floor.cells[at] = 1;
  }
}

/// How far each cell of floor is from one that is none, its middle from that one's nearest side.
Grid2<float> clearance_of(const Mask& floor) {
  const int reach = static_cast<int>(std::ceil(kFarClearance_m / floor.cell_m));
  auto clearance = transformed(floor, [](std::uint8_t is_floor) {
    return is_floor != 0 ? static_cast<float>(kFarClearance_m) : 0.0F;
  });
  for (int row = 0; row < floor.rows; ++row) {
    for (int column = 0; column < floor.columns; ++column) {
      const auto is_edge = [&](const std::array<int, 2>& step) {
        return floor.at(column + step[0], row + step[1]) != 0;
      };
      if (floor(column, row) != 0 || std::none_of(kBeside.begin(), kBeside.end(), is_edge)) {
        continue;
      }
      for (int r = std::max(0, row - reach); r <= std::min(floor.rows - 1, row + reach); ++r) {
        for (int c = std::max(0, column - reach); c <= std::min(floor.columns - 1, column + reach);
             ++c) {
          const Vec2 off(std::max(0.0, std::abs(c - column) - 0.5),
                         std::max(0.0, std::abs(r - row) - 0.5));
          float& there = clearance(c, r);
          there = std::min(there, static_cast<float>(off.norm() * floor.cell_m));
        }
      }
    }
  }
  return clearance;
}

Grid2<std::uint16_t> rooms_of(const Mask& floor, const Grid2<float>& clearance_m) {
  auto room = transformed(floor, [](std::uint8_t) { return std::uint16_t{0}; });
  const auto least = static_cast<std::size_t>(kLeastRoom_m2 / (floor.cell_m * floor.cell_m));
  std::uint16_t rooms = 0;
  std::deque<std::size_t> open;
  for_each_piece(
      floor, kBeside, [&](std::size_t at) { return clearance_m.cells[at] > kHalfDoorway_m; },
      [&](const std::vector<std::size_t>& piece) {
        if (piece.size() < least || rooms == 0xffff) {
          return;
        }
        ++rooms;
        for (const std::size_t at : piece) {
          room.cells[at] = rooms;
          open.push_back(at);
        }
      });
  while (!open.empty()) {  // the rest belongs to the nearest one
    const std::size_t at = open.front();
    open.pop_front();
    const int c = static_cast<int>(at) % floor.columns;
    const int r = static_cast<int>(at) / floor.columns;
    for (const auto& [dc, dr] : kBeside) {
      if (floor.at(c + dc, r + dr) != 0 && room(c + dc, r + dr) == 0) {
        room(c + dc, r + dr) = room.cells[at];
        open.push_back(room.index(c + dc, r + dr));
      }
    }
  }
  return room;
}

/// A corner of cells, and of the faces between them.
using Corner2 = std::array<int, 2>;

/// The outlines of the floor, which lies to their left: closed, a corner wherever they turn. Where
/// two cells of floor touch at a corner alone, the walls meet there.
std::vector<std::vector<Corner2>> outlines_of(const Mask& floor) {
  // Of each corner, which of the four ways along +x, +y, -x, -y have floor to the left and none to
  // the right.
  const auto is_side = [&floor](int column, int row, int way) {
    switch (way) {
      case 0:
        return floor.at(column, row) != 0 && floor.at(column, row - 1) == 0;
      case 1:
        return floor.at(column - 1, row) != 0 && floor.at(column, row) == 0;
      case 2:
        return floor.at(column - 1, row - 1) != 0 && floor.at(column - 1, row) == 0;
      default:
        return floor.at(column, row - 1) != 0 && floor.at(column - 1, row - 1) == 0;
    }
  };
  Grid2<std::uint8_t> done;
  done.assign(floor.columns + 1, floor.rows + 1);
  std::vector<std::vector<Corner2>> all;
  for (int row = 0; row < done.rows; ++row) {
    for (int column = 0; column < done.columns; ++column) {
      // Every outline has a side along +x that begins at a corner of its own.
      if ((done(column, row) & 1) != 0 || !is_side(column, row, 0)) {
        continue;
      }
      std::vector<Corner2> outline;
      int c = column;
      int r = row;
      int way = 0;
      int came = -1;
      while ((done(c, r) & (1 << way)) == 0) {
        if (way != came) {
          outline.push_back({c, r});
        }
        done(c, r) = static_cast<std::uint8_t>(done(c, r) | (1 << way));
        c += kBeside[static_cast<std::size_t>(way)][0];
        r += kBeside[static_cast<std::size_t>(way)][1];
        came = way;
        for (const int turn : {1, 0, 3}) {  // left first: around the same cell
          if (is_side(c, r, (came + turn) % 4)) {
            way = (came + turn) % 4;
            break;
          }
        }
      }
      if (way == came && outline.size() > 1) {
        outline.erase(outline.begin());  // it began in the middle of a side
      }
      all.push_back(std::move(outline));
    }
  }
  return all;
}

double off_line(const Vec2& p, const Vec2& from, const Vec2& to) {
  const Vec2 along = to - from;
  const double length = along.norm();
  if (length < 1e-9) {
    return (p - from).norm();
  }
  const double s = std::clamp(along.dot(p - from) / (length * length), 0.0, 1.0);
  return (p - from - s * along).norm();
}

/// Douglas and Peucker's: the corners between `first` and `last` that cannot be left out.
void keep_corners(const std::vector<Vec2>& all, std::size_t first, std::size_t last, double off,
                  std::vector<std::uint8_t>& kept) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{first, last}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double most = off;
    std::size_t farthest = a;
    for (std::size_t k = a + 1; k < b; ++k) {
      const double here = off_line(all[k], all[a], all[b % all.size()]);
      if (here > most) {
        most = here;
        farthest = k;
      }
    }
    if (farthest != a) {
      kept[farthest] = 1;
      open.emplace_back(a, farthest);
      open.emplace_back(farthest, b);
    }
  }
}

std::vector<Vec2> simplified(const std::vector<Vec2>& outline, double cell_m) {
  const double off = std::min(kFaceOff_cells, kFaceOff_m / cell_m);
  const auto farthest_from = [&outline](std::size_t k) {
    std::size_t farthest = k;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      if ((outline[i] - outline[k]).norm() > (outline[farthest] - outline[k]).norm()) {
        farthest = i;
      }
    }
    return farthest;
  };
  const std::size_t a = farthest_from(0);
  const std::size_t b = farthest_from(a);
  std::vector<Vec2> turned(outline);  // so that it begins at one of two corners far apart
  std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(a), turned.end());
  const std::size_t middle = (b + outline.size() - a) % outline.size();
  std::vector<std::uint8_t> kept(turned.size(), 0);
  kept[0] = kept[middle] = 1;
  keep_corners(turned, 0, middle, off, kept);
  keep_corners(turned, middle, turned.size(), off, kept);
  std::vector<Vec2> corners;
  for (std::size_t k = 0; k < turned.size(); ++k) {
    if (kept[k] != 0) {
      corners.push_back(turned[k]);
    }
  }
  return corners.size() >= 3 ? corners : outline;  // a thin post keeps its own
}

/// Blocks of wall in the raster of kFilled_m, each cell of which is a cell or more away from floor.
std::vector<std::array<int, 4>> solid_of(const Mask& floor) {
  const int step = std::max(1, static_cast<int>(std::lround(kFilled_m / floor.cell_m)));
  Sums sums(floor);
  Mask filled;
  filled.assign((floor.columns + step - 1) / step, (floor.rows + step - 1) / step);
  const auto end = [step](int at, int count) { return std::min(count, (at + 1) * step); };
  for (int row = 0; row < filled.rows; ++row) {
    for (int column = 0; column < filled.columns; ++column) {
      filled(column, row) = sums.over(std::max(0, column * step - 1), std::max(0, row * step - 1),
                                      std::min(floor.columns, end(column, floor.columns) + 1),
                                      std::min(floor.rows, end(row, floor.rows) + 1)) == 0
                                ? 1
                                : 0;
    }
  }
  std::vector<std::array<int, 4>> blocks;
  for (int row = 0; row < filled.rows; ++row) {
    for (int column = 0; column < filled.columns; ++column) {
      if (filled(column, row) == 0) {
        continue;
      }
      int end_column = column;
      while (filled.at(end_column, row) != 0) {
        ++end_column;
      }
      int end_row = row;
      const auto is_full = [&](int r) {
        for (int c = column; c < end_column; ++c) {
          if (filled.at(c, r) == 0) {
            return false;
          }
        }
        return true;
      };
      while (is_full(end_row)) {
        for (int c = column; c < end_column; ++c) {
          filled(c, end_row) = 0;
        }
        ++end_row;
      }
      blocks.push_back({column * step, row * step, end(end_column - 1, floor.columns),
                        end(end_row - 1, floor.rows)});
    }
  }
  return blocks;
}

}  // namespace

MapWalls walls_of_map(const OccupancyMap& map) {
  MapWalls walls;
  Mask& floor = walls.floor;
  floor.cell_m = map.cell_m;
  floor.origin = map.origin - Vec2(map.cell_m, map.cell_m);
  floor.assign(map.columns + 2, map.rows + 2);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      floor(column + 1, row + 1) = map(column, row) == Cell::kFree ? 1 : 0;
    }
  }
  close_rays(map, floor);
  drop_specks(floor);
  floor = opened(floor, std::max(1, static_cast<int>(std::lround(kSlit_m / map.cell_m))));
  keep_largest(floor);
  drop_specks(floor);
  walls.clearance_m = clearance_of(floor);
  walls.room = rooms_of(floor, walls.clearance_m);
  for (const std::vector<Corner2>& outline : outlines_of(floor)) {
    std::vector<Vec2> corners;
    corners.reserve(outline.size());
    for (const auto& [column, row] : outline) {
      corners.emplace_back(column, row);
    }
    corners = simplified(corners, floor.cell_m);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec2& from = corners[k];
      const Vec2& to = corners[(k + 1) % corners.size()];
      const Vec2 along = (to - from).normalized();
      const Vec2 before = (from + to) / 2 + 2 * Vec2(-along.y(), along.x());
      MapWalls::Face face{floor.point(from.x(), from.y()), floor.point(to.x(), to.y()), 0};
      face.room = walls.room.at(static_cast<int>(std::floor(before.x())),
                                static_cast<int>(std::floor(before.y())));
      walls.faces.push_back(face);
    }
  }
  walls.solid = solid_of(floor);
  return walls;
}

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/map_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <utility>

#include <opencv2/imgproc.hpp>

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

/// The same cells, for OpenCV.
cv::Mat1b picture_of(Mask& mask) { return {mask.rows, mask.columns, mask.cells.data()}; }

/// Pieces of what is not 0 in a picture, from 1, and how many cells each has.
struct Pieces {
  cv::Mat1i piece;
  std::vector<std::size_t> cells;  ///< by piece; that of 0 is what belongs to none
};

Pieces pieces_of(const cv::Mat1b& picture, int neighbours) {
  Pieces out;
  cv::Mat1i stats;
  cv::Mat1d centroids;
  const int count =
      cv::connectedComponentsWithStats(picture, out.piece, stats, centroids, neighbours, CV_32S);
  for (int k = 0; k < count; ++k) {
    out.cells.push_back(static_cast<std::size_t>(stats(k, cv::CC_STAT_AREA)));
  }
  return out;
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
  const Pieces walls = pieces_of(picture_of(floor) == 0, 8);
  for (std::size_t at = 0; at < floor.cells.size(); ++at) {
    if (floor.cells[at] == 0 &&
        walls.cells[static_cast<std::size_t>(walls.piece.begin()[static_cast<int>(at)])] < most) {
      floor.cells[at] = 1;
    }
  }
}

/// Keeps what a square of that side covers where it lies on floor alone.
void fill_slits(Mask& floor, int side) {
  const cv::Mat1b square = cv::Mat1b::ones(side, side);
  cv::Mat1b picture = picture_of(floor);
  cv::erode(picture, picture, square, {0, 0});
  cv::dilate(picture, picture, square, {side - 1, side - 1});
}

void keep_largest(Mask& floor) {
  const Pieces pieces = pieces_of(picture_of(floor), 4);
  const auto largest = std::max_element(pieces.cells.begin() + 1, pieces.cells.end());
  if (largest != pieces.cells.end()) {
    const auto piece = static_cast<int>(largest - pieces.cells.begin());
    cv::Mat1b(pieces.piece == piece).copyTo(picture_of(floor));
    picture_of(floor) &= 1;
  }
}

/// How far the middle of each cell of floor is from the side of the nearest one that is none.
Grid2<float> clearance_of(Mask& floor) {
  auto clearance = transformed(floor, [](std::uint8_t) { return 0.0F; });
  cv::Mat1f distance(floor.rows, floor.columns, clearance.cells.data());
  cv::distanceTransform(picture_of(floor), distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  for (float& cells : clearance.cells) {
    const double clear_m = (static_cast<double>(cells) - 0.5) * floor.cell_m;
    cells = static_cast<float>(std::clamp(clear_m, 0.0, kFarClearance_m));
  }
  return clearance;
}

Grid2<std::uint16_t> rooms_of(const Mask& floor, Grid2<float>& clearance_m) {
  auto room = transformed(floor, [](std::uint8_t) { return std::uint16_t{0}; });
  const auto least = static_cast<std::size_t>(kLeastRoom_m2 / (floor.cell_m * floor.cell_m));
  const Pieces middles =
      pieces_of(cv::Mat1f(floor.rows, floor.columns, clearance_m.cells.data()) > kHalfDoorway_m, 4);
  std::vector<std::uint16_t> number(middles.cells.size(), 0);
  std::uint16_t rooms = 0;
  for (std::size_t k = 1; k < number.size() && rooms < 0xffff; ++k) {
    number[k] = middles.cells[k] >= least ? ++rooms : std::uint16_t{0};
  }
  std::deque<std::size_t> open;
  for (std::size_t at = 0; at < room.cells.size(); ++at) {
    room.cells[at] = number[static_cast<std::size_t>(middles.piece.begin()[static_cast<int>(at)])];
    if (room.cells[at] != 0) {
      open.push_back(at);
    }
  }
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

/// With the corners left out that straight faces between the others do without (Douglas and
/// Peucker 1973).
std::vector<Vec2> simplified(const std::vector<Corner2>& outline, double cell_m) {
  std::vector<cv::Point2f> corners;
  for (const auto& [column, row] : outline) {
    corners.emplace_back(static_cast<float>(column), static_cast<float>(row));
  }
  std::vector<cv::Point2f> fewer;
  cv::approxPolyDP(corners, fewer, std::min(kFaceOff_cells, kFaceOff_m / cell_m), true);
  std::vector<Vec2> kept;
  for (const cv::Point2f& corner :
       fewer.size() >= 3 ? fewer : corners) {  // a thin post has its own
    kept.emplace_back(corner.x, corner.y);
  }
  return kept;
}

/// Blocks of wall in the raster of kFilled_m, each cell of which is a cell or more away from floor.
std::vector<std::array<int, 4>> solid_of(Mask& floor) {
  const int step = std::max(1, static_cast<int>(std::lround(kFilled_m / floor.cell_m)));
  cv::Mat1i sums;
  cv::integral(picture_of(floor), sums, CV_32S);
  Mask filled;
  filled.assign((floor.columns + step - 1) / step, (floor.rows + step - 1) / step);
  const auto end = [step](int at, int count) { return std::min(count, (at + 1) * step); };
  for (int row = 0; row < filled.rows; ++row) {
    for (int column = 0; column < filled.columns; ++column) {
      const int left = std::max(0, column * step - 1);
      const int low = std::max(0, row * step - 1);
      const int right = std::min(floor.columns, end(column, floor.columns) + 1);
      const int high = std::min(floor.rows, end(row, floor.rows) + 1);
      const int free = sums(high, right) - sums(high, left) - sums(low, right) + sums(low, left);
      filled(column, row) = free == 0 ? 1 : 0;
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
  fill_slits(floor, std::max(1, static_cast<int>(std::lround(kSlit_m / map.cell_m))));
  keep_largest(floor);
  drop_specks(floor);
  walls.clearance_m = clearance_of(floor);
  walls.room = rooms_of(floor, walls.clearance_m);
  for (const std::vector<Corner2>& outline : outlines_of(floor)) {
    const std::vector<Vec2> corners = simplified(outline, floor.cell_m);
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

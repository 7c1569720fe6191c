// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/lattice2.h"
#include "core/geometry/pose2.h"
#include "core/map/keyframe_grid.h"
#include "core/map/occupancy.h"

namespace panoptes {

/// A keyframe's grid where it lies in the frame of the map.
struct PlacedGrid {
  std::shared_ptr<const GridCrop> grid;
  Pose2 T_map_keyframe;
};

/// A map that has more cells takes more memory than a computer that drives has (3 GB while it is
/// made): 800 m a side with cells of 5 cm.
inline constexpr double kMostCells = 1 << 28;

/// What the body has traversed: floor, for the map of a place; for the local map,
/// where somebody may have stepped in behind it, evidence as any other.
enum class Traversed { kFree, kAsSeen };

/// Sums of evidence on a lattice that grows: cell (column, row) covers
/// cell_m * [column, column + 1) x [row, row + 1). Free and occupied are summed apart, so that a
/// thin obstacle does not drown in the free floor of a coarser cell.
class EvidenceSum {
 public:
  explicit EvidenceSum(double cell_m, Traversed traversed = Traversed::kFree);

  /// Throws ConfigError where the lattice would get more than kMostCells.
  void add(const PlacedGrid& placed);
  void subtract(const PlacedGrid& placed);  ///< undoes add() exactly

  double cell_m() const { return sums_.cell_m(); }
  OccupancyMap map() const;                                   ///< all there is
  OccupancyMap map(const Vec2& low, const Vec2& high) const;  ///< a window
  Cell at(int column, int row) const;

  struct Sum {
    std::int32_t free = 0;
    std::int32_t occupied = 0;
    std::int32_t traversed = 0;  ///< places of the body that the whole cell lay under
  };

 private:
  friend class LocalMap;
  template <int kSign>
  void apply(const PlacedGrid& placed);
  void drive_over(const PlacedGrid& placed, int sign);
  void reserve(const CellBox& asked);
  static Cell verdict(const Sum& sum, int parts);  // a side, of a grid's cells

  Traversed traversed_;
  double finer_m_ = 0.01;  // cell of the grids
  Lattice2<Sum> sums_;
};

/// Everything mapped so far; a keyframe that relaxation moved is taken out and put in again
/// exactly.
class GlobalMap {
 public:
  explicit GlobalMap(double cell_m);

  /// Keyframes are numbered as they are added.
  int add(std::shared_ptr<const GridCrop> grid, const Pose2& T_map_keyframe);

  /// Another grid for keyframe `keyframe`.
  void replace(int keyframe, std::shared_ptr<const GridCrop> grid);

  /// Notes where keyframes lie now. Those that moved by more than half a cell, or turned by more
  /// than that at their far edge, wait for refuse(); the others stay as they were fused.
  void move(std::span<const Pose2> T_map_keyframes);

  /// Fuses at most `keyframes_max` of the waiting ones again, oldest first; returns how many still
  /// wait.
  int refuse(int keyframes_max);

  int waiting() const { return static_cast<int>(waiting_.size()); }
  OccupancyMap map() const { return sum_.map(); }

  /// The map with one more grid, such as that of the open keyframe.
  OccupancyMap map_with(const PlacedGrid& open);

  const std::vector<PlacedGrid>& keyframes() const { return fused_; }

 private:
  EvidenceSum sum_;
  std::vector<PlacedGrid> fused_;
  std::vector<Pose2> wanted_;
  std::vector<int> waiting_;
};

/// One map of all the grids: made once, at the end of a run. Of cells twice as large, or four times
/// and so on, where it would have more than kMostCells.
OccupancyMap fuse(std::span<const PlacedGrid> grids, double cell_m);

/// The local map around the robot, which the driver uses: the last few keyframes and the open one,
/// in `odom`.
class LocalMap {
 public:
  LocalMap(double cell_m, double half_width_m, int keyframes);

  /// Takes the keyframe that was closed.
  void close(std::shared_ptr<const GridCrop> grid, const Pose2& T_odom_keyframe);

  /// Another grid for one that it may have.
  void replace(const std::shared_ptr<const GridCrop>& grid, std::shared_ptr<const GridCrop> by);

  /// The local map about the robot with the open keyframe as it is now.
  OccupancyMap map(const KeyframeGrid& open, const Pose2& T_odom_open, const Vec2& robot_odom);

  const std::vector<PlacedGrid>& keyframes() const { return closed_; }

 private:
  double half_width_m_;
  int keep_;
  EvidenceSum sum_;
  std::vector<PlacedGrid> closed_;
};

}  // namespace panoptes

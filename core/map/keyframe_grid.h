// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/lattice2.h"
#include "core/geometry/pose2.h"
#include "core/map/floor_mapper.h"

namespace panoptes {

/// Where a camera has been: the floor under it, how high it was, and what it looked at.
struct CameraPlace {
  Vec2 foot = Vec2::Zero();
  double height_m = 0;
  double heading_rad = 0;                        ///< of the middle of its view,
  double half_width_rad = std::numbers::pi / 2;  ///< which reaches so far to each side
};

/// Something stands here, at least this high.
struct StandingPoint {
  Vec2 p = Vec2::Zero();
  double height_m = 0;
};

/// The evidence of one keyframe, in its own frame, bounded to what was seen: row `r` holds cells
/// [rows[r].begin, rows[r].end) of lattice row `first_row + r`; lattice cell (column, row) covers
/// cell_m * [column, column + 1) x [row, row + 1). Eighths of a nat, positive is free.
struct GridCrop {
  struct Row {
    int begin = 0;
    int end = 0;
    std::size_t offset = 0;  ///< of `begin` in cells
  };
  double cell_m = 0.01;
  int first_row = 0;
  std::vector<Row> rows;
  std::vector<std::int8_t> cells;

  std::vector<Vec2> traversed;  ///< where the middle of the body has been,
  double body_radius_m = 0;     ///< and how far it reaches from there

  std::vector<CameraPlace> cameras;     ///< that saw all this, a few along the way
  std::vector<StandingPoint> standing;  ///< found on it
  std::vector<Vec2> proved_floor;       ///< places that proved to be floor: painted, or left again

  std::int8_t at(int column, int row) const;  ///< 0 outside
};

/// Takes out the floor that lies behind what stands, seen from where the crop's cameras looked at
/// it, whatever the pictures were taken to show: `standing`, in the crop's frame, hides it as far
/// as the line of sight over it, and `half_width_m` to each side, from `behind_m` behind it on.
/// What the body has driven over stays, and where it has been nothing stands. Returns whether there
/// was any such floor.
bool hide_behind(GridCrop& crop, std::span<const StandingPoint> standing,
                 double half_width_m = 0.05, double behind_m = 0);

/// Takes back what was called an obstacle: another floor has proved to be one, and may be what was
/// seen. Returns whether there was anything.
bool forget_obstacles(GridCrop& crop);

/// Takes back what was called an obstacle about places that proved to be floor, in the crop's
/// frame, where nothing stands near by. Returns whether there was anything.
bool forget_obstacles_on(GridCrop& crop, std::span<const Vec2> proved_floor);

/// The log-odds grid of the keyframe that is open: every reading of the floor is added to it. What
/// is seen again from nearly the same place is no new evidence: it can contradict, but not make
/// certain.
class KeyframeGrid {
 public:
  explicit KeyframeGrid(double cell_m = 0.01);

  /// `floor_camera`: which of the robot's floor cameras, counted from 0.
  void add(const FloorReading& reading, const Pose2& T_keyframe_body, int floor_camera = 0);

  /// Takes back what was called an obstacle.
  void forget_obstacles();

  void add_standing(const StandingPoint& point) { standing_.push_back(point); }

  void add_proved_floor(const Vec2& p_keyframe);

  /// The disc about `p_keyframe` is free: the body stands there, or it is assumed at the start.
  void add_free_disc(const Vec2& p_keyframe, double radius_m);

  /// The body is there, and the disc under it floor, whatever pictures say before or after.
  void add_body(const Vec2& p_keyframe, double radius_m);

  /// The disc about `p_keyframe` is occupied: something was touched there.
  void add_occupied_disc(const Vec2& p_keyframe, double radius_m);

  GridCrop crop() const;

 private:
  void reserve(const Vec2& low, const Vec2& high);
  void add_disc(const Vec2& p_keyframe, double radius_m, int evidence);

  Lattice2<std::int8_t> cells_;
  std::vector<Vec2> traversed_;
  double body_radius_m_ = 0;
  std::vector<CameraPlace> cameras_;
  std::vector<StandingPoint> standing_;
  std::map<std::pair<int, int>, Vec2> proved_floor_;  // one a cell of kProvedStep_m
  // Where the last independent reading was taken.
  std::map<int, Pose2> T_keyframe_last_;
};

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/grid2.h"
#include "core/geometry/pose2.h"
#include "sim/world/layers.h"

namespace panoptes::sim {

/// The outline nearest to a point.
struct Nearest {
  const Outline* outline = nullptr;
  double distance_m = 0;        ///< 0 inside
  Vec2 p_scene = Vec2::Zero();  ///< the nearest point of it
};

Nearest nearest_on(const Outline& outline, const Vec2& p_scene);

/// What the body can touch. Distances to it are exact, and quick by a grid over the plane.
class Obstacles {
 public:
  explicit Obstacles(std::vector<Outline> outlines);
  Obstacles(const Obstacles&) = delete;  // a Nearest points into it
  Obstacles& operator=(const Obstacles&) = delete;

  const std::vector<Outline>& outlines() const { return outlines_; }
  Vec2 low_scene() const { return low_; }  ///< corners of the box around all of them
  Vec2 high_scene() const { return high_; }

  /// The nearest outline not farther than `within_m`; empty when there is none.
  std::optional<Nearest> nearest(const Vec2& p_scene,
                                 double within_m = std::numeric_limits<double>::infinity()) const;

 private:
  std::vector<Outline> outlines_;
  Vec2 low_ = Vec2::Zero();
  Vec2 high_ = Vec2::Zero();
  Grid2<std::vector<int>> by_cell_;  // outlines whose box touches the cell, in order
};

/// Where a disc of `radius_m` can go without touching anything: the largest connected such region
/// of a 5 cm grid (coarser over more than 200 x 200 m) over the obstacles' box, or another. Empty
/// when the disc fits nowhere.
class FreeRegion {
 public:
  FreeRegion(const Obstacles& obstacles, double radius_m);
  FreeRegion(const Obstacles& obstacles, double radius_m, const Vec2& low_scene,
             const Vec2& high_scene);

  bool contains(const Vec2& p_scene) const { return inside_.at(p_scene) != 0; }
  double area_m2() const;

 private:
  Grid2<char> inside_;
};

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/eval/truth.h"
#include "core/map/occupancy.h"

namespace panoptes {

constexpr double kReachRadius_m = 0.25;

/// Where the centre of a disc can come from `start_scene` without touching anything of the body
/// layer: set cells of the result, on the same grid. A start closer to something than the radius
/// counts from the nearest place where the disc fits, if that is within the radius.
TruthLayer reachable_floor(const TruthLayer& body, const Vec2& start_scene,
                           double radius_m = kReachRadius_m);

double area_m2(const TruthLayer& layer);

/// The share of reachable cells that the map calls free; empty when nothing is reachable.
std::optional<double> coverage(const TruthLayer& reachable, const OccupancyMap& map,
                               const Pose2& T_scene_map);

/// How well the map tells floor from what stands on it, over what a floor camera truly saw.
struct MapQuality {
  int cells = 0;  ///< 5 cm cells compared
  std::optional<double> free_iou;
  std::optional<double> free_precision;   ///< empty when nothing is free
  std::optional<double> obstacle_recall;  ///< empty where no boundary was seen
};

/// On the cells of `truth.seen` that are set. A cell is free, in truth and in the map, when more
/// than half of its 1 cm squares are; unknown is not free. A boundary cell holds a set square of
/// the floor layer beside a clear one; it is found when the map has an occupied square within 5 cm
/// of one.
MapQuality map_quality(const Truth& truth, const OccupancyMap& map, const Pose2& T_scene_map);

/// What of the map's free floor is none.
struct Leak {
  double area_m2 = 0;
  std::optional<double> share;  ///< of all that the map calls free; empty when nothing is
};

/// The map's free cells of 5 cm (free where more than half of their squares are) whose centre is
/// farther than 10 cm from the centre of every true floor cell: clear ones of the floor layer.
/// Beyond the world there is no floor. Empty without a layer.
std::optional<Leak> leak(const TruthLayer& floor, const OccupancyMap& map,
                         const Pose2& T_scene_map);

struct CoverageSample {
  Time stamp;
  double mapped_m2 = 0;
  std::optional<double> coverage;  ///< absent without truth
};

/// When the coverage first passed this share, linear between samples; empty when it never did.
std::optional<double> time_of_coverage_s(const std::vector<CoverageSample>& samples, double share);

}  // namespace panoptes

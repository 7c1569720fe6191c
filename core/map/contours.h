// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/pose2.h"
#include "core/map/occupancy.h"

namespace panoptes {

/// Where free floor ends at an obstacle (not where it ends in the unknown): a point a cell border,
/// in the map's frame. Free regions under `free_min_m2` and obstacles bordering fewer than
/// `border_min_cells` free cells are dropped (thesis 6.3.3).
std::vector<Vec2> obstacle_contour(const OccupancyMap& map, double free_min_m2 = 0.1,
                                   int border_min_cells = 6);

struct ContourOptions {
  double search_m = 0.5;        ///< to both sides of the prior
  double search_rad = 0.18;     ///< to both sides of the prior
  double cutoff_m = 0.3;        ///< distances are cut off here: such points have no partner
  double partner_m = 0.06;      ///< a point nearer than this has a partner
  double correlation_m = 0.10;  ///< length of contour whose errors are one
  double sigma_m = 0.02;        ///< of a contour point
  int points_max = 400;
};
void bind(Fields& f, ContourOptions& o);

struct ContourMatch {
  Pose2 T_fixed_moving;
  double mean_distance_m = 0;  ///< of moving points to the fixed contour, cut off at cutoff_m
  double overlap = 0;          ///< share of moving points with a partner
  Mat3 information =
      Mat3::Zero();  ///< of x, y, theta in the frame of `fixed`; from the curvature of the cost
  Mat3 covariance = Mat3::Zero();  ///< its inverse; no larger than the search window allows
  double second_distance_m =
      0;  ///< best mean distance of a separate minimum; cutoff_m when there is none
  Pose2 T_fixed_second;
  double ambiguity() const {  ///< 0: one clear minimum; 1: another as good
    return second_distance_m > 0 ? mean_distance_m / second_distance_m : 1;
  }
};

/// Lays one contour on another (thesis Eq. 6.1) by a search around the prior, coarse to fine, over
/// the distance transform of the fixed one. Empty when either has fewer than 20 points. What the
/// contours do not determine, such as the position along an aisle, has a large covariance.
std::optional<ContourMatch> align_contours(const ContourOptions& options,
                                           const std::vector<Vec2>& fixed,
                                           const std::vector<Vec2>& moving,
                                           const Pose2& prior_T_fixed_moving);

}  // namespace panoptes

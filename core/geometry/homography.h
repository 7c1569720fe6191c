// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

/// One correspondence between two planes: `from` is seen at `to`.
struct PlanePair {
  Vec2 from = Vec2::Zero();
  Vec2 to = Vec2::Zero();
};

/// A fitted homography with the numbers behind its verdict.
struct HomographyFit {
  std::optional<Mat3>
      H_to_from;      ///< (to, 1) ~ H * (from, 1), bottom right entry positive; empty when refused
  std::string fault;  ///< why it was refused
  double rms = 0;     ///< residual in the unit of `to`; 0 for four pairs
  std::optional<double>
      leave_one_out;  ///< rms error of each pair under a fit to the others; five or more only
};

/// Normalised direct linear transform (Hartley 1997) from four or more pairs. Refuses what does not
/// determine it: fewer than four, coinciding points, all but one on a line.
HomographyFit fit_homography(const std::vector<PlanePair>& pairs);

/// The point `p` goes to; empty when `p` lies on or behind the horizon of `H` (third coordinate not
/// positive).
std::optional<Vec2> transfer(const Mat3& H, const Vec2& p);

/// Whether the whole rectangle between two corners lies on the same, positive side of the horizon.
bool clear_of_horizon(const Mat3& H, const Vec2& low, const Vec2& high);

}  // namespace panoptes

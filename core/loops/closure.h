// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

enum class Heading { kSame, kOpposite };

/// One closure that was tried, accepted or rejected, with the numbers behind the verdict.
struct ClosureReport {
  int recent = -1;   ///< keyframe in the middle of the recent seven
  int earlier = -1;  ///< keyframe in the middle of the earlier seven
  Heading heading = Heading::kSame;
  double emd_grey = 0;  ///< signature distance of the pair, grey levels
  std::array<std::array<float, 7>, 7>
      matrix{};  ///< signature distances, [recent][earlier] (thesis Fig. 6.2)
  double diagonal_max_grey = 0;
  double gate_sigma = 0;  ///< how far the match is from where odometry predicts it
  int feature_inliers = 0;
  double cameras_sigma =
      0;  ///< how far apart front and back alone say the robot is; 0: one is silent
  double flow_heading_rad = 0;  ///< relative heading by matched features
  double contour_cost_m = 0;    ///< mean distance of aligned contour points
  double contour_overlap = 0;   ///< share of contour points with a partner
  double chi2_growth = 0;
  Pose2 T_earlier_recent;  ///< claimed relative pose
  Mat3 information = Mat3::Zero();
  std::vector<Vec2> contour_earlier;  ///< in the frame of `earlier`
  std::vector<Vec2> contour_recent;   ///< in the frame of `recent`
  bool accepted = false;
  std::string verdict;  ///< "accepted", or which check failed and by how much
};

}  // namespace panoptes

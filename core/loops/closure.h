// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/pose2.h"

namespace panoptes {

/// How the robot stands at a place that it has come back to: as before, the other way round, or
/// otherwise, so that other cameras see the same.
enum class Heading { kSame, kOpposite, kOther };

/// The same within 20 degrees, the opposite beyond 160.
Heading heading_of(double turn_rad);

/// "same", "opposite" or "other".
std::string_view name_of(Heading heading);
/// Empty for any other word.
std::optional<Heading> heading_named(std::string_view name);

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
  double cameras_sigma = 0;  ///< how far apart two cameras alone say the robot is, those that agree
                             ///< least; 0: all but one are silent
  double flow_heading_rad = 0;  ///< relative heading by matched features
  double contour_cost_m = 0;    ///< mean distance of aligned contour points
  double contour_overlap = 0;   ///< share of contour points with a partner
  double chi2_growth = 0;
  Pose2 T_earlier_recent;           ///< claimed relative pose
  Mat3 information = Mat3::Zero();  ///< of it, were the rig known
  Eigen::VectorXd state;            ///< of the rig, with which it was found,
  Eigen::MatrixXd by_state;  ///< and how it changes with that: x, y, theta a row; empty: not at all
  std::vector<Vec2> contour_earlier;  ///< in the frame of `earlier`
  std::vector<Vec2> contour_recent;   ///< in the frame of `recent`
  bool accepted = false;
  std::string verdict;  ///< "accepted", or which check failed and by how much
};

}  // namespace panoptes

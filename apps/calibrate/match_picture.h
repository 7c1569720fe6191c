// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/calib/rig_calibration.h"

namespace panoptes {

/// A point of one of two cameras' maps that views of both show: seen by its own camera, found by
/// the other one.
struct InterMapMatch {
  Vec2 first_px = Vec2::Zero();
  Vec2 second_px = Vec2::Zero();
  bool believed = true;
};

/// A view of each of two cameras, and what matches between them.
struct MatchedViews {
  std::size_t first = 0;  ///< index of RigTracks::views
  std::size_t second = 0;
  std::vector<InterMapMatch> matches;
};

/// Those two views of two cameras that have most points of both cameras' maps in common. Empty
/// where no view of one shows a believed point of the other's map.
std::optional<MatchedViews> best_matched_views(const RigCalibration& calibration,
                                               std::size_t first_camera, std::size_t second_camera);

/// Both pictures side by side, matches as lines from one to the other, and how many points of its
/// map each camera has in common with the other one in all (thesis Fig. 4.8). 8-bit BGR.
cv::Mat draw_matches(const RigCalibration& calibration, const MatchedViews& views,
                     const cv::Mat& first_grey, const cv::Mat& second_grey);

}  // namespace panoptes

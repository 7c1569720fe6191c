// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "apps/calibrate/camera_map.h"

namespace panoptes {

/// One picture as the filter looked at it: the grid, the ellipses in which points were sought, what
/// was found in them and what was new (thesis Fig. 4.6). 8-bit BGR.
cv::Mat draw_search(const CameraMap& told);

/// One keyframe, and where the map draws its points in it before and after adjustment, as lines
/// from where they were seen, enlarged (thesis Fig. 4.7). 8-bit BGR.
cv::Mat draw_reprojection(const CameraMap& told);

/// The camera's map from above, its first picture looking up the page: points with the ellipses of
/// their covariance, the path but for where it was lost, and the true one where it is known, in the
/// map's own metre.
cv::Mat draw_camera_map(const CameraMap& told);

/// The same as it grew, as it was believed then. 8-bit BGR.
cv::Mat draw_growth(const CameraMap& told);

}  // namespace panoptes

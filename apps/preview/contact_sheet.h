// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "apps/mission/mission.h"
#include "apps/preview/camera_preview.h"

namespace panoptes {

/// What every camera sees, with its true depth and its objects where they were asked for, beside
/// the floor plan with the cameras' views and the floor they have of it. The edge of what a floor
/// camera maps is drawn into its picture. 8-bit BGR.
cv::Mat contact_sheet(const ExploreMission& mission, const Pose2& T_scene_body, double at_s,
                      const CameraPreview::Views& views);

}  // namespace panoptes

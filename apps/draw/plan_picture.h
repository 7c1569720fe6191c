// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/draw/canvas.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What a floor camera has of a point of the floor.
enum class FloorVisibility { kNone, kSeen, kMapped };

/// A camera as it shows from above.
struct PlanCamera {
  std::string name;
  Colour colour;
  Vec2 eye_scene = Vec2::Zero();
  double from_rad = 0;  ///< heading in scene of the right side of its view,
  double to_rad = 0;    ///< and of the left one, counter-clockwise from there
  std::function<FloorVisibility(const Vec2& p_scene)> floor;  ///< empty where it maps none
};

/// A world from above, y up, with a robot in it.
struct PlanPicture {
  std::vector<std::vector<Vec2>> outlines_scene;  ///< convex outlines; two corners: upright sheets
  std::vector<PlanCamera> cameras;
  Pose2 T_scene_body;
  double radius_m = 0;
  Vec2 low_scene = Vec2::Zero();  ///< corners of what there is
  Vec2 high_scene = Vec2::Zero();
};

/// Shows all of it, or of a large world what is around the robot and where that lies. With metres
/// along the sides, a scale bar and a legend. 8-bit BGR, about `size_px` wide or high.
cv::Mat draw_plan(const PlanPicture& picture, int size_px);

/// The n-th of some colours that are told apart.
Colour nth_colour(std::size_t n);

}  // namespace panoptes

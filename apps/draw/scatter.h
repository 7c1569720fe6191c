// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/draw/canvas.h"

namespace panoptes {

struct ScatterAxis {
  std::string label;
  bool more_is_better = true;  ///< what is better is to the right, or up
};

struct ScatterPoint {
  Vec2 at;
  Vec2 half_interval{0, 0};  ///< bars either way; 0: none
  std::string name;          ///< beside it; may be empty
};

/// Points of one kind, over those of the layers before.
struct ScatterLayer {
  std::string name;
  Colour colour;
  double radius_px = 3;
  std::vector<ScatterPoint> points;
  bool joined = false;  ///< by a line, from left to right
};

struct Scatter {
  std::string title;
  ScatterAxis x;
  ScatterAxis y;
  std::vector<ScatterLayer> layers;
};

/// What is better up and to the right. 8-bit BGR.
cv::Mat draw_scatter(const Scatter& picture);

}  // namespace panoptes

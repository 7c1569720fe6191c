// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/draw/canvas.h"

namespace panoptes {

/// A mean and the interval about it.
struct BandPoint {
  double mean = 0;
  double low = 0;
  double high = 0;
};

struct BandCurve {
  std::string name;
  std::vector<std::optional<BandPoint>> points;  ///< one of each step; empty: none is known
};

struct BandPanel {
  std::string label;
  std::vector<BandCurve> curves;  ///< of the same names in all panels
};

struct Bands {
  std::string title;
  std::vector<std::string> steps;  ///< along the common axis
  std::vector<BandPanel> panels;   ///< one below another
};

/// Curves with their bands, over steps in their order. 8-bit BGR.
cv::Mat draw_bands(const Bands& picture);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "apps/draw/canvas.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// A camera's grey picture on a canvas, and where its pixels lie there.
class PicturePane {
 public:
  /// Pastes it with its top left corner at `corner`, `width` wide, as high as its shape has it.
  PicturePane(Canvas& canvas, const cv::Mat& grey, const Vec2& corner, double width);

  /// How high a picture of that shape becomes.
  static double height_of(int width_px, int height_px, double width);

  Vec2 at(const Vec2& px) const { return corner_ + scale_ * (px + Vec2(0.5, 0.5)); }
  double scale() const { return scale_; }  ///< pixels of the canvas a pixel of the picture

 private:
  Vec2 corner_;
  double scale_;
};

}  // namespace panoptes

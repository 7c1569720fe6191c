// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/picture_pane.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace panoptes {

PicturePane::PicturePane(Canvas& canvas, const cv::Mat& grey, const Vec2& corner, double width)
    : corner_(corner), scale_(width / grey.cols) {
  const double height = height_of(grey.cols, grey.rows, width);
  cv::Mat shown;
  cv::resize(
      grey, shown,
      cv::Size(static_cast<int>(Canvas::kOver * width), static_cast<int>(Canvas::kOver * height)),
      0, 0, cv::INTER_LINEAR);
  cv::cvtColor(shown, shown, cv::COLOR_GRAY2BGR);
  canvas.paste_over(shown, corner);
}

double PicturePane::height_of(int width_px, int height_px, double width) {
  return std::floor(width * height_px / width_px);
}

}  // namespace panoptes

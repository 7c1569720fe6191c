// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/grey.h"

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {

cv::Mat grey_of(const cv::Mat& picture) {
  PANOPTES_CHECK(picture.type() == CV_8UC3 || picture.type() == CV_8UC1, "8-bit BGR or grey");
  if (picture.channels() == 1) {
    return picture;
  }
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

}  // namespace panoptes

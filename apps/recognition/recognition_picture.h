// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace panoptes {

/// An accepted answer in the matrix.
struct FoundPlace {
  int picture = 0;
  int earlier = 0;
  std::optional<bool> right;  ///< where the truth is known and counts it
};

struct RecognitionPicture {
  cv::Mat distance;  ///< CV_32F, a row a picture, a column an earlier one
  std::vector<FoundPlace> found;
  std::string title;
};

/// The matrix of distances, near ones dark, with what was found. 8-bit BGR.
cv::Mat draw_recognition(const RecognitionPicture& picture);

}  // namespace panoptes

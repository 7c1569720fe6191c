// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

namespace panoptes {

/// How much there is to see in a picture, by what features are found again by: corners, at the
/// scale of the finest features and beyond the picture's own noise.
struct PictureContent {
  /// A cell each, some 16 by 12 of them: how steep the grey is in the direction where it is least
  /// so, levels a pixel; 0 where noise alone explains it.
  std::vector<float> corners_grey_px;
  /// The same of the fullest quarter, at the scale of the finest features and at one that blur
  /// spares.
  float fine_grey_px = 0;
  float coarse_grey_px = 0;
  double bright_share = 0;  ///< of the pixels: as light as can be
  double dark_share = 0;    ///< as dark as can be
};

/// From an 8-bit grey picture.
PictureContent picture_content(const cv::Mat& grey);

enum class PictureFault { kNone, kBlank, kDark, kOverExposed, kBlurred };

/// Which of a run's pictures show nothing, by what the run's other pictures reach: less than a
/// fifth of the usual number of cells hold corners, of at least a quarter of the usual steepness;
/// or fine steepness, relative to coarse, is so low that features of no size are found again. Right
/// where most of the pictures
/// show something; where all are alike in little, they are judged by their noise alone.
std::vector<PictureFault> picture_faults(const std::vector<const PictureContent*>& pictures);

}  // namespace panoptes

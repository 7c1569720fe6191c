// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose2.h"

namespace panoptes {

/// How salient points are found and described, so that other cameras find them again
/// (thesis 4.3.2).
enum class FeatureMethod {
  kSift,   ///< Lowe 2004, the square root of its histogram (Arandjelovic and Zisserman 2012)
  kAkaze,  ///< Alcantarilla 2013 with the M-SURF descriptor: determinant of Hessian, as SURF
  kOrb,    ///< Rublee 2011
  kSurf    ///< Bay 2008, where the OpenCV at hand has it
};

/// "sift", "akaze", "orb", "surf".
std::string_view name(FeatureMethod method);

/// Why this program cannot look for such features; empty where it can.
std::string feature_method_fault(FeatureMethod method);

struct SalientFeature {
  Vec2 px = Vec2::Zero();
  double size_px = 0;
  double angle_rad = 0;
  double saliency = 0;  ///< the method's own measure
  int octave = 0;       ///< as OpenCV packs it
};

/// Those of the first two octaves in a part of a picture (grey), the most salient first; of equals
/// the upper left one.
std::vector<SalientFeature> salient_features(FeatureMethod method, const cv::Mat& grey,
                                             const cv::Rect& area);

/// What a feature found in this picture is recognised by: one row of floats, but for ORB of 32
/// bytes. Empty for one too near to the picture's edge.
cv::Mat describe(FeatureMethod method, const cv::Mat& grey, const SalientFeature& feature);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/config/fields.h"

namespace panoptes {

struct FeatureOptions {
  int max_count = 400;          ///< a picture
  int fast_threshold_grey = 6;  ///< low, so that a plain wall still gives points
  int levels = 4;               ///< of a pyramid with steps of 1.2
  int cell_px = 40;             ///< side of the squares over which points are spread evenly
  int max_distance_bits = 64;   ///< of 256, between partners
  double ratio = 0.85;          ///< best to second best distance
};
void bind(Fields& f, FeatureOptions& o);

/// Points of one picture that are found again from nearby: 40 bytes each.
struct LocalFeatures {
  std::vector<Eigen::Vector2f> px;
  cv::Mat descriptors;  ///< CV_8U, 32 columns, a row a point
};

using PlaceFeatures = std::vector<LocalFeatures>;  ///< one for each loop camera

/// How a descriptor stands in the picture.
enum class DescriptorPose {
  kUpright,  ///< a robot on a floor does not roll, and what keeps the vertical tells more apart
  kTurned    ///< along the way from the corner to its patch's centroid (Rosin 1999): of pictures
             ///< that turn about their axis
};

/// FAST corners spread evenly over the picture, each with ORB's 256 binary tests.
LocalFeatures local_features(const FeatureOptions& options, const cv::Mat& picture,
                             DescriptorPose pose = DescriptorPose::kUpright);

/// Hamming distances of each row of `a` from all rows of `b`, of up to 256 bits: `a.rows` times
/// `b.rows`.
std::vector<std::int16_t> descriptor_distances_bits(const cv::Mat& a, const cv::Mat& b);

struct FeatureMatch {
  int a = 0;
  int b = 0;
};

/// Pairs that are each other's nearest in Hamming distance, near enough and clearly nearer than the
/// second; in order of `a`.
std::vector<FeatureMatch> match_features(const FeatureOptions& options, const LocalFeatures& a,
                                         const LocalFeatures& b);

}  // namespace panoptes

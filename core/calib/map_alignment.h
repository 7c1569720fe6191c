// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_map.h"
#include "core/calib/salient_features.h"
#include "core/calib/similarity.h"

namespace panoptes {

/// A point of one camera's adjusted map, where, how well that is known, and what it looks like.
struct DescribedPoint {
  std::size_t point = 0;  ///< of AdjustedMap::points
  Vec3 p_map = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  cv::Mat descriptor;  ///< as of `describe`
};

/// The points of an adjusted map that are known to a tenth of how far they are or better, by the
/// keyframes that show them, each described as it looked where it was first seen. `picture` of a
/// frame, grey.
std::vector<DescribedPoint> described_points(FeatureMethod method, const MonoMap& map,
                                             const AdjustedMap& adjusted,
                                             const std::function<cv::Mat(int frame)>& picture);

struct LooksOptions {
  double ratio = 0.8;  ///< of the closest descriptor's distance to the second closest (Lowe 2004)
  double most_apart = 0;  ///< the closest itself, as the method measures descriptors
  /// What is empirical of a method.
  static LooksOptions of(FeatureMethod method);
};

/// Of each point of map a the one of map b that looks most like it, where no other looks nearly as
/// much so (thesis 4.3.4); of two that take the same one, the more alike.
std::vector<std::pair<std::size_t, std::size_t>> alike_points(const LooksOptions& options,
                                                              const std::vector<DescribedPoint>& a,
                                                              const std::vector<DescribedPoint>& b);

/// How two maps lie by the points that they have in common.
struct MapAlignment {
  std::size_t a = 0;  ///< of the maps
  std::size_t b = 0;
  std::vector<std::pair<std::size_t, std::size_t>> alike;  ///< of the described points of both
  AgreedSimilarity agreed;                                 ///< `agree` is of `alike`
  double far = 0;  ///< of those points of a that agree from where a begins, the median

  bool is_found() const { return agreed.fault.empty(); }
};

/// Aligns two maps by what looks alike in both (thesis 4.3.4, 4.3.5).
MapAlignment align_maps(const LooksOptions& looks, const SimilarityOptions& options, std::size_t a,
                        std::size_t b, const std::vector<std::vector<DescribedPoint>>& maps,
                        const Rng& rng);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "core/eval/loops.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// How different two keyframes look, symmetric: a row for each keyframe.
class DistanceTable {
 public:
  /// `distance(i, j)` is asked once for every pair, j before i.
  DistanceTable(int count, const std::function<double(int, int)>& distance);

  int count() const { return count_; }
  float operator()(int i, int j) const {
    return values_[static_cast<std::size_t>(i) * static_cast<std::size_t>(count_) +
                   static_cast<std::size_t>(j)];
  }

 private:
  int count_;
  std::vector<float> values_;
};

/// A place that looks most like an earlier one, and how much the two differ.
struct DiagonalCandidate {
  int recent = 0;
  int earlier = 0;
  Heading heading = Heading::kSame;
  float distance = 0;  ///< the largest on its diagonal
};

/// What a method to tell places apart finds when it accepts all it can without one that is wrong.
struct PlaceRecall {
  int keyframes = 0;   ///< that are on a revisit of either heading
  int recognised = 0;  ///< those whose candidate is closer than the closest wrong one of any
  int revisits_same = 0;
  int revisits_opposite = 0;
  int recalled_same = 0;
  int recalled_opposite = 0;
};

constexpr int kThesisAround = 3;  ///< keyframes on each side: seven in all

/// For each keyframe the one candidate, of either heading, that is best by the thesis's rule
/// (6.3.2): of the matrix of distances around a pair the diagonal along which a robot going the
/// same or the opposite way meets the same places, `around` to each side, and on it the largest
/// element. A candidate of keyframe i lies before `until[i]`. `both_headings` is false where
/// pictures look one way only, in which nothing shows the robot that it goes the other way. In
/// order of the keyframes.
std::vector<DiagonalCandidate> diagonal_candidates(const DistanceTable& distances, int around,
                                                   bool both_headings,
                                                   const std::vector<int>& until);

/// With the seven of the thesis, at least 5 m of path before and on other keyframes altogether.
std::vector<DiagonalCandidate> place_candidates(const DistanceTable& distances, bool both_headings,
                                                const std::vector<double>& path_m);

/// Accepts every candidate below the closest wrong one: right and recalled as `loop_figures` has
/// it.
PlaceRecall recall_at_full_precision(const std::vector<DiagonalCandidate>& candidates,
                                     const std::vector<Pose2>& true_T_scene_body,
                                     const std::vector<double>& path_m);

}  // namespace panoptes

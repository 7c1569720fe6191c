// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/places.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numbers>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kBetween_m = 5.0;  // of path between the two visits, as revisits() has it

std::size_t at(int keyframe) { return static_cast<std::size_t>(keyframe); }

// The largest on the diagonal, or something larger than `best` as soon as that is sure.
float diagonal_max(const DistanceTable& distances, int recent, int earlier, int around,
                   Heading heading, float best) {
  const int step = heading == Heading::kSame ? 1 : -1;
  float largest = distances(recent, earlier);
  for (int k = -around; k <= around && largest < best; ++k) {
    largest = std::max(largest, distances(recent + k, earlier + step * k));
  }
  return largest;
}

ClosureReport closure_of(const DiagonalCandidate& candidate) {
  ClosureReport closure;
  closure.recent = candidate.recent;
  closure.earlier = candidate.earlier;
  closure.heading = candidate.heading;
  closure.T_earlier_recent.theta_rad = candidate.heading == Heading::kSame ? 0 : std::numbers::pi;
  closure.accepted = true;
  return closure;
}

}  // namespace

DistanceTable::DistanceTable(int count, const std::function<double(int, int)>& distance)
    : count_(count), values_(at(count) * at(count), 0) {
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < i; ++j) {
      const auto value = static_cast<float>(distance(i, j));
      values_[at(i) * at(count) + at(j)] = value;
      values_[at(j) * at(count) + at(i)] = value;
    }
  }
}

std::vector<DiagonalCandidate> diagonal_candidates(const DistanceTable& distances, int around,
                                                   bool both_headings,
                                                   const std::vector<int>& until) {
  PANOPTES_CHECK(until.size() == at(distances.count()), "an end for every keyframe");
  std::vector<DiagonalCandidate> candidates;
  for (int i = around; i + around < distances.count(); ++i) {
    PANOPTES_CHECK(until[at(i)] <= i, "candidates are earlier");
    DiagonalCandidate best{i, -1, Heading::kSame, std::numeric_limits<float>::infinity()};
    for (int j = around; j < until[at(i)]; ++j) {
      for (const Heading heading : {Heading::kSame, Heading::kOpposite}) {
        if (heading == Heading::kOpposite && !both_headings) {
          continue;
        }
        const float largest = diagonal_max(distances, i, j, around, heading, best.distance);
        if (largest < best.distance) {
          best = {i, j, heading, largest};
        }
      }
    }
    if (best.earlier >= 0) {
      candidates.push_back(best);
    }
  }
  return candidates;
}

std::vector<DiagonalCandidate> place_candidates(const DistanceTable& distances, bool both_headings,
                                                const std::vector<double>& path_m) {
  PANOPTES_CHECK(path_m.size() == at(distances.count()), "a path length for every keyframe");
  std::vector<int> until(path_m.size(), 0);
  for (int i = 0; i < distances.count(); ++i) {
    int& end = until[at(i)];
    while (end < i - 2 * kThesisAround && path_m[at(i)] - path_m[at(end)] >= kBetween_m) {
      ++end;
    }
  }
  return diagonal_candidates(distances, kThesisAround, both_headings, until);
}

PlaceRecall recall_at_full_precision(const std::vector<DiagonalCandidate>& candidates,
                                     const std::vector<Pose2>& true_T_scene_body,
                                     const std::vector<double>& path_m) {
  float closest_wrong = std::numeric_limits<float>::infinity();
  for (const DiagonalCandidate& candidate : candidates) {
    if (!is_correct(closure_of(candidate), true_T_scene_body)) {
      closest_wrong = std::min(closest_wrong, candidate.distance);
    }
  }
  std::vector<ClosureReport> accepted;
  for (const DiagonalCandidate& candidate : candidates) {
    if (candidate.distance < closest_wrong) {
      accepted.push_back(closure_of(candidate));
    }
  }
  const auto found = loop_figures(accepted, true_T_scene_body, path_m).against_truth;
  PlaceRecall recall;
  std::vector<bool> on_revisit(path_m.size(), false);
  for (const TrueRevisit& revisit : revisits(true_T_scene_body, path_m)) {
    std::fill(on_revisit.begin() + revisit.first, on_revisit.begin() + revisit.last + 1, true);
  }
  recall.keyframes = static_cast<int>(std::count(on_revisit.begin(), on_revisit.end(), true));
  recall.recognised = static_cast<int>(accepted.size());
  recall.revisits_same = found.revisits_same;
  recall.revisits_opposite = found.revisits_opposite;
  recall.recalled_same = found.recalled_same;
  recall.recalled_opposite = found.recalled_opposite;
  return recall;
}

}  // namespace panoptes

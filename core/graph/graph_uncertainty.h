// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// How uncertain poses of a graph are seen from each other: one factorisation of the graph,
/// linearised at its poses, answers for any number of pairs. Covariances are of x, y, theta in the
/// frame of `from`. The graph may change or go afterwards.
class GraphUncertainty {
 public:
  explicit GraphUncertainty(const PoseGraph& graph);
  ~GraphUncertainty();
  GraphUncertainty(const GraphUncertainty&) = delete;
  GraphUncertainty& operator=(const GraphUncertainty&) = delete;

  /// The marginal, exactly: a solve. Infinite where the graph does not join them.
  Mat3 relative(int from, int to) const;

  /// The same from 64 draws of the whole graph, the same draws every time: variances within half of
  /// the exact ones but in a pair of a thousand, at a few additions a pair.
  Mat3 relative_roughly(int from, int to) const;

 private:
  struct Equations;
  std::unique_ptr<const Equations> equations_;
};

}  // namespace panoptes

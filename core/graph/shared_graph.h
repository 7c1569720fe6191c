// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// What was measured together of the poses of nodes first + 1, first + 2, ... seen from `first`,
/// and of states that all measurements share: a Gaussian, given by its information (inverse
/// covariance) in x, y, theta of each, in the frame of `first`, then the states, and by the
/// gradient of half its squared Mahalanobis distance at `T_first_node` and `state`.
struct JointEdge {
  int first = 0;
  std::vector<Pose2> T_first_node;
  Eigen::VectorXd state;
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

/// An edge whose measurement depends on the shared states: about `state` it changes by `by_state`
/// (x, y, theta a row) for each unit of them. Without `by_state` it does not.
struct SharedEdge {
  GraphEdge edge;
  Eigen::VectorXd state;
  Eigen::MatrixXd by_state;
};

/// Keyframe poses, states they have in common (what is wrong with the rig and the wheels), and what
/// was measured of both. The states keep their prior for ever: N(0, prior_information^-1).
struct SharedGraph {
  std::vector<Pose2> T_map_node;
  Eigen::VectorXd state;
  Eigen::MatrixXd prior_information;
  std::vector<JointEdge> joints;
  std::vector<SharedEdge> edges;
};

/// Up to a constant: how much worse one graph is than another with the same edges.
double chi2(const SharedGraph& graph);

/// Moves every pose but the first, and the states, to where all agree best: Levenberg-Marquardt on
/// sparse Cholesky from where they are, until no measurement could tell the difference. One thread,
/// same bits every time.
RelaxReport relax(SharedGraph& graph);

/// How uncertain a graph is, linearised at its poses and states: one factorisation for any number
/// of questions. Nothing is known when its equations cannot be solved.
class SharedUncertainty {
 public:
  explicit SharedUncertainty(const SharedGraph& graph);

  /// The marginal of the states.
  const Eigen::MatrixXd& states() const { return states_; }

  /// See relative_covariance of a PoseGraph; with what the states are not known by. With `by_state`
  /// it is of the pose's difference from one that changes by so much (x, y, theta a row) for each
  /// unit of the states.
  Mat3 relative(int from, int to, const Eigen::MatrixXd& by_state = {}) const;

 private:
  struct Solved;
  Eigen::MatrixXd states_;
  std::shared_ptr<const Solved> solved_;
};

Eigen::MatrixXd state_covariance(const SharedGraph& graph);

/// What a joint edge says of the states alone, its poses integrated out.
struct StateSystem {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;  ///< at the states as they are
};
StateSystem of_states(const JointEdge& joint, const Eigen::VectorXd& state);

/// From here on `count` states from `first` on are others than those that the edge was measured
/// with: it reads as if those had been as in `state`, and says nothing of them.
void hold(JointEdge& joint, int first, int count, const Eigen::VectorXd& state);
void hold(SharedEdge& shared, int first, int count, const Eigen::VectorXd& state);

/// By how much more joint edges disagree on the states than they claim: the variance of unit weight
/// over what they show beyond the prior, never below 1.
double variance_factor(const SharedGraph& graph);

/// Each joint edge as edges between consecutive nodes, the states as they are now; `by_state` of
/// each is how it changes with them. What consecutive edges have in common is lost but for that.
std::vector<SharedEdge> pairwise_edges(const JointEdge& joint, const Eigen::VectorXd& state);

/// The graph as programs know it that know no states: as `pairwise_edges` has it, the covariance of
/// each edge with what the states are not known by.
PoseGraph pairwise(const SharedGraph& graph);

/// See path_covariances of a PoseGraph: never smaller than the marginal as far as the states are
/// concerned, which all edges of a path get wrong together.
std::vector<Mat3> path_covariances(const SharedGraph& graph, int from,
                                   const Eigen::MatrixXd& state_covariance);

}  // namespace panoptes

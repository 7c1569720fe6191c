// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/robust_relax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "core/base/check.h"
#include "core/graph/graph_uncertainty.h"
#include "core/graph/normal_equations.h"

namespace panoptes {
namespace {

constexpr double kPi = std::numbers::pi;

// chi2 of three degrees of freedom that a true closure exceeds once in a thousand.
constexpr double kGate = 16.27;
// Squares of the scales of the noise that are tried: what the information says may be far off, most
// often too modest (public graphs lie between 1 and 1/500), but one scale holds for a whole graph.
// Four times as much a step is twice the error: finer than that, gates hardly change.
constexpr std::array<double, 7> kScales2{4, 1, 1.0 / 4, 1.0 / 16, 1.0 / 64, 1.0 / 256, 1.0 / 1024};
constexpr std::size_t kAsStated = 1;
// How many cycles of a whole graph may be expected to close by chance, for a pair of closures to be
// supported, and for it to be believed at once. One graph in 500 gets a false pair that is
// supported, which must then agree with the graph relaxed on the pairs that are believed; one in
// 10000 gets one that is believed and bends the graph to its will.
constexpr std::array<double, 2> kChances{0.002, 1e-4};
// How many false closures may be expected among all that are admitted to the relaxed graph: one in
// 40 graphs at most. With less, true closures that agree well but stand alone are lost before a
// false one is: a graph of 20 closures can spare none.
constexpr double kMostFalse = 0.025;
// Where all but this share of the true closures are in, the last ones change the graph little: one
// comes in at no more than a hundredth of the risk.
constexpr double kLast = 0.01;
constexpr double kLastFalse = kMostFalse / 100;
// A closure waits for the next round where it is so many times likelier false than the surest one
// (but never below kSure): with the sure ones in, those that are left are seen for what they are.
constexpr double kAtOnce = 100;
constexpr double kSure = 1e-3;
// Errors have heavier tails than a Gaussian: a share of the closures err so many times more.
constexpr std::size_t kMostTails = 3;  // variances of 1, 4 and 16 times
constexpr int kMostRounds = 50;

// The first edge between each node and the one before it; -1 where there is none.
std::vector<int> odometry_of(const PoseGraph& graph) {
  std::vector<int> edge_to(graph.T_map_node.size(), -1);
  for (int e = static_cast<int>(graph.edges.size()) - 1; e >= 0; --e) {
    const GraphEdge& edge = graph.edges[e];
    if (std::abs(edge.from - edge.to) == 1) {
      edge_to[std::max(edge.from, edge.to)] = e;
    }
  }
  return edge_to;
}

// A pose with its rotation at hand, for products by the million.
struct Motion {
  Mat2 R = Mat2::Identity();
  Vec2 t = Vec2::Zero();
  double theta_rad = 0;  // not wrapped

  Motion() = default;
  explicit Motion(const Pose2& T) : R(T.rotation()), t(T.position()), theta_rad(T.theta_rad) {}
  Motion inverse() const {
    Motion T;
    T.R = R.transpose();
    T.t = -(T.R * t);
    T.theta_rad = -theta_rad;
    return T;
  }
};
Motion operator*(const Motion& a, const Motion& b) {
  Motion T;
  T.R = a.R * b.R;
  T.t = a.R * b.t + a.t;
  T.theta_rad = a.theta_rad + b.theta_rad;
  return T;
}

Mat3 turned(const Mat3& covariance, const Mat2& R) {
  Mat3 C;
  C.topLeftCorner<2, 2>() = R * covariance.topLeftCorner<2, 2>() * R.transpose();
  C.topRightCorner<2, 1>() = R * covariance.topRightCorner<2, 1>();
  C.bottomLeftCorner<1, 2>() = C.topRightCorner<2, 1>().transpose();
  C(2, 2) = covariance(2, 2);
  return C;
}

// What an error at `at` does to the origin: a heading's error swings it sideways.
Mat3 seen_from_origin(const Mat3& covariance, const Vec2& at) {
  Mat3 J = Mat3::Identity();
  J(0, 2) = at.y();
  J(1, 2) = -at.x();
  return J * covariance * J.transpose();
}

double least_variance(const Mat2& covariance) {
  return Eigen::SelfAdjointEigenSolver<Mat2>().computeDirect(covariance).eigenvalues().x();
}

// Poses by odometry, and sums of its errors from the start on: those between any two nodes are
// differences of them.
class Chain {
 public:
  Chain(const PoseGraph& graph, const std::vector<int>& edge_to) {
    const std::size_t nodes = graph.T_map_node.size();
    poses_.resize(nodes);
    sums_.resize(nodes);
    for (std::size_t k = 1; k < nodes; ++k) {
      const GraphEdge& edge = graph.edges[edge_to[k]];
      const bool forward = edge.to == static_cast<int>(k);
      poses_[k] = poses_[k - 1] * (forward ? edge.T_from_to : edge.T_from_to.inverse());
      const Mat3 covariance = edge.information.inverse();
      const Mat2 R = poses_[edge.from].rotation();
      const Vec2 p = poses_[edge.to].position();
      const double h = covariance(2, 2);
      Sums& sum = sums_[k];
      sum = sums_[k - 1];
      sum.least += least_variance(covariance.topLeftCorner<2, 2>());
      sum.position += R * covariance.topLeftCorner<2, 2>() * R.transpose();
      sum.heading += h;
      sum.heading_p += h * p;
      sum.heading_pp += h * p * p.transpose();
    }
    for (const Pose2& pose : poses_) {
      motions_.emplace_back(pose);
    }
  }

  const std::vector<Pose2>& poses() const { return poses_; }
  const Motion& motion(int node) const { return motions_[node]; }

  double heading_variance(int a, int b) const {
    return std::abs(sums_[a].heading - sums_[b].heading);
  }
  // Of the motion between two nodes, in the direction where it is least, wherever it is seen from.
  double least_variance_between(int a, int b) const {
    return std::abs(sums_[a].least - sums_[b].least);
  }
  // Of the motion between two nodes, as it moves `point`, in the chain's own frame: the sum of the
  // variances of x and y, and the whole covariance.
  double position_variance(int a, int b, const Vec2& point) const {
    const Sums& last = sums_[std::max(a, b)];
    const Sums& first = sums_[std::min(a, b)];
    return (last.position - first.position).trace() +
           (last.heading - first.heading) * point.squaredNorm() -
           2 * point.dot(last.heading_p - first.heading_p) +
           (last.heading_pp - first.heading_pp).trace();
  }
  Mat3 covariance(int a, int b, const Vec2& point) const {
    const Sums& last = sums_[std::max(a, b)];
    const Sums& first = sums_[std::min(a, b)];
    const double h = last.heading - first.heading;
    const Vec2 hp = last.heading_p - first.heading_p;
    const Mat2 L = h * point * point.transpose() - point * hp.transpose() - hp * point.transpose() +
                   last.heading_pp - first.heading_pp;
    const Vec2 swing = h * point - hp;
    Mat3 C;
    C << L(1, 1), -L(0, 1), -swing.y(), -L(0, 1), L(0, 0), swing.x(), -swing.y(), swing.x(), h;
    C.topLeftCorner<2, 2>() += last.position - first.position;
    return C;
  }

 private:
  struct Sums {
    double least = 0;
    Mat2 position = Mat2::Zero();
    double heading = 0;
    Vec2 heading_p = Vec2::Zero();
    Mat2 heading_pp = Mat2::Zero();
  };
  std::vector<Pose2> poses_;
  std::vector<Motion> motions_;
  std::vector<Sums> sums_;
};

// ln of the room that the errors of false closures fill: any turn, and twice the extent either way,
// of a corridor not less than a tenth of its length.
double log_room(const std::vector<Pose2>& poses) {
  Vec2 low = poses[0].position();
  Vec2 high = low;
  for (const Pose2& pose : poses) {
    low = low.cwiseMin(pose.position());
    high = high.cwiseMax(pose.position());
  }
  const Vec2 extent = high - low;
  const Vec2 size = 2 * extent.cwiseMax(0.1 * extent.norm());
  return std::log(std::max(std::numeric_limits<double>::min(), size.x() * size.y() * 2 * kPi));
}

// An error against its covariance.
struct Weight {
  double d2 = std::numeric_limits<double>::infinity();
  double log_peak = 0;  // of the density

  // ln of the density where the errors are so much greater
  double log_density(double scale2) const {
    return log_peak - 1.5 * std::log(scale2) - 0.5 * d2 / scale2;
  }
};
// Beyond every gate where either is not a number or the covariance is unknown.
Weight weigh(const Vec3& error, const Mat3& covariance) {
  if (!error.allFinite() || !covariance.allFinite()) {
    return {};
  }
  const Eigen::LLT<Mat3> llt(covariance);
  if (llt.info() != Eigen::Success) {
    return {};
  }
  const Mat3& L = llt.matrixLLT();
  return {llt.matrixL().solve(error).squaredNorm(),
          -std::log(L(0, 0) * L(1, 1) * L(2, 2)) - 1.5 * std::log(2 * kPi)};
}

struct Closure {
  int edge = 0;
  int from = 0;
  int to = 0;
  Motion T_from_to;
  Motion T_to_from;
  Mat3 covariance;
  double least_variance = 0;  // of its position, the heading being known
  std::size_t steps = 0;      // how many of kChances a cycle with another one has passed
};

// Two closures and the odometry between their ends: once round, in the frame of a.from, over a,
// along the odometry, back over b and along it again.
struct Cycle {
  Cycle(const Chain& odometry, const Closure& first, const Closure& second)
      : chain(odometry),
        a(first),
        b(second),
        same(std::abs(a.from - b.from) + std::abs(a.to - b.to) <=
             std::abs(a.from - b.to) + std::abs(a.to - b.from)),
        k(same ? b.from : b.to),
        l(same ? b.to : b.from) {}

  // Of the error when it is walked: its turn, and where it ends instead of at the origin.
  double turn_rad() const {
    const double b_rad = same ? b.T_from_to.theta_rad : b.T_to_from.theta_rad;
    return std::remainder(a.T_from_to.theta_rad + chain.motion(l).theta_rad -
                              chain.motion(a.to).theta_rad - b_rad +
                              chain.motion(a.from).theta_rad - chain.motion(k).theta_rad,
                          2 * kPi);
  }
  double turn_variance() const {
    return chain.heading_variance(a.to, l) + chain.heading_variance(k, a.from) +
           a.covariance(2, 2) + b.covariance(2, 2);
  }
  // The determinant of the covariance is at least turn_variance() times the square of this.
  double least_variance() const {
    return chain.least_variance_between(a.to, l) + chain.least_variance_between(k, a.from) +
           a.least_variance + b.least_variance;
  }

  void walk() {
    T_i_odom = a.T_from_to * chain.motion(a.to).inverse();
    T_i_l = T_i_odom * chain.motion(l);
    T_i_k = T_i_l * (same ? b.T_to_from : b.T_from_to);
    T_i_odom_back = T_i_k * chain.motion(k).inverse();
    off = T_i_odom_back.R * chain.motion(a.from).t + T_i_odom_back.t;
    origin_odom = -(T_i_odom.R.transpose() * T_i_odom.t);
    origin_odom_back = -(T_i_odom_back.R.transpose() * T_i_odom_back.t);
  }
  const Vec2& b_end() const { return same ? T_i_l.t : T_i_k.t; }
  // No variance of `off` is larger: their sum; a correlation with the heading at most doubles it.
  double most_variance() const {
    return chain.position_variance(a.to, l, origin_odom) +
           chain.position_variance(k, a.from, origin_odom_back) +
           2 * (a.covariance(0, 0) + a.covariance(1, 1) +
                a.covariance(2, 2) * a.T_from_to.t.squaredNorm()) +
           2 * (b.covariance(0, 0) + b.covariance(1, 1) +
                b.covariance(2, 2) * b_end().squaredNorm());
  }
  Weight weight() const {
    const Mat3 C = turned(chain.covariance(a.to, l, origin_odom), T_i_odom.R) +
                   turned(chain.covariance(k, a.from, origin_odom_back), T_i_odom_back.R) +
                   seen_from_origin(a.covariance, a.T_from_to.t) +
                   seen_from_origin(turned(b.covariance, same ? T_i_k.R : T_i_l.R), b_end());
    return weigh({off.x(), off.y(), turn_rad()}, C);
  }

  const Chain& chain;
  const Closure& a;
  const Closure& b;
  bool same;  // b points in the direction of a
  int k;      // the end of b on the side of a.from
  int l;
  Motion T_i_odom, T_i_l, T_i_k, T_i_odom_back;
  Vec2 off, origin_odom, origin_odom_back;
};

// The weight of a cycle's error. Nothing when that is far more than errors explain, or when at no
// scale a density of `enough` is possible; most pairs end there, cheaply.
std::optional<Weight> promising(Cycle cycle, double enough) {
  const double turn_variance = cycle.turn_variance();
  const double determinant = turn_variance * cycle.least_variance() * cycle.least_variance();
  const double most_determinant = 1 / (enough * enough * 8 * kPi * kPi * kPi);
  const auto hopeless = [&](double least_d2) {
    // at the scale where the density of such an error is greatest
    const double scale2 = std::max(least_d2 / 3, kScales2.back());
    return least_d2 > kGate * kScales2.front() ||
           determinant * scale2 * scale2 * scale2 > most_determinant;
  };
  const double turn_d2 = cycle.turn_rad() * cycle.turn_rad() / turn_variance;
  if (hopeless(turn_d2)) {
    return std::nullopt;
  }
  cycle.walk();
  if (hopeless(std::max(turn_d2, cycle.off.squaredNorm() / cycle.most_variance()))) {
    return std::nullopt;
  }
  return cycle.weight();
}

// ln of the ratio, to the density of false closures, that a cycle's density must exceed at each
// scale, so that fewer than each of kChances cycles of the graph do by chance: an error uniform in
// the room lies in an ellipsoid by its share of the room. Counted on cycles evenly drawn from all.
using Ratios = std::array<std::array<double, kChances.size()>, kScales2.size()>;
Ratios least_ratios(const Chain& chain, const std::vector<Closure>& closures, double room) {
  constexpr std::size_t kMostDrawn = 20000;
  constexpr double kMostRatio = 100;  // of exp: no cycle needs as much
  constexpr int kHalvings = 16;
  const std::size_t pairs = closures.size() * (closures.size() - 1) / 2;
  const std::size_t every = pairs / kMostDrawn + 1;
  std::vector<double> log_peaks;  // at the stated scale, relative to the room
  std::size_t number = 0;
  for (std::size_t u = 0; u < closures.size(); ++u) {
    for (std::size_t v = u + 1; v < closures.size(); ++v) {
      if (number++ % every == 0) {
        Cycle cycle(chain, closures[u], closures[v]);
        cycle.walk();
        log_peaks.push_back(cycle.weight().log_peak + room);
      }
    }
  }
  std::sort(log_peaks.begin(), log_peaks.end(), std::greater<>());
  const auto expected = [&](double scale2, double ratio) {
    double sum = 0;
    for (const double log_peak : log_peaks) {
      const double peak = log_peak - 1.5 * std::log(scale2);
      if (peak <= ratio) {
        break;
      }
      const double d2 = std::min(kGate, 2 * (peak - ratio));
      sum += 4 * kPi / 3 * d2 * std::sqrt(d2) * std::exp(-peak) / std::pow(2 * kPi, 1.5);
    }
    return sum * static_cast<double>(every);
  };
  Ratios least{};
  for (std::size_t s = 0; s < kScales2.size(); ++s) {
    for (std::size_t c = 0; c < kChances.size(); ++c) {
      double most = kMostRatio;
      for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (least[s][c] + most);
        (expected(kScales2[s], middle) > kChances[c] ? least[s][c] : most) = middle;
      }
      least[s][c] = most;
    }
  }
  return least;
}

// Which closures another one supports, by a cycle that hardly closes by chance. Returns the square
// of the scale of the noise: that where most are supported.
// What is not looked at when it is stopped is not supported.
double find_support(const Chain& chain, std::vector<Closure>& closures,
                    const CycleProgress& progress, const RelaxStop& stop) {
  const double room = log_room(chain.poses());
  const Ratios least = least_ratios(chain, closures, room);
  double enough = least[0][0];
  for (const auto& ratios : least) {
    enough = std::min(enough, ratios[0]);
  }
  enough = std::exp(enough - room);
  std::array<std::vector<std::size_t>, kScales2.size()> steps;
  steps.fill(std::vector<std::size_t>(closures.size(), 0));
  for (std::size_t u = 0; u < closures.size() && !(stop && stop(0)); ++u) {
    for (std::size_t v = u + 1; v < closures.size(); ++v) {
      const std::optional<Weight> weight =
          promising(Cycle(chain, closures[u], closures[v]), enough);
      for (std::size_t s = 0; weight && s < kScales2.size(); ++s) {
        if (weight->d2 > kGate * kScales2[s]) {
          continue;
        }
        const double ratio = weight->log_density(kScales2[s]) + room;
        const auto passed = static_cast<std::size_t>(std::count_if(
            least[s].begin(), least[s].end(), [ratio](double r) { return ratio > r; }));
        steps[s][u] = std::max(steps[s][u], passed);
        steps[s][v] = std::max(steps[s][v], passed);
      }
    }
    if (progress) {
      const double rest = 1 - static_cast<double>(u + 1) / static_cast<double>(closures.size());
      progress(1 - rest * rest);
    }
  }
  const auto supported = [&](std::size_t s) {
    return std::count_if(steps[s].begin(), steps[s].end(), [](std::size_t n) { return n > 0; });
  };
  std::size_t best = kAsStated;
  for (std::size_t s = 0; s < kScales2.size(); ++s) {
    if (supported(s) > supported(best)) {
      best = s;
    }
  }
  for (std::size_t u = 0; u < closures.size(); ++u) {
    closures[u].steps = steps[best][u];
  }
  return kScales2[best];
}

// A closure that is not in the graph, but may be true.
struct Candidate {
  int edge = 0;
  std::array<double, kMostTails> ratios{};  // of its density to that of a false one, a tail each
  double false_probability = 1;
};

// What share of the `left` closures is true, and with which tail, is what explains the candidates
// best (expectation and maximisation, from a half, with half a closure added to what was seen).
void estimate_false(std::vector<Candidate>& candidates, std::size_t tails, int left) {
  constexpr int kIterations = 100;
  const double prior = 0.5 / static_cast<double>(tails);
  std::array<double, kMostTails> share{};
  std::fill_n(share.begin(), tails, prior);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::array<double, kMostTails> seen{};
    std::fill_n(seen.begin(), tails, prior);
    double share_false = 1;
    for (const double s : share) {
      share_false -= s;
    }
    for (Candidate& candidate : candidates) {
      double all = share_false;
      for (std::size_t k = 0; k < tails; ++k) {
        all += share[k] * candidate.ratios[k];
      }
      candidate.false_probability = share_false / all;
      for (std::size_t k = 0; k < tails; ++k) {
        seen[k] += share[k] * candidate.ratios[k] / all;
      }
    }
    for (std::size_t k = 0; k < tails; ++k) {
      share[k] = seen[k] / (left + 1);
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.false_probability, a.edge) < std::pair(b.false_probability, b.edge);
  });
}

// Which closures agree with a relaxed graph, its own uncertainty known.
class Judge {
 public:
  Judge(const std::vector<Closure>& closures, std::size_t edges, double scale2)
      : closures_(closures), times_out_(edges, 0), support_scale2_(scale2) {}

  double scale2() const { return tails2_.empty() ? support_scale2_ : tails2_.front(); }

  // Closures leave and come in; false when none did. At first those that are supported come in, and
  // need only agree. Ended by `stop` nothing comes in.
  bool judge(const PoseGraph& graph, const PoseGraph& trusted, const RelaxStop& stop,
             std::vector<bool>& kept) {
    const bool first = std::exchange(first_, false);
    set_tails(trusted);
    const double gate = kGate * tails2_.back();
    const GraphUncertainty uncertainty(trusted);
    const double room = log_room(graph.T_map_node);
    bool changed = first;
    int left = 0;
    std::vector<Candidate> candidates;
    for (const Closure& closure : closures_) {
      const GraphEdge& edge = graph.edges[closure.edge];
      if (kept[closure.edge]) {
        if (!(chi2(graph, edge) <= gate)) {
          kept[closure.edge] = false;
          ++times_out_[closure.edge];
          changed = true;
        }
        continue;
      }
      ++left;
      if (stop && stop(0)) {
        return true;
      }
      const Vec3 error = residual_of(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]);
      const Mat3 rough = 2 * uncertainty.relative_roughly(edge.from, edge.to) + closure.covariance;
      if (times_out_[closure.edge] > 1 || weigh(error, rough).d2 > 2 * gate) {
        continue;
      }
      const Weight weight =
          weigh(error, uncertainty.relative(edge.from, edge.to) + closure.covariance);
      if (weight.d2 > gate) {
        continue;
      }
      if (first) {
        kept[closure.edge] = closure.steps > 0;
        continue;
      }
      Candidate candidate{closure.edge};
      for (std::size_t k = 0; k < tails2_.size(); ++k) {
        candidate.ratios[k] = std::exp(weight.log_density(tails2_[k]) + room);
      }
      candidates.push_back(candidate);
    }
    estimate_false(candidates, tails2_.size(), left);
    return admit(candidates, static_cast<double>(closures_.size()) - left, kept) || changed;
  }

 private:
  // From the surest one on; false when none comes in.
  bool admit(const std::vector<Candidate>& candidates, double inside, std::vector<bool>& kept) {
    double true_outside = 0;
    for (const Candidate& candidate : candidates) {
      true_outside += 1 - candidate.false_probability;
    }
    bool any = false;
    for (const Candidate& candidate : candidates) {
      const double p = candidate.false_probability;
      if (p > std::max(kSure, kAtOnce * candidates.front().false_probability) ||
          false_expected_ + p > kMostFalse || (true_outside < kLast * inside && p > kLastFalse)) {
        break;
      }
      false_expected_ += p;
      true_outside -= 1 - p;
      ++inside;
      kept[candidate.edge] = true;
      any = true;
    }
    return any;
  }

  // The scale of the noise is what the trusted edges show; that of the cycles counts like ten
  // numbers more. Tails reach to what the information says, or else to one step.
  void set_tails(const PoseGraph& trusted) {
    constexpr double kSupportCount = 10;
    const double degrees_of_freedom =
        3.0 * static_cast<double>(trusted.edges.size() - trusted.T_map_node.size() + 1);
    const double scale2 =
        (chi2(trusted) + kSupportCount * support_scale2_) / (degrees_of_freedom + kSupportCount);
    tails2_.clear();
    const double most = std::max(1.0, 4 * scale2);
    for (double tail2 = scale2; tail2 <= most && tails2_.size() < kMostTails; tail2 *= 4) {
      tails2_.push_back(tail2);
    }
  }

  const std::vector<Closure>& closures_;
  std::vector<int> times_out_;  // an edge each; after the second it stays out
  std::vector<double> tails2_;  // squares of scales
  double support_scale2_;
  double false_expected_ = 0;
  bool first_ = true;
};

PoseGraph with_edges(const PoseGraph& graph, const std::vector<bool>& kept) {
  PoseGraph part{graph.T_map_node, {}};
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (kept[e]) {
      part.edges.push_back(graph.edges[e]);
    }
  }
  return part;
}

}  // namespace

std::optional<int> odometry_gap(const PoseGraph& graph) {
  const std::vector<int> edge_to = odometry_of(graph);
  const auto gap = std::find(edge_to.begin() + (edge_to.empty() ? 0 : 1), edge_to.end(), -1);
  return gap == edge_to.end() ? std::nullopt
                              : std::optional(static_cast<int>(gap - edge_to.begin()));
}

RobustReport relax_robustly(PoseGraph& graph, const CycleProgress& cycles,
                            const RelaxProgress& steps, const RelaxStop& stop) {
  PANOPTES_CHECK(!odometry_gap(graph), "every node is joined to the one before it");
  RobustReport report;
  report.kept.assign(graph.edges.size(), false);
  const std::vector<int> edge_to = odometry_of(graph);
  for (std::size_t k = 1; k < edge_to.size(); ++k) {
    report.kept[edge_to[k]] = true;
  }
  std::vector<Closure> closures;
  for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
    if (!report.kept[e]) {
      const GraphEdge& edge = graph.edges[e];
      const Motion T(edge.T_from_to);
      // what is left of the position's covariance where the heading is known
      const Mat2 position = edge.information.topLeftCorner<2, 2>().inverse();
      closures.push_back({e, edge.from, edge.to, T, T.inverse(), edge.information.inverse(),
                          least_variance(position)});
    }
  }
  const double chi2_start = chi2(graph);
  if (closures.empty()) {
    report.relax = relax(graph, RelaxStart::kLinear, steps, stop);
    return report;
  }
  double work = 0;  // of the last step asked for
  const RelaxStop watched = [&](double multiplications) {
    work = std::max(work, multiplications);
    report.stopped = report.stopped || (stop && stop(multiplications));
    return report.stopped;
  };
  const std::vector<bool> odometry = report.kept;
  const double scale2 = find_support(Chain(graph, edge_to), closures, cycles, watched);
  for (const Closure& closure : closures) {
    report.kept[closure.edge] = closure.steps == kChances.size();
  }
  Judge judge(closures, graph.edges.size(), scale2);
  bool changed = true;
  bool relaxed_once = false;
  for (int round = 0; round < kMostRounds && changed && !report.stopped; ++round) {
    PoseGraph trusted = with_edges(graph, report.kept);
    const int iterations = report.relax.iterations;
    report.relax =
        relax(trusted, round == 0 ? RelaxStart::kLinear : RelaxStart::kCurrent, steps, watched);
    report.relax.iterations += iterations;
    if (report.stopped && round == 0) {
      break;  // what is trusted at first may be false, and nothing has been tried
    }
    graph.T_map_node = trusted.T_map_node;
    // the judge's own factorisation is a step more
    if (!report.stopped && !watched(work)) {
      const std::vector<bool> kept = report.kept;
      changed = judge.judge(graph, trusted, watched, report.kept);
      if (report.stopped) {
        report.kept = kept;
      }
    }
    relaxed_once = true;
  }
  if (!relaxed_once) {
    report.kept = odometry;
    PoseGraph alone = with_edges(graph, odometry);
    dead_reckon(alone);
    graph.T_map_node = alone.T_map_node;
    report.relax.chi2_end = chi2(alone);
    report.relax.converged = false;
  }
  report.noise_scale = std::sqrt(judge.scale2());
  report.relax.converged = report.relax.converged && !changed && !report.stopped;
  report.relax.chi2_start = chi2_start;
  report.rejected = static_cast<int>(std::count(report.kept.begin(), report.kept.end(), false));
  return report;
}

Plausibility plausibility(const PoseGraph& relaxed) {
  constexpr double kSigma = 3.09;  // a Gaussian exceeds it once in a thousand
  Plausibility result;
  result.degrees_of_freedom = 3 * static_cast<int>(relaxed.edges.size()) -
                              3 * static_cast<int>(relaxed.T_map_node.size()) + 3;
  if (result.degrees_of_freedom <= 0) {
    return result;
  }
  // the quantile of chi2 by Wilson and Hilferty (1931)
  const double ninth = 2.0 / (9.0 * result.degrees_of_freedom);
  const double quantile =
      result.degrees_of_freedom * std::pow(1 - ninth + kSigma * std::sqrt(ninth), 3);
  result.chi2_most = kScales2.front() * quantile;
  result.plausible = chi2(relaxed) <= result.chi2_most;
  for (int e = 0; e < static_cast<int>(relaxed.edges.size()); ++e) {
    const GraphEdge& edge = relaxed.edges[e];
    if (std::abs(edge.from - edge.to) != 1 && !(chi2(relaxed, edge) <= kScales2.front() * kGate)) {
      result.disagreeing.push_back(e);
    }
  }
  return result;
}

}  // namespace panoptes

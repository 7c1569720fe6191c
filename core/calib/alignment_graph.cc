// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/alignment_graph.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "core/base/text.h"

namespace panoptes {
namespace {

// What a map of one camera is bent by, besides what its points are known to: parts of it lie so
// much otherwise beside one another than in truth.
constexpr double kBent_rad = deg_to_rad(1);
constexpr double kBentScale = 0.02;
constexpr double kGate = 24.32;  // 99.9 % of true cycles are less: chi-squared of 7

/// An alignment as it is gone along.
struct Step {
  std::size_t alignment = 0;
  bool forward = true;  ///< from a to b
};
using Way = std::vector<Step>;

class Graph {
 public:
  Graph(std::size_t maps, const std::vector<MapAlignment>& alignments)
      : maps_(maps), alignments_(alignments) {
    for (const MapAlignment& alignment : alignments) {
      is_there_.push_back(alignment.is_found());
    }
  }

  void reject(std::size_t alignment) { is_there_[alignment] = false; }
  const std::vector<bool>& is_there() const { return is_there_; }

  std::size_t support(std::size_t alignment) const {
    return alignments_[alignment].agreed.agree.size();
  }

  /// The shortest way between two maps without one alignment, by number of alignments; of equals
  /// the one of earlier maps. Empty where there is none.
  Way way(std::size_t from, std::size_t to, std::size_t without) const {
    std::vector<std::optional<Step>> by(maps_);
    std::vector<bool> been(maps_, false);
    std::deque<std::size_t> open{from};
    been[from] = true;
    while (!open.empty()) {
      const std::size_t map = open.front();
      open.pop_front();
      for (std::size_t i = 0; i < alignments_.size(); ++i) {
        const std::optional<std::size_t> other = other_end(i, map);
        if (other && i != without && is_there_[i] && !been[*other]) {
          been[*other] = true;
          by[*other] = Step{i, alignments_[i].a == map};
          open.push_back(*other);
        }
      }
    }
    Way back;
    for (std::size_t map = to; been[to] && map != from; map = begin_of(back.back())) {
      back.push_back(*by[map]);
    }
    std::reverse(back.begin(), back.end());
    return back;
  }

  /// Every triangle, and for an alignment of none of them the shortest cycle that it is of.
  std::vector<Way> cycles() const {
    std::set<std::vector<std::size_t>> known;
    std::vector<Way> found;
    const auto add = [&](Way cycle) {
      std::vector<std::size_t> sorted;
      for (const Step& step : cycle) {
        sorted.push_back(step.alignment);
      }
      std::sort(sorted.begin(), sorted.end());
      if (known.insert(sorted).second) {
        found.push_back(std::move(cycle));
      }
    };
    for (std::size_t i = 0; i < alignments_.size(); ++i) {
      if (!is_there_[i]) {
        continue;
      }
      bool is_of_triangle = false;
      for (std::size_t third = 0; third < maps_; ++third) {
        const auto on = between(alignments_[i].b, third);
        const auto back = between(third, alignments_[i].a);
        if (on && back) {
          add({{i, true}, *on, *back});
          is_of_triangle = true;
        }
      }
      if (!is_of_triangle) {
        Way rest = way(alignments_[i].b, alignments_[i].a, i);
        if (!rest.empty()) {
          rest.insert(rest.begin(), {i, true});
          add(std::move(rest));
        }
      }
    }
    return found;
  }

  Similarity along(const Step& step) const {
    const Similarity& S_a_b = alignments_[step.alignment].agreed.S_a_b;
    return step.forward ? S_a_b : S_a_b.inverse();
  }

  Similarity along(const Way& way) const {
    Similarity S;
    for (const Step& step : way) {
      S = S * along(step);
    }
    return S;
  }

  /// By how many sigmas, squared, a cycle misses where it began.
  double missed(const Way& cycle) const {
    Similarity S;
    SimilarityCovariance covariance = SimilarityCovariance::Zero();
    for (const Step& step : cycle) {
      const MapAlignment& alignment = alignments_[step.alignment];
      SimilarityCovariance known = alignment.agreed.covariance;
      SimilarityOffset bent;
      bent << Vec3::Constant(kBent_rad), Vec3::Constant(kBentScale * alignment.far), kBentScale;
      known.diagonal() += bent.cwiseAbs2();
      // An offset in a after the alignment is one in b before it, the other way.
      const SimilarityCovariance by =
          adjoint(step.forward ? S : S * alignment.agreed.S_a_b.inverse());
      covariance += by * known * by.transpose();
      S = S * along(step);
    }
    const SimilarityOffset offset = offset_of(S);
    return offset.dot(covariance.ldlt().solve(offset));
  }

  std::size_t begin_of(const Step& step) const {
    const MapAlignment& alignment = alignments_[step.alignment];
    return step.forward ? alignment.a : alignment.b;
  }

  std::optional<std::size_t> other_end(std::size_t alignment, std::size_t map) const {
    const MapAlignment& of = alignments_[alignment];
    return of.a == map ? std::optional(of.b) : of.b == map ? std::optional(of.a) : std::nullopt;
  }

 private:
  std::optional<Step> between(std::size_t from, std::size_t to) const {
    for (std::size_t i = 0; i < alignments_.size(); ++i) {
      if (is_there_[i] && other_end(i, from) == to) {
        return Step{i, alignments_[i].a == from};
      }
    }
    return std::nullopt;
  }

  std::size_t maps_;
  const std::vector<MapAlignment>& alignments_;
  std::vector<bool> is_there_;
};

std::string in_words(const MapAlignment& alignment, const std::vector<std::string>& names) {
  return fmt::format("{} and {}", names[alignment.a], names[alignment.b]);
}

/// Alignments that were not found are rejected to begin with.
AlignedMaps begun(std::size_t maps, const std::vector<MapAlignment>& alignments,
                  const std::vector<std::string>& names) {
  AlignedMaps out;
  out.S_first_map.resize(maps);
  out.S_first_map.front() = Similarity();
  out.is_believed.assign(alignments.size(), false);
  for (std::size_t i = 0; i < alignments.size(); ++i) {
    if (!alignments[i].is_found()) {
      out.rejected.push_back(
          {i, fmt::format("the maps of {} are not aligned: {}", in_words(alignments[i], names),
                          alignments[i].agreed.fault)});
    }
  }
  return out;
}

/// Round which cycles an alignment leads back, and round which it does not.
struct Cycles {
  std::size_t broken = 0;
  std::size_t closed = 0;
  double worst_missed = 0;
  std::size_t worst = 0;  ///< of the cycles
};

/// Rejects one alignment; false where all cycles close.
bool reject_worst(Graph& graph, const std::vector<MapAlignment>& alignments,
                  const std::vector<std::string>& names, AlignedMaps& out) {
  const std::vector<Way> cycles = graph.cycles();
  std::vector<Cycles> of(alignments.size());
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    const double missed = graph.missed(cycles[i]);
    for (const Step& step : cycles[i]) {
      Cycles& here = of[step.alignment];
      (missed > kGate ? here.broken : here.closed) += 1;
      if (missed > here.worst_missed) {
        here.worst_missed = missed;
        here.worst = i;
      }
    }
  }
  // The first by these is the worst: of equals the earlier one.
  const auto rank = [&](std::size_t i) {
    return std::tuple(static_cast<long>(of[i].broken) - static_cast<long>(of[i].closed),
                      -static_cast<long>(graph.support(i)), of[i].worst_missed);
  };
  std::optional<std::size_t> worst;
  std::size_t alike = 0;
  for (std::size_t i = 0; i < of.size(); ++i) {
    if (of[i].broken > 0 && (!worst || rank(i) > rank(*worst))) {
      worst = i;
    }
  }
  if (!worst) {
    return false;
  }
  for (const Cycles& each : of) {
    alike += each.broken == of[*worst].broken && each.closed == of[*worst].closed ? 1 : 0;
  }
  const Similarity S = graph.along(cycles[of[*worst].worst]);
  std::string round;
  for (const Step& step : cycles[of[*worst].worst]) {
    round += names[graph.begin_of(step)] + ", ";
  }
  out.rejected.push_back(
      {*worst,
       fmt::format(
           "the alignment of the maps of {} is rejected: it leads back round {} of {}, and round "
           "{}{} it is off by {:.1f} degrees and a factor of {:.2f}{}",
           in_words(alignments[*worst], names), of[*worst].closed,
           counted(of[*worst].broken + of[*worst].closed, "cycle"), round,
           names[graph.begin_of(cycles[of[*worst].worst].front())],
           rad_to_deg(offset_of(S).head<3>().norm()), S.scale,
           alike > 1 ? fmt::format("; which of {} is false the cycles do not tell, and fewest "
                                   "points agree on this one",
                                   alike)
                     : "")});
  graph.reject(*worst);
  return true;
}

}  // namespace

AlignedMaps chained(std::size_t maps, const std::vector<MapAlignment>& alignments,
                    const std::vector<std::string>& names) {
  AlignedMaps out = begun(maps, alignments, names);
  const Graph graph(maps, alignments);
  for (std::size_t last = 0;;) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < alignments.size(); ++i) {
      const std::optional<std::size_t> other = graph.other_end(i, last);
      if (other && graph.is_there()[i] && !out.S_first_map[*other] &&
          (!best || graph.support(i) > graph.support(*best))) {
        best = i;
      }
    }
    if (!best) {
      break;
    }
    const std::size_t next = *graph.other_end(*best, last);
    out.S_first_map[next] =
        *out.S_first_map[last] * graph.along(Step{*best, alignments[*best].a == last});
    out.is_believed[*best] = true;
    out.doubtful.push_back(*best);
    last = next;
  }
  return out;
}

AlignedMaps checked_by_cycles(std::size_t maps, const std::vector<MapAlignment>& alignments,
                              const std::vector<std::string>& names) {
  AlignedMaps out = begun(maps, alignments, names);
  Graph graph(maps, alignments);
  while (reject_worst(graph, alignments, names, out)) {
  }
  out.is_believed = graph.is_there();
  std::vector<bool> is_of_cycle(alignments.size(), false);
  for (const Way& cycle : graph.cycles()) {
    for (const Step& step : cycle) {
      is_of_cycle[step.alignment] = true;
    }
  }
  for (std::size_t i = 0; i < alignments.size(); ++i) {
    if (out.is_believed[i] && !is_of_cycle[i]) {
      out.doubtful.push_back(i);
    }
  }
  // A tree from the first map on, the best supported alignment first (Prim).
  for (;;) {
    std::optional<Step> best;
    for (std::size_t i = 0; i < alignments.size(); ++i) {
      const bool has_a = out.S_first_map[alignments[i].a].has_value();
      const bool has_b = out.S_first_map[alignments[i].b].has_value();
      if (out.is_believed[i] && has_a != has_b &&
          (!best || graph.support(i) > graph.support(best->alignment))) {
        best = Step{i, has_a};
      }
    }
    if (!best) {
      return out;
    }
    const std::size_t from = graph.begin_of(*best);
    out.S_first_map[*graph.other_end(best->alignment, from)] =
        *out.S_first_map[from] * graph.along(*best);
  }
}

}  // namespace panoptes

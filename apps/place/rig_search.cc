// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/rig_search.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#include "core/base/error.h"

namespace panoptes {
namespace {

/// What has been tried, and how a vector of pagmo's is a rig.
class Bred {
 public:
  Bred(const PlacementStudy& study, const ScoreRigs& score, const CostsOfRig& costs)
      : study_(study), score_(score), costs_(costs), axes_(axes_of(study)), order_(axes_.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_partition(order_.begin(), order_.end(),
                          [this](std::size_t i) { return !axes_[i].is_whole; });
  }

  std::size_t objectives() const { return study_.objectives.size(); }
  /// Whole numbers come last.
  std::size_t whole() const {
    return static_cast<std::size_t>(std::count_if(
        axes_.begin(), axes_.end(), [](const PlacementAxis& axis) { return axis.is_whole; }));
  }
  std::pair<std::vector<double>, std::vector<double>> bounds() const {
    std::pair<std::vector<double>, std::vector<double>> out;
    for (const std::size_t i : order_) {
      out.first.push_back(axes_[i].low);
      out.second.push_back(axes_[i].high);
    }
    return out;
  }

  /// Costs of vectors that stand one after another.
  std::vector<double> costs(const std::vector<double>& vectors) {
    std::vector<PlacementPoint> points;
    for (std::size_t at = 0; at < vectors.size(); at += order_.size()) {
      std::vector<double> numbers(order_.size());
      for (std::size_t k = 0; k < order_.size(); ++k) {
        numbers[order_[k]] = vectors[at + k];
      }
      points.push_back(point_at(study_, numbers));
    }
    std::vector<PlacementPoint> fresh;
    for (const PlacementPoint& point : points) {
      if (number_.try_emplace(point.values, rigs_.size() + fresh.size()).second) {
        fresh.push_back(point);
      }
    }
    for (SweptRig& rig : score_(std::move(fresh))) {
      rigs_.push_back(std::move(rig));
    }
    std::vector<double> all;
    for (const PlacementPoint& point : points) {
      const std::vector<double> of = costs_(rigs_[number_.at(point.values)]);
      all.insert(all.end(), of.begin(), of.end());
    }
    return all;
  }

  std::size_t tried() const { return rigs_.size(); }
  std::vector<SweptRig> take() { return std::move(rigs_); }

 private:
  const PlacementStudy& study_;
  const ScoreRigs& score_;
  const CostsOfRig& costs_;
  std::vector<PlacementAxis> axes_;
  std::vector<std::size_t> order_;  ///< where an element of a vector is among the parameters
  std::map<std::vector<std::string>, std::size_t> number_;  ///< of a rig, by its values
  std::vector<SweptRig> rigs_;
};

/// The search as pagmo2 asks for it.
struct PlacementProblem {
  Bred* bred = nullptr;

  std::vector<double> fitness(const std::vector<double>& x) const { return bred->costs(x); }
  std::pair<std::vector<double>, std::vector<double>> get_bounds() const { return bred->bounds(); }
  std::size_t get_nobj() const { return bred->objectives(); }
  std::size_t get_nix() const { return bred->whole(); }
  template <typename Archive>
  void serialize(Archive& /*archive*/, unsigned /*version*/) {}
};

/// All of a generation at once, so that several are scored at a time.
struct GenerationScored {
  Bred* bred = nullptr;

  std::vector<double> operator()(const pagmo::problem& /*all*/,
                                 const std::vector<double>& vectors) const {
    return bred->costs(vectors);
  }
  template <typename Archive>
  void serialize(Archive& /*archive*/, unsigned /*version*/) {}
};

}  // namespace

std::vector<SweptRig> bred_rigs(const PlacementStudy& study, const Nsga2Sweep& sweep,
                                const ScoreRigs& score, const CostsOfRig& costs) {
  if (study.objectives.size() < 2) {
    throw ConfigError(study.file +
                      ": sweep: nsga2 looks for what is best in several objectives; name two at "
                      "least, or take sweep: grid or random");
  }
  Bred bred(study, score, costs);
  const auto seed = static_cast<unsigned>(sweep.seed);
  const pagmo::bfe scored{GenerationScored{&bred}};
  const auto size = static_cast<pagmo::population::size_type>(sweep.population);
  pagmo::population population(pagmo::problem{PlacementProblem{&bred}}, scored, size, seed);
  constexpr double kCrossover = 0.95;
  constexpr double kCrossoverSpread = 10;
  constexpr double kMutationSpread = 50;
  // Of each child one parameter is changed, about.
  pagmo::nsga2 breeds(1, kCrossover, kCrossoverSpread,
                      1 / static_cast<double>(study.parameters.size()), kMutationSpread, seed);
  breeds.set_bfe(scored);
  const pagmo::algorithm generation{breeds};
  // Where there are few ways, children are soon all known.
  constexpr int kMostOfBudget = 4;
  int born = sweep.population;
  while (bred.tried() + size <= static_cast<std::size_t>(sweep.rigs) &&
         born < kMostOfBudget * sweep.rigs) {
    population = generation.evolve(population);
    born += sweep.population;
  }
  return bred.take();
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/rig_sweep.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <thread>
#include <utility>
#include <variant>

#include "apps/place/placed_rig.h"
#include "apps/place/rig_search.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/eval/ranking.h"
#include "core/eval/requirement.h"
#include "core/eval/rig_sight.h"

namespace panoptes {
namespace {

/// Where a score that the study names stands.
std::size_t index_of(const RigSweep& sweep, const std::string& key, const std::string& place,
                     const std::string& said_by) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < sweep.names.size(); ++i) {
    if (sweep.names[i].key == key) {
      return i;
    }
    known.push_back(sweep.names[i].key);
  }
  const std::string near = nearest_word(key, known);
  throw ConfigError(place + ": " + said_by + ": there is no score " + key + "; " +
                    (key == "price" ? "camera_price or the price of a choice makes it"
                     : near.empty() ? "panoptes place RIG --out DIR writes all of them"
                                    : "did you mean " + near + "?"));
}

struct Line {
  std::size_t score = 0;
  Requirement requirement;
};

void score_one(const PlacementStudy& study, const std::vector<Line>& lines, SweptRig& swept) {
  const Rig rig = rig_of(study, swept.point);
  if (const auto faults = placement_faults(rig, study.robot); !faults.empty()) {
    swept.refused = joined(faults, "; ");
    return;
  }
  for (const NamedScore& score : named_scores(score_rig(study.scores, rig, study.robot))) {
    swept.scores.push_back(score.value);
  }
  if (has_prices(study)) {
    swept.scores.push_back(swept.point.price + study.camera_price.value_or(0) *
                                                   static_cast<double>(rig.cameras.size()));
  }
  if (asks_calibratability(study)) {
    for (const NamedScore& score : named_scores(calibratability(study.scores, rig, study.robot))) {
      swept.scores.push_back(score.value);
    }
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::optional<double>& value = swept.scores[lines[i].score];
    if (!value || !holds(lines[i].requirement, *value)) {
      swept.broken.push_back(i);
    }
  }
}

/// So that less is better; what a rig has not is worst.
double cost(const RigSweep& sweep, const SweptRig& swept, std::size_t objective) {
  const std::size_t score = sweep.objectives[objective];
  const std::optional<double>& value = swept.scores[score];
  if (!value) {
    return std::numeric_limits<double>::infinity();
  }
  return sweep.names[score].better == Better::kHigher ? -*value : *value;
}

/// The same for any number of jobs. `progress` is told how many are done.
std::vector<SweptRig> scored(const PlacementStudy& study, const std::vector<Line>& lines,
                             std::vector<PlacementPoint> points, int jobs,
                             const std::function<void(std::size_t done)>& progress) {
  std::vector<SweptRig> rigs;
  for (PlacementPoint& point : points) {
    rigs.push_back({std::move(point), {}, {}, {}, false});
  }
  std::vector<std::exception_ptr> faults(rigs.size());
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> stop = false;
  const auto work = [&](const std::function<void(std::size_t)>& told) {
    for (std::size_t i = next++; i < rigs.size() && !stop; i = next++) {
      try {
        score_one(study, lines, rigs[i]);
        told(i + 1);
      } catch (...) {
        faults[i] = std::current_exception();
        stop = true;
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int job = 1; job < jobs; ++job) {
      helpers.emplace_back(work, [](std::size_t) {});
    }
    work(progress);
  }
  for (const std::exception_ptr& fault : faults) {
    if (fault) {
      std::rethrow_exception(fault);
    }
  }
  return rigs;
}

/// By how much of it a line is missed, between 0 and 1.
double missed(const Line& line, const std::optional<double>& value) {
  const auto* wanted = std::get_if<double>(&line.requirement.wanted);
  if (!value || wanted == nullptr) {
    return 1;
  }
  constexpr double kLeast = 1e-9;
  const double share = std::abs(*value - *wanted) / std::max(kLeast, std::abs(*wanted));
  return share / (1 + share);
}

/// Of each objective. A rig that breaks lines costs more than any that holds them, the fewer and
/// the less the better; one that cannot be costs most.
std::vector<double> costs(const RigSweep& sweep, const std::vector<Line>& lines,
                          const SweptRig& swept) {
  constexpr double kBroken = 1e12;
  const std::size_t objectives = sweep.objectives.size();
  if (!swept.refused.empty()) {
    return std::vector<double>(objectives, kBroken * static_cast<double>(2 * lines.size() + 1));
  }
  double broken = 0;
  for (const std::size_t line : swept.broken) {
    broken += 1 + missed(lines[line], swept.scores[lines[line].score]);
  }
  std::vector<double> all(objectives, kBroken * broken);
  for (std::size_t i = 0; i < objectives && swept.broken.empty(); ++i) {
    all[i] = std::min(cost(sweep, swept, i), kBroken / 2);
  }
  return all;
}

void rank(RigSweep& sweep) {
  const std::size_t objectives = sweep.objectives.size();
  std::vector<std::vector<double>> all_costs(sweep.rigs.size());
  for (std::size_t i = 0; i < sweep.rigs.size(); ++i) {
    if (sweep.rigs[i].refused.empty()) {
      sweep.ranked.push_back(i);
      for (std::size_t k = 0; k < objectives; ++k) {
        all_costs[i].push_back(cost(sweep, sweep.rigs[i], k));
      }
    }
  }
  std::stable_sort(sweep.ranked.begin(), sweep.ranked.end(),
                   [&](std::size_t a, std::size_t b) { return all_costs[a] < all_costs[b]; });
  std::vector<std::size_t> front;  // whoever dominates a rig costs less than it
  for (const std::size_t i : sweep.ranked) {
    if (sweep.rigs[i].good() && std::none_of(front.begin(), front.end(), [&](std::size_t other) {
          return dominates(all_costs[other], all_costs[i]);
        })) {
      sweep.rigs[i].pareto = true;
      front.push_back(i);
    }
  }
  const auto group = [&](std::size_t i) {
    return sweep.rigs[i].pareto ? 0 : sweep.rigs[i].good() ? 1 : 2;
  };
  std::stable_sort(sweep.ranked.begin(), sweep.ranked.end(),
                   [&](std::size_t a, std::size_t b) { return group(a) < group(b); });
}

/// Of each objective, from the least cost in a Pareto set to the most, of those that have it.
std::vector<double> spans(const RigSweep& sweep, const std::vector<std::size_t>& front) {
  std::vector<double> all;
  for (std::size_t i = 0; i < sweep.objectives.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (const std::size_t rig : front) {
      const double of = cost(sweep, sweep.rigs[rig], i);
      least = std::min(least, of);
      most = std::isfinite(of) ? std::max(most, of) : most;
    }
    all.push_back(most - least);
  }
  return all;
}

/// How far two rigs of a Pareto set are from each other.
double apart(const RigSweep& sweep, const std::vector<double>& span, std::size_t one,
             std::size_t other) {
  double squares = 0;
  for (std::size_t i = 0; i < span.size(); ++i) {
    const double a = cost(sweep, sweep.rigs[one], i);
    const double b = cost(sweep, sweep.rigs[other], i);
    const bool both = std::isfinite(a) && std::isfinite(b);
    // what one has and the other has not is the whole span away
    const double by = a == b ? 0 : both ? (a - b) / span[i] : 1;
    squares += by * by;
  }
  return std::sqrt(squares);
}

}  // namespace

Rig rig_of(const PlacementStudy& study, const PlacementPoint& point) {
  try {
    return read_settings<Rig>(study.rig, point.settings.set);
  } catch (const ConfigError& error) {
    throw ConfigError(with_places(point.settings, error.lines()));
  }
}

std::vector<std::size_t> promoted_rigs(const RigSweep& sweep, std::size_t most) {
  std::vector<std::size_t> left;
  for (const std::size_t i : sweep.ranked) {
    if (sweep.rigs[i].pareto) {
      left.push_back(i);
    }
  }
  const std::vector<double> span = spans(sweep, left);
  std::vector<std::size_t> promoted;
  std::vector<double> near(left.size(), std::numeric_limits<double>::infinity());
  while (promoted.size() < std::min(most, left.size())) {
    // The first of the farthest: the best ranked.
    const auto farthest = std::max_element(near.begin(), near.end()) - near.begin();
    const std::size_t taken = left[static_cast<std::size_t>(farthest)];
    promoted.push_back(taken);
    for (std::size_t k = 0; k < left.size(); ++k) {
      near[k] = left[k] == taken ? -1 : std::min(near[k], apart(sweep, span, left[k], taken));
    }
  }
  for (const std::size_t i : sweep.ranked) {
    if (promoted.size() < most && !sweep.rigs[i].pareto) {
      promoted.push_back(i);
    }
  }
  return promoted;
}

bool asks_calibratability(const PlacementStudy& study) {
  const auto asks = [](const std::string& of) { return of.starts_with("calibratability."); };
  return std::any_of(study.objectives.begin(), study.objectives.end(), asks) ||
         std::any_of(study.require.begin(), study.require.end(), asks);
}

namespace {

/// What the study names, of no rigs yet.
RigSweep sweep_of(const PlacementStudy& study) {
  RigSweep sweep;
  sweep.names = named_scores(score_rig(study.scores, Rig(), study.robot));
  for (NamedScore& name : sweep.names) {
    name.value.reset();
  }
  if (has_prices(study)) {
    sweep.names.push_back({"price", "price", "", 1, 2, Better::kLower, {}});
  }
  if (asks_calibratability(study)) {
    const std::vector<NamedScore> more = named_scores(std::optional<Calibratability>());
    sweep.names.insert(sweep.names.end(), more.begin(), more.end());
  }
  for (std::size_t i = 0; i < study.objectives.size(); ++i) {
    const std::string place =
        i < study.objective_places.size() ? study.objective_places[i] : study.file;
    const std::size_t score = index_of(sweep, study.objectives[i], place, "objectives");
    if (sweep.names[score].better == Better::kNeither) {
      throw ConfigError(place + ": objectives: neither more nor less of " + study.objectives[i] +
                        " is better");
    }
    sweep.objectives.push_back(score);
  }
  return sweep;
}

std::vector<Line> lines_of(const PlacementStudy& study, const RigSweep& sweep) {
  std::vector<Line> lines;
  for (std::size_t i = 0; i < study.require.size(); ++i) {
    Requirement requirement = parse_requirement(study.require[i]);
    const std::size_t score =
        index_of(sweep, requirement.figure, study.require_places[i], "require");
    lines.push_back({score, std::move(requirement)});
  }
  return lines;
}

}  // namespace

void check_placement_study(const PlacementStudy& study) {
  lines_of(study, sweep_of(study));
  const std::vector<PlacementAxis> axes = axes_of(study);
  std::vector<double> lows;
  for (const PlacementAxis& axis : axes) {
    lows.push_back(axis.low);
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    std::vector<double> numbers = lows;
    for (double number = axes[i].low; number <= axes[i].high;
         number += axes[i].is_whole ? 1 : axes[i].high - axes[i].low) {
      numbers[i] = number;
      rig_of(study, point_at(study, numbers));
    }
  }
  if (!std::holds_alternative<Nsga2Sweep>(study.sweep)) {
    points_of(study);
  }
}

RigSweep sweep_rigs(const PlacementStudy& study, int jobs,
                    const std::function<void(double done)>& progress,
                    const std::function<bool()>& stop) {
  RigSweep sweep = sweep_of(study);
  const std::vector<Line> lines = lines_of(study, sweep);
  if (const auto* search = std::get_if<Nsga2Sweep>(&study.sweep)) {
    struct Stopped {};
    std::vector<SweptRig> tried;
    const ScoreRigs score = [&](std::vector<PlacementPoint> points) {
      if (stop()) {
        throw Stopped();
      }
      std::vector<SweptRig> rigs =
          scored(study, lines, std::move(points), jobs, [&](std::size_t done) {
            progress(static_cast<double>(tried.size() + done) / search->rigs);
          });
      tried.insert(tried.end(), rigs.begin(), rigs.end());
      return rigs;
    };
    try {
      sweep.rigs = bred_rigs(study, *search, score,
                             [&](const SweptRig& rig) { return costs(sweep, lines, rig); });
    } catch (const Stopped&) {
      sweep.rigs = std::move(tried);
      sweep.cut_short = true;
    }
  } else {
    constexpr std::size_t kAtOnce = 64;
    const std::vector<PlacementPoint> points = points_of(study);
    while (sweep.rigs.size() < points.size() && !sweep.cut_short) {
      const auto from = points.begin() + static_cast<std::ptrdiff_t>(sweep.rigs.size());
      const std::size_t count = std::min(kAtOnce, points.size() - sweep.rigs.size());
      std::vector<SweptRig> rigs =
          scored(study, lines, {from, from + static_cast<std::ptrdiff_t>(count)}, jobs,
                 [&](std::size_t done) {
                   progress(static_cast<double>(sweep.rigs.size() + done) /
                            static_cast<double>(points.size()));
                 });
      std::move(rigs.begin(), rigs.end(), std::back_inserter(sweep.rigs));
      sweep.cut_short = sweep.rigs.size() < points.size() && stop();
    }
  }
  rank(sweep);
  return sweep;
}

}  // namespace panoptes

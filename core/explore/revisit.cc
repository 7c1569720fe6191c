// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/revisit.h"

#include <algorithm>
#include <cmath>

namespace panoptes {
namespace {

double square(double x) { return x * x; }

// Of a place so far back along the path.
double uncertainty_after_m(const std::vector<VisitedPose>& places, double distance_m) {
  double driven_m = 0;
  std::size_t i = places.size() - 1;
  for (; i > 0 && driven_m < distance_m; --i) {
    driven_m += (places[i].T_map_body.position() - places[i - 1].T_map_body.position()).norm();
  }
  return places[i].uncertainty_m;
}

}  // namespace

void bind(Fields& f, RevisitOptions& o) {
  f("run_m", o.run_m, positive);
  f("least_age_s", o.least_age_s, not_negative);
  f("uncertain_m", o.uncertain_m, not_negative);
  f("closure_m", o.closure_m, not_negative);
  f("blacklist_m", o.blacklist_m, not_negative);
  f("pace_mps", o.pace_mps, positive);
  f("turn_pace_radps", o.turn_pace_radps, positive);
  f("fixed_cost_s", o.fixed_cost_s, positive);
  f.renamed("settle_s", "fixed_cost_s");
}

bool closure_due(const RevisitOptions& options, Time now, const std::vector<VisitedPose>& places,
                 std::size_t place, double distance_m) {
  const double uncertainty_m = places[place].uncertainty_m;
  if (to_seconds(now - places[place].visited) < options.least_age_s ||
      !std::isfinite(uncertainty_m) || uncertainty_m < options.uncertain_m) {
    return false;
  }
  constexpr double kHalved = 3;  // 1 / (1 / s + 1 / t) <= s / 4, with variances s and t
  const double going_m = uncertainty_after_m(places, distance_m);
  return square(uncertainty_m) >= kHalved * (square(going_m) + square(options.closure_m));
}

std::optional<RevisitPlan> choose_revisit(const RevisitOptions& options,
                                          const SearchOptions& search, const DrivableGrid& grid,
                                          const Pose2& T_map_body, Time now,
                                          const std::vector<VisitedPose>& places,
                                          const std::vector<Vec2>& avoid, bool only_due) {
  const CostField field = flood(search, grid, T_map_body.position());
  const auto cost_m = [&](const Vec2& p) -> std::optional<double> {
    const int column = grid.clearance.column(p);
    const int row = grid.clearance.row(p);
    if (!grid.drivable(column, row) ||
        !std::isfinite(field.cost_m[grid.clearance.index(column, row)])) {
      return std::nullopt;
    }
    return field.cost_m[grid.clearance.index(column, row)];
  };
  const int count = static_cast<int>(places.size());
  std::optional<RevisitPlan> best;
  double best_worth = 0;
  for (int first = 0; first < count; ++first) {
    for (const int direction : {1, -1}) {
      // A run along the earlier path, forwards or against it, all of it old and drivable still.
      RevisitPlan run;
      run.same_heading = direction > 0;
      const Vec2 entry = places[first].T_map_body.position();
      if (std::any_of(avoid.begin(), avoid.end(),
                      [&](const Vec2& p) { return (p - entry).norm() <= options.blacklist_m; })) {
        continue;
      }
      double length = 0;
      double owed = 0;  // what closing with each of its places would be worth
      bool whole = true;
      for (int i = first; length < options.run_m; i += direction) {
        if (i < 0 || i >= count || to_seconds(now - places[i].visited) < options.least_age_s ||
            !std::isfinite(places[i].uncertainty_m) || !cost_m(places[i].T_map_body.position())) {
          whole = false;
          break;
        }
        if (!run.places.empty()) {
          length +=
              (places[i].T_map_body.position() - places[run.places.back()].T_map_body.position())
                  .norm();
        }
        owed += places[i].uncertainty_m;
        run.places.push_back(i);
      }
      if (!whole || run.places.size() < 2 ||
          (only_due &&
           !closure_due(options, now, places, static_cast<std::size_t>(first), *cost_m(entry)))) {
        continue;
      }
      const double heading =
          wrap_angle(places[first].T_map_body.theta_rad + (direction > 0 ? 0.0 : deg_to_rad(180)));
      run.cost_s = *cost_m(entry) / options.pace_mps +
                   std::abs(wrap_angle(heading - T_map_body.theta_rad)) / options.turn_pace_radps;
      // Certain places are worth a visit too, the longer ago the more: 1 cm a minute.
      const double age_min = to_seconds(now - places[first].visited) / 60;
      const double worth = (owed / static_cast<double>(run.places.size()) + 0.01 * age_min) /
                           (run.cost_s + length / options.pace_mps + options.fixed_cost_s);
      if (!best || worth > best_worth) {
        best_worth = worth;
        best = std::move(run);
      }
    }
  }
  return best;
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/placement_study.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/config/geometry_fields.h"
#include "core/eval/requirement.h"
#include "core/io/digits.h"
#include "sim/world/body_faces.h"

namespace panoptes {
namespace {

constexpr std::string_view kHole = "{}";

std::string filled(std::string setting, const std::string& value) {
  for (std::size_t at = setting.find(kHole); at != std::string::npos;
       at = setting.find(kHole, at + value.size())) {
    setting.replace(at, kHole.size(), value);
  }
  return setting;
}

/// On a grid, in order.
std::vector<std::string> values_of(const PlacementParameter& parameter) {
  std::vector<std::string> values = parameter.values;
  for (const auto& [name, settings] : parameter.choices) {
    values.push_back(name);
  }
  if (parameter.range && parameter.step > 0) {
    const double span = parameter.range->y() - parameter.range->x();
    constexpr double kRoundoff = 1e-9;
    const int steps = static_cast<int>(std::floor(span / parameter.step + kRoundoff));
    for (int i = 0; i <= steps; ++i) {
      values.push_back(fmt::format("{:.9g}", parameter.range->x() + i * parameter.step));
    }
  }
  return values;
}

std::string drawn(const PlacementParameter& parameter, Rng& rng) {
  if (parameter.range) {
    return shortest(rng.uniform(parameter.range->x(), parameter.range->y()));
  }
  const std::vector<std::string> values = values_of(parameter);
  return values[static_cast<std::size_t>(rng.index(static_cast<int>(values.size())))];
}

PlacementPoint point_with(const PlacementStudy& study, std::vector<std::string> values) {
  PlacementPoint point;
  std::size_t i = 0;
  for (const auto& [name, parameter] : study.parameters) {
    const std::string& value = values[i++];
    const auto choice = parameter.choices.find(value);
    const bool chosen = choice != parameter.choices.end();
    const StudySettings& from = chosen ? choice->second.settings : parameter.set;
    point.price += chosen ? choice->second.price : 0;
    for (std::size_t k = 0; k < from.set.size(); ++k) {
      point.settings.set.push_back(chosen ? from.set[k] : filled(from.set[k], value));
      point.settings.places.push_back(from.places[k]);
    }
  }
  point.values = std::move(values);
  return point;
}

std::vector<PlacementPoint> grid_of(const PlacementStudy& study) {
  std::vector<std::vector<std::string>> axes;
  double count = 1;
  for (const auto& [name, parameter] : study.parameters) {
    axes.push_back(values_of(parameter));
    count *= static_cast<double>(axes.back().size());
  }
  if (count > static_cast<double>(kMostPlacementPoints)) {
    throw ConfigError(fmt::format(
        "{}: sweep: a grid of {:.0f} rigs; at most {} are tried: widen the steps, or draw some of "
        "them with sweep: {{kind: random, rigs: 10000, seed: 1}}",
        study.file, count, kMostPlacementPoints));
  }
  std::vector<PlacementPoint> points;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
    std::vector<std::string> values(axes.size());
    std::size_t left = n;
    for (std::size_t i = axes.size(); i-- > 0;) {  // the last one changes fastest
      values[i] = axes[i][left % axes[i].size()];
      left /= axes[i].size();
    }
    points.push_back(point_with(study, std::move(values)));
  }
  return points;
}

}  // namespace

void bind(Fields& f, PlacementChoice& o) {
  bind(f, o.settings);
  f("price", o.price, not_negative);
}

bool has_prices(const PlacementStudy& study) {
  return study.camera_price ||
         std::any_of(study.parameters.begin(), study.parameters.end(), [](const auto& parameter) {
           const auto& choices = parameter.second.choices;
           return std::any_of(choices.begin(), choices.end(),
                              [](const auto& choice) { return choice.second.price > 0; });
         });
}

void bind(Fields& f, PlacementParameter& o) {
  f.texts("set", o.set.set, o.set.places);
  f.texts("values", o.values, o.value_places);
  f("range", o.range);
  f("step", o.step, not_negative);
  f("choices", o.choices);
  const int ways =
      (f.present("values") ? 1 : 0) + (f.present("range") ? 1 : 0) + (f.present("choices") ? 1 : 0);
  f.require(ways == 1,
            ways == 0              ? "values"
            : f.present("choices") ? "choices"
                                   : "range",
            ways == 0 ? "missing; values, a range or choices must be given"
                      : "must not be given beside others: values, a range or choices");
  f.require(!f.present("values") || !o.values.empty(), "values", "must have one at least");
  f.require(!f.present("choices") || !o.choices.empty(), "choices", "must have one at least");
  f.require(!o.range || o.range->x() < o.range->y(), "range",
            "is empty; must be [low, high] with low < high");
  f.require(o.step == 0 || o.range.has_value(), "step", "must not be given without a range");
  f.require(!o.range || o.step == 0 ||
                (o.range->y() - o.range->x()) / o.step < static_cast<double>(kMostPlacementPoints),
            "step", fmt::format("must make at most {} values of the range", kMostPlacementPoints));
  const auto has_hole = [](const std::string& setting) {
    return setting.find('=') != std::string::npos && setting.find(kHole) != std::string::npos;
  };
  f.require(
      f.present("choices") ||
          (!o.set.set.empty() && std::all_of(o.set.set.begin(), o.set.set.end(), has_hole)),
      "set",
      "must be settings of the rig with {} for the value, as [\"cameras.floor.tilt_deg={}\"]");
  f.require(!f.present("choices") || o.set.set.empty(), "set",
            "must not be given beside choices, which have settings of their own");
}

void bind(Fields&, GridSweep&) {}

void bind(Fields& f, RandomSweep& o) {
  f("rigs", o.rigs, between(1, static_cast<double>(kMostPlacementPoints)));
  f("seed", o.seed);
}

void bind(Fields& f, Nsga2Sweep& o) {
  f("rigs", o.rigs, between(1, static_cast<double>(kMostPlacementPoints)));
  f("population", o.population, between(8, 10'000));
  f.require(o.population % 4 == 0, "population", "must be a multiple of 4");
  f.require(o.population <= o.rigs, "population", "must be no more than the rigs that are tried");
  f("seed", o.seed);
}

void bind(Fields& f, PlacementDrives& o) {
  f.path("against", o.against);
  f.needed("missions", o.missions);
  f.require(!f.present("missions") || !o.missions.empty(), "missions",
            "must have one entry at least");
  bind(f, o.settings);
  f("best", o.best, between(1, 1000));
  f("rungs", o.rungs);
  for (const StudyRung& rung : o.rungs) {
    f.require(rung.rigs.empty(), "rungs", "must be of every rig: nobody knows yet which are best");
  }
  f.texts("against_first", o.against_first, o.against_first_places);
  for (const std::string& line : o.against_first) {
    try {
      parse_comparison(line);
    } catch (const ConfigError& error) {
      f.require(false, "against_first", error.what());
    }
  }
  f("scores", o.scores);
  f("halving", o.halving);
}

void bind(Fields& f, PlacementStudy& o) {
  f.require(f.writing() || f.present("rig"), "rig", "missing; it must name the rig's file");
  f.path("rig", o.rig);
  f.file_or_inline("robot", o.robot);
  f("scores", o.scores);
  f.needed("parameters", o.parameters);
  f.require(!f.present("parameters") || !o.parameters.empty(), "parameters",
            "must have one at least");
  f("camera_price", o.camera_price, not_negative);
  f.choice("sweep", o.sweep);
  for (const auto& [name, parameter] : o.parameters) {
    f.require(!std::holds_alternative<GridSweep>(o.sweep) || !parameter.range || parameter.step > 0,
              "parameters." + name + ".range", "must have a step above 0 on a grid");
  }
  f.texts("require", o.require, o.require_places);
  for (const std::string& line : o.require) {
    try {
      parse_requirement(line);
    } catch (const ConfigError& error) {
      f.require(false, "require", error.what());
    }
  }
  f.texts("objectives", o.objectives, o.objective_places);
  f.require(!o.objectives.empty(), "objectives", "must name a score at least");
  f("drive", o.drive);
}

PlacementStudy read_placement_study(const std::string& file) {
  PlacementStudy study;
  study = read_settings<PlacementStudy>(file, {}, study);
  study.file = file;
  sim::read_body_faces(study.robot);
  return study;
}

std::vector<PlacementAxis> axes_of(const PlacementStudy& study) {
  std::vector<PlacementAxis> axes;
  for (const auto& [name, parameter] : study.parameters) {
    if (parameter.range && parameter.step == 0) {
      axes.push_back({parameter.range->x(), parameter.range->y(), false});
    } else {
      axes.push_back({0, static_cast<double>(values_of(parameter).size() - 1), true});
    }
  }
  return axes;
}

PlacementPoint point_at(const PlacementStudy& study, const std::vector<double>& numbers) {
  std::vector<std::string> values;
  for (const auto& [name, parameter] : study.parameters) {
    const double number = numbers[values.size()];
    const std::vector<std::string> all = values_of(parameter);
    values.push_back(all.empty() ? shortest(number) : all[static_cast<std::size_t>(number)]);
  }
  return point_with(study, std::move(values));
}

std::vector<PlacementPoint> points_of(const PlacementStudy& study) {
  const auto* random = std::get_if<RandomSweep>(&study.sweep);
  if (random == nullptr) {
    return grid_of(study);
  }
  std::vector<PlacementPoint> points;
  for (int i = 0; i < random->rigs; ++i) {
    const Rng of_rig = Rng(random->seed).fork(fmt::format("rig {}", i));
    std::vector<std::string> values;
    for (const auto& [name, parameter] : study.parameters) {
      Rng rng = of_rig.fork(name);
      values.push_back(drawn(parameter, rng));
    }
    points.push_back(point_with(study, std::move(values)));
  }
  return points;
}

}  // namespace panoptes

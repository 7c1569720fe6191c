// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/pareto_picture.h"

#include <filesystem>

#include "apps/draw/scatter.h"

namespace panoptes {
namespace {

// An objective, or the rigs' numbers where there is none.
struct Axis {
  std::optional<std::size_t> score;
  NamedScore name;

  Axis(const RigSweep& sweep, std::size_t objective) {
    if (objective < sweep.objectives.size()) {
      score = sweep.objectives[objective];
      name = sweep.names[*score];
    } else {
      name.what = "rig";
      name.better = Better::kHigher;
    }
  }
  std::optional<double> of(const RigSweep& sweep, std::size_t rig) const {
    if (!score) {
      return static_cast<double>(rig + 1);
    }
    const std::optional<double>& value = sweep.rigs[rig].scores[*score];
    return value ? std::optional(*value * name.scale) : std::nullopt;
  }
  ScatterAxis drawn() const {
    return {name.what + (name.unit.empty() ? "" : " (" + name.unit + ")"),
            name.better == Better::kHigher};
  }
};

}  // namespace

cv::Mat pareto_picture(const PlacementStudy& study, const RigSweep& sweep) {
  const Axis x(sweep, sweep.objectives.size() > 1 ? 1 : sweep.objectives.size());
  const Axis y(sweep, 0);
  ScatterLayer broken{"does not", {200, 204, 210}, 3, {}, false};
  ScatterLayer good{"holds what is required", {31, 98, 196}, 3, {}, false};
  ScatterLayer pareto{"Pareto set", {214, 28, 38}, 5, {}, sweep.objectives.size() == 2};
  for (const std::size_t rig : sweep.ranked) {
    const auto of_x = x.of(sweep, rig);
    const auto of_y = y.of(sweep, rig);
    if (of_x && of_y) {
      const SweptRig& swept = sweep.rigs[rig];
      (swept.pareto   ? pareto
       : swept.good() ? good
                      : broken)
          .points.push_back({{*of_x, *of_y}, {0, 0}, {}});
    }
  }
  return draw_scatter({std::filesystem::path(study.file).stem().string(),
                       x.drawn(),
                       y.drawn(),
                       {std::move(broken), std::move(good), std::move(pareto)}});
}

}  // namespace panoptes

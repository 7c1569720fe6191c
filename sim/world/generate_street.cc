// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/generate.h"
#include "sim/world/load.h"

namespace panoptes::sim {

void bind(Fields& f, StreetPlan& o) {
  f("length_m", o.length_m, positive);
  f("seed", o.seed);
}

void generate(const StreetPlan& /*plan*/, WorldSettings& /*into*/) {}

}  // namespace panoptes::sim

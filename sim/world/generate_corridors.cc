// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/generate.h"
#include "sim/world/load.h"

namespace panoptes::sim {

void bind(Fields& f, CorridorsPlan& o) {
  f("size_m", o.size_m, positive);
  f("loops", o.loops, at_least(1));
  f("width_m", o.width_m, positive);
  f("seed", o.seed);
}

void generate(const CorridorsPlan& /*plan*/, WorldSettings& /*into*/) {}

}  // namespace panoptes::sim

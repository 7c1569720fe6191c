// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/generate.h"
#include "sim/world/load.h"

namespace panoptes::sim {

void bind(Fields& f, OfficePlan& o) {
  f("size_m", o.size_m, positive);
  f("desks", o.desks, at_least(0));
  f("overhangs", o.overhangs);
  f("texture", o.texture, between(0, 1));
  f("seed", o.seed);
}

void generate(const OfficePlan& /*plan*/, WorldSettings& /*into*/) {}

}  // namespace panoptes::sim

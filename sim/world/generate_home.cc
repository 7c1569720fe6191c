// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/generate.h"
#include "sim/world/load.h"

namespace panoptes::sim {

void bind(Fields& f, HomePlan& o) {
  f("size_m", o.size_m, positive);
  f("rooms", o.rooms, at_least(1));
  f("seed", o.seed);
}

void generate(const HomePlan& /*plan*/, WorldSettings& /*into*/) {}

}  // namespace panoptes::sim

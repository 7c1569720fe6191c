// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/eval/truth.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// What of a world the truth holds: see Truth.
struct TruthLayers {
  TruthLayer floor;
  TruthLayer body;
};

/// Of a robot as high as `top_m`; people, who walk, are left out. So is, from the floor's layer,
/// what lies on the floor no higher than kFloorLayerTop_m: rugs, paint and lids, which a robot
/// drives over. In cells of truth_cell_m.
TruthLayers truth_layers(World world, double top_m);

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/truth_layers.h"

#include "sim/world/layers.h"

namespace panoptes::sim {

TruthLayers truth_layers(World world, double top_m) {
  std::erase_if(world.objects,
                [](const Object& object) { return object.kind == Object::Kind::kPerson; });
  const double cell_m = truth_cell_m(world);
  return {occupancy(world, 0, kFloorLayerTop_m, cell_m),
          occupancy(world, kFloorLayerTop_m, top_m, cell_m)};
}

}  // namespace panoptes::sim

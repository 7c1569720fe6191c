// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/truth_layers.h"

#include <algorithm>
#include <utility>

#include "sim/world/layers.h"

namespace panoptes::sim {
namespace {

/// A rug, a line of paint or a lid: it is floor to whatever drives over it.
bool lies_on_floor(const Object& object) {
  double top_m = 0;
  for (const Triangle& triangle : object.triangles) {
    for (const auto& corner : triangle.corners) {
      top_m = std::max(top_m, (object.T_scene_object * corner.p_object).z());
    }
  }
  for (const Pillar& pillar : object.pillars) {
    top_m = std::max(top_m, object.T_scene_object.translation.z() + pillar.high_m);
  }
  return top_m > 0 && top_m <= kFloorLayerTop_m;  // the floor itself ends at 0
}

}  // namespace

TruthLayers truth_layers(World world, double top_m) {
  std::erase_if(world.objects,
                [](const Object& object) { return object.kind == Object::Kind::kPerson; });
  const double cell_m = truth_cell_m(world);
  TruthLayer body = occupancy(world, kFloorLayerTop_m, top_m, cell_m);
  std::erase_if(world.objects, lies_on_floor);
  return {occupancy(world, 0, kFloorLayerTop_m, cell_m), std::move(body)};
}

}  // namespace panoptes::sim

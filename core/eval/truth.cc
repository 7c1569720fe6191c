// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/truth.h"

namespace panoptes {

void bind(Fields& f, TrueWheels& o) {
  f.needed("left_radius_m", o.left_radius_m, positive);
  f.needed("right_radius_m", o.right_radius_m, positive);
  f.needed("base_m", o.base_m, positive);
}

void bind(Fields& f, TruePlatform& o) {
  f("rig", o.rig);
  f("wheels", o.wheels);
}

}  // namespace panoptes

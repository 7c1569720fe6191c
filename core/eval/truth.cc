// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/truth.h"

#include <cmath>

namespace panoptes {

bool TruthLayer::at(const Vec2& p_scene) const {
  const int column = static_cast<int>(std::floor((p_scene.x() - origin_scene.x()) / cell_m));
  const int row = static_cast<int>(std::floor((p_scene.y() - origin_scene.y()) / cell_m));
  if (column < 0 || row < 0 || column >= columns || row >= rows) {
    return false;
  }
  return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(column)] != 0;
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/eval/truth.h"

namespace panoptes {

/// The length of the shortest way from `from_scene` to `to_scene` over set cells (as of
/// reachable_floor), in any direction: fast marching (Sethian 1996), right to about a cell and a
/// half percent. A place that is not on a set cell counts from the nearest one within `moved_m`.
/// Empty where there is none, or no way. A second for 10^7 cells.
std::optional<double> shortest_path_m(const TruthLayer& reachable, const Vec2& from_scene,
                                      const Vec2& to_scene, double moved_m);

}  // namespace panoptes

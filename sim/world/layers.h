// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/eval/truth.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// Below this height an object belongs to the truth's floor layer, above it to the body layer.
inline constexpr double kFloorLayerTop_m = 0.02;

/// What a convex piece of an object covers on the floor, in `scene`, counter-clockwise; two corners
/// when the piece is a sheet standing upright.
struct Outline {
  std::string object;
  std::vector<Vec2> corners_scene;
  std::size_t index = 0;  ///< of the object in World::objects
};

/// The outlines of everything strictly above z_low and below z_high, as it stands at time 0;
/// people, who walk, are left out. A pillar gives its own outline. A connected part of a mesh that
/// is convex gives the convex hull of its slice, which is exact; any other part gives one outline
/// for each of its faces, which bounds it but leaves its inside empty. Parts are told apart by
/// their corners: faces that share one belong together. In the order of the world's objects and
/// triangles.
std::vector<Outline> outlines(const World& world, double z_low_m, double z_high_m);

/// The cells that the slice between z_low and z_high reaches into by more than a micrometre (meshes
/// are read in single precision), so that what is not set is free all over.
/// Covers everything in the world and one cell more on each side. Outside of closed walls cells are
/// not set, but there is no path to them.
TruthLayer occupancy(const World& world, double z_low_m, double z_high_m, double cell_m);

/// The finest of 1, 2, 5, 10 and 20 cm with which a layer has at most kMostTruthCells cells, a byte
/// each: 1 cm for a street block of 90 x 60 m.
double truth_cell_m(const World& world);
inline constexpr double kMostTruthCells = 64e6;

}  // namespace panoptes::sim

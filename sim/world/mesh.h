// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/body.h"
#include "sim/world/load.h"
#include "sim/world/pictures.h"

namespace panoptes::sim {

/// What a file's name ends with, in small letters: ".stl".
std::string format_of(const std::string& file);

/// The triangles of an object's mesh in its own frame, z up, metres. Throws IoError, with the place
/// that mentions it, for one that cannot be read, has no faces, has corners that are not finite,
/// has more triangles than kMostTriangles (looked for before it is read as far as its format lets)
/// or is of no sensible size; ConfigError for settings that do not go with it.
std::vector<Triangle> read_mesh(const ObjectSettings& settings, Pictures& pictures);

/// The same without what is painted on it: materials and pictures need not be there. `mention` is
/// file:line:column of who names the mesh.
std::vector<Face> read_faces(const std::string& file, double scale, Up up,
                             const std::string& mention);

}  // namespace panoptes::sim

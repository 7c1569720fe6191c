// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/body.h"

namespace panoptes::sim {

/// Reads the mesh of a body's shape into its `faces`; without one nothing is done. A robot as URDF
/// has its joints at zero; of a link with no `visual` its `collision` counts. What it calls
/// package://NAME/FILE is looked for in NAME, above the file or beside those. Throws ConfigError or
/// IoError, with the place that mentions the mesh, for what cannot be read, has no faces, or lies
/// nowhere near the body.
void read_body_faces(Body& body);

}  // namespace panoptes::sim

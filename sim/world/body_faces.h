// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/body.h"

namespace panoptes::sim {

/// Reads the mesh of a body's shape into its `faces`; without one nothing is done. A robot as URDF
/// has its joints at zero; of a link with no `visual` its `collision` counts. What it calls
/// package://NAME/FILE is looked for in the folders above the file. Throws ConfigError or IoError
/// for what cannot be read, has no faces or too many, or is of another size than the robot.
void read_body_faces(Body& body);

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/body.h"

namespace panoptes::sim {

/// The surface of a robot in URDF, in the frame of its first link, its joints at zero. `mention` is
/// file:line:column of who names it. Throws ConfigError or IoError.
std::vector<Face> read_urdf(const std::string& file, const std::string& mention);

}  // namespace panoptes::sim

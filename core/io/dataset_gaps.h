// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/camera/rig.h"
#include "core/io/dataset.h"
#include "core/io/gaps.h"

namespace panoptes {

/// How regularly the pictures of the rig's cameras come, by the camera's name.
std::map<std::string, Regularity> picture_rates(const Dataset& dataset, const Rig& rig);

/// What cameras, and the odometry of others, lack for longer than chance explains by their own
/// rate, each in words with the file and the line behind it.
std::vector<std::string> gap_lines(const Dataset& dataset, const Rig& rig);

}  // namespace panoptes

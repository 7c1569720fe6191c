// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/time.h"

namespace panoptes {

/// From a picture to the next, as most of them come; 0 of fewer than two. Stamps in order.
double picture_period_s(const std::vector<Time>& stamps);

/// How many pictures are missing between others, and where the longest gap is, as a warning; empty
/// where none is, or where so few come evenly that nobody can say. Stamps in order.
std::string missing_pictures(const std::string& camera, const std::vector<Time>& stamps);

}  // namespace panoptes

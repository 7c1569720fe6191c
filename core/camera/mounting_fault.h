// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// Why no camera can have its optical centre there on such a body, in words that follow the
/// camera's name; empty when one can.
std::string mounting_fault(const Vec3& eye_body, const Body& body);

}  // namespace panoptes

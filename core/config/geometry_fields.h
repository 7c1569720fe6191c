// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// {x_m, y_m, theta_deg}
void bind(Fields& f, Pose2& o);
/// {translation_m: [x, y, z], rotation_wxyz: [w, x, y, z]}
void bind(Fields& f, Pose3& o);
void bind(Fields& f, Body& o);

}  // namespace panoptes

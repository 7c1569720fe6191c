// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose3.h"

namespace panoptes {

struct TumPose {
  Time stamp;
  Pose3 T_frame_body;  ///< in whatever frame the trajectory is written
};

/// A trajectory as the TUM benchmark writes it: `t x y z qx qy qz qw` a line, seconds and metres.
void write_tum(const std::filesystem::path& path, const std::vector<TumPose>& poses);
std::vector<TumPose> read_tum(const std::filesystem::path& path);

}  // namespace panoptes

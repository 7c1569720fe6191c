// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose3.h"

namespace panoptes {

struct TumPose {
  Time stamp;
  Pose3 T_frame_body;  ///< in whatever frame the trajectory is written
};

/// Where the body stands on the floor, and which way its x axis points there.
Pose2 floor_pose(const TumPose& pose);

/// A trajectory as the TUM benchmark writes it: `t x y z qx qy qz qw` a line, seconds and metres.
void write_tum(const std::filesystem::path& path, const std::vector<TumPose>& poses);
/// One line of it, its end included.
std::string tum_row(const TumPose& pose);

/// Throws IoError with the file and line for what is no pose and for time that does not go on.
std::vector<TumPose> read_tum(const std::filesystem::path& path);

/// The same from text; `name` stands for the file in what is said.
std::vector<TumPose> parse_tum(const std::string& name, std::string_view text);

}  // namespace panoptes

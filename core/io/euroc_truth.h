// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/dataset.h"
#include "core/io/tum.h"

namespace panoptes {

inline constexpr std::string_view kEstimateFile = "mav0/state_groundtruth_estimate0/data.csv";

/// Where the body truly was, as EuRoC tells it (#timestamp, position, quaternion w x y z, and
/// whatever follows), in the frame of whoever tracked it, on the clock of the files. The tracked
/// thing is the body where its sensor.yaml has no T_BS (4 x 4, row by row: p_body = T_BS *
/// p_tracked). Empty where the dataset has none. Throws ConfigError with the file and line for what
/// is wrong, and for a body that does not stand upright: no robot on wheels leans by 45 degrees.
std::optional<std::vector<TumPose>> read_euroc_truth(const std::string& folder,
                                                     const DatasetText& text);

}  // namespace panoptes

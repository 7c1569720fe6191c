// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "core/map/occupancy.h"

namespace panoptes {

/// Writes `<stem>.pgm` and then `<stem>.yaml` in ROS map_server's trinary form: free 254, unknown
/// 205, occupied 0, the top row first; `origin` is the lower-left corner of the lower-left cell.
void write_map_server(const std::filesystem::path& stem, const OccupancyMap& map);

/// Reads a map_server map (trinary or scale, any picture format of OpenCV), by the yaml's own
/// thresholds. Throws ConfigError for what the yaml says wrongly, IoError for a file that is
/// missing or no picture.
OccupancyMap read_map_server(const std::filesystem::path& yaml_path);

}  // namespace panoptes

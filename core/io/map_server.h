// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "core/map/occupancy.h"

namespace panoptes {

/// Writes `<stem>.pgm` and then `<stem>.yaml` in ROS map_server's trinary form: free 254, unknown
/// 205, occupied 0, the top row first; `origin` is the lower-left corner of the lower-left cell. A
/// map without cells is written as one that is unknown: no reader takes a picture without pixels.
void write_map_server(const std::filesystem::path& stem, const OccupancyMap& map);

/// Reads a map_server map (trinary, scale or raw; PGM, PNG, BMP or JPEG) by the yaml's own
/// thresholds: a cell's occupancy is (255 - grey) / 255, the other way round with `negate`; in raw
/// mode it is grey / 100, and unknown above 100. Above occupied_thresh it is occupied, below
/// free_thresh free. Throws ConfigError for what the yaml says wrongly (a map that is turned is
/// refused too), IoError for a file that is missing or no picture, or has more than 10000 cells
/// along a side.
OccupancyMap read_map_server(const std::filesystem::path& yaml_path);

/// The same for maps that may be turned about their origin, by `yaw_rad` counter-clockwise.
struct MapServerMap {
  OccupancyMap map;
  double yaw_rad = 0;
};
MapServerMap read_turned_map_server(const std::filesystem::path& yaml_path);

}  // namespace panoptes

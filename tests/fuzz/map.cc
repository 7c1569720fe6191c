// SPDX-License-Identifier: BSD-3-Clause
// map_server maps: map.yaml and its picture.
#include <string>
#include <vector>

#include "core/io/map_server.h"
#include "sim/world/load.h"
#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {

std::vector<std::string> words() {
  return with_yaml({"image: map.pgm",
                    "image: map.png",
                    "mode: raw",
                    "mode: scale",
                    "mode: trinary",
                    "resolution: 0.05",
                    "origin: [0, 0, 0.5]",
                    "negate: 1",
                    "occupied_thresh: 0.65",
                    "free_thresh: 0.196",
                    "P5\n",
                    "P2\n",
                    "P6\n",
                    "P3\n",
                    "255\n",
                    "65535\n",
                    "# remark\n",
                    "8 8\n",
                    "BM",
                    "\xff\xd8",
                    "\xff\xd9",
                    "\xff\xc0",
                    "IHDR",
                    "IDAT",
                    "IEND",
                    "=== map.pgm\n"});
}

void read_input(std::string_view bytes) {
  const std::filesystem::path folder = written_files(bytes);
  read_turned_map_server(folder / "map.yaml");
  sim::WorldSettings settings;
  settings.floor_plan.emplace();
  settings.floor_plan->map = (folder / "map.yaml").string();
  const std::string small = PANOPTES_SOURCE_DIR "/tests/data/meshes/quarters.png";
  settings.floor_plan->wall = settings.floor_plan->floor = settings.floor_plan->ceiling = small;
  sim::make_world(settings);
}

}  // namespace panoptes::fuzz

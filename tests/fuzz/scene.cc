// SPDX-License-Identifier: BSD-3-Clause
// Worlds: world.yaml and what it includes, with the meshes and pictures of tests/data/meshes.
#include <string>
#include <vector>

#include "core/config/fields.h"
#include "sim/world/load.h"
#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {

std::vector<std::string> words() {
  return with_yaml({"name: ",
                    "ambient: ",
                    "lights:\n",
                    "objects:\n",
                    "boxes:\n",
                    "events:\n",
                    "people:\n",
                    "  - ",
                    "{at_s: 1, ",
                    "move: a",
                    "open: a",
                    "lights: day",
                    "power: 2",
                    "to: {x_m: 1}",
                    "mesh: box.obj",
                    "mesh: box.glb",
                    "mesh: box.dae",
                    "mesh: box.stl",
                    "mesh: box.ply",
                    "picture: quarters.png",
                    "faces: {top: quarters.png}",
                    "size_m: [1, 1, 1]",
                    "at: {x_m: 1}",
                    "theta_deg: 90",
                    "movable: true",
                    "scale: 0.001",
                    "up: z",
                    "textures: {paint: quarters.png}",
                    "include: [b.yaml]",
                    "include: [world.yaml]",
                    "generate: {office: {}}",
                    "generate: home",
                    "generate: {mirrored: {seed: 3}}",
                    "sun: {from: [0, 1, 1]}",
                    "sky_bgr: [1, 1, 1]",
                    "!!str ",
                    "|\n",
                    ">\n",
                    "\t",
                    "data:office/wall.png",
                    "path: [[0, 0], [1, 1]]",
                    "group: day",
                    "hinge_m: [0.5, 0]"});
}

void read_input(std::string_view bytes) {
  namespace fs = std::filesystem;
  const fs::path folder = written_files(bytes);
  const fs::path meshes = fs::path(PANOPTES_SOURCE_DIR) / "tests/data/meshes";
  for (const auto& entry : fs::directory_iterator(meshes)) {
    std::error_code ignored;
    fs::create_symlink(entry.path(), folder / entry.path().filename(), ignored);
  }
  const auto settings = read_settings<sim::WorldSettings>((folder / "world.yaml").string());
  const std::string written = write_settings(settings);
  if (write_settings(read_settings_text<sim::WorldSettings>(
          written, (folder / "world.yaml").string())) != written) {
    throw std::runtime_error("settings do not read back");
  }
  if (settings.generate) {  // takes long, and is made of the same boxes and meshes
    sim::expanded(settings);
  } else {
    sim::make_world(settings);
  }
}

}  // namespace panoptes::fuzz

// SPDX-License-Identifier: BSD-3-Clause
// Missions: mission.yaml beside what it names.
#include "apps/mission/mission.h"

#include <string>
#include <vector>

#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {

std::vector<std::string> words() {
  return with_yaml({"rig: ",
                    "robot: ",
                    "platform: ",
                    "{kind: simulated, ",
                    "{kind: recorded, ",
                    "world: w.yaml",
                    "data:worlds/office.yaml",
                    "data:rigs/front-back-floor.yaml",
                    "data:robots/pioneer3dx.yaml",
                    "seed: ",
                    "until: {duration_s: 600}",
                    "drive: navigator",
                    "drive: {route: r.yaml}",
                    "require: [\"collisions == 0\"]",
                    "navigator: {",
                    "keyframe: {distance_m: 0.25}",
                    "start: {x_m: 1",
                    "mounting_error: ",
                    "nominal_rig: rig.yaml",
                    "lens_error: ",
                    "clock_error: ",
                    "exactly: {front: ",
                    "faults: [{fault: knock, at_s: 1, yaw_deg: 1}]",
                    "sigma: {rotation_deg: [1, 2, 3]}",
                    "wheel_error: ",
                    "cameras:\n",
                    "intrinsics",
                    "sha256:"});
}

void read_input(std::string_view bytes) {
  const std::filesystem::path folder = written_files(bytes);
  const std::string file = (folder / "mission.yaml").string();
  const auto mission = load_mission<ExploreMission>(file);
  const std::string written = write_settings(mission);
  if (write_settings(read_settings_text<ExploreMission>(written, file)) != written) {
    throw std::runtime_error("settings do not read back");
  }
}

}  // namespace panoptes::fuzz

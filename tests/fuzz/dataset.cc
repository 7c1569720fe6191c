// SPDX-License-Identifier: BSD-3-Clause
// Recordings: the tables and settings of a dataset.
#include "core/io/dataset.h"

#include <set>
#include <string>
#include <vector>

#include "core/io/dataset_gaps.h"
#include "core/io/euroc_truth.h"
#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {

std::vector<std::string> words() {
  return {"#timestamp [ns],filename\n",
          "1000000000,",
          ",deadline,,\n",
          ",now,,",
          ",bumper,,1\n",
          ",motors,,0\n",
          ",picture,front,",
          ",missing,front,\n",
          ",contact,,\n",
          "\n",
          ",",
          "nan",
          "inf",
          "-1",
          "9223372036854775807",
          "9223372036854775808",
          "0x1",
          "..",
          "a/b.png",
          "=== mav0/odom0/data.csv\n",
          "=== mav0/cmd0/data.csv\n",
          "=== mav0/events.csv\n",
          "=== recording.yaml\n",
          "=== rig.yaml\n",
          "=== mav0/front/data.csv\n",
          "=== mav0/state_groundtruth_estimate0/data.csv\n",
          "1700000000000000000,",
          "\r\n",
          "\"",
          "#"};
}

void read_input(std::string_view bytes) {
  const std::map<std::string, std::string> files = files_in(bytes);
  std::set<std::string> cameras;
  for (const auto& [name, text] : files) {
    const std::string_view folder = "mav0/";
    const std::size_t end = name.rfind("/data.csv");
    if (name.starts_with(folder) && end != std::string::npos && end > folder.size()) {
      const std::string camera = name.substr(folder.size(), end - folder.size());
      if (camera != "odom0" && camera != "cmd0" && camera != "state_groundtruth_estimate0") {
        cameras.insert(camera);
      }
    }
  }
  const auto text = [&files](const std::string& name) -> std::optional<std::string> {
    const auto found = files.find(name);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  };
  read_euroc_truth("recording", text);
  const Dataset dataset = parse_dataset("recording", {cameras.begin(), cameras.end()}, text);
  gap_lines(dataset, dataset.believed.rig.value_or(Rig()));
}

}  // namespace panoptes::fuzz

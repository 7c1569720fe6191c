// SPDX-License-Identifier: BSD-3-Clause
// Pose graphs of g2o and TORO, and what relaxation makes of those that are read.
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/io/graph_file.h"
#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {

std::vector<std::string> words() {
  return {"VERTEX_SE2 0 0 0 0\n",
          "VERTEX_SE2 ",
          "EDGE_SE2 ",
          "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
          "FIX 0\n",
          "VERTEX2 ",
          "EDGE2 ",
          "EDGE2 0 1 1 0 0 1 0 1 1 0 0\n",
          "EQUIV 0 1\n",
          "VERTEX_SE3:QUAT ",
          "# remark\n",
          "nan",
          "-inf",
          "1e308",
          "1e-308",
          "1e9",
          "-0",
          "0x1",
          "2147483647",
          "2147483648",
          "\r\n",
          "\t"};
}

void read_input(std::string_view bytes) {
  constexpr std::size_t kMostNodes = 60;  // more take longer than they are worth
  GraphFile file = parse_graph("graph.g2o", bytes);
  if (file.graph.T_map_node.size() <= kMostNodes) {
    relax(file.graph);
  }
}

}  // namespace panoptes::fuzz

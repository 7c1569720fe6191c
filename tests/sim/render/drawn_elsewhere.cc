// SPDX-License-Identifier: BSD-3-Clause
// Draws a few pictures in a process of its own and prints a hash of them.
#include <cstdint>
#include <cstdlib>
#include <iostream>

#include "core/base/error.h"
#include "tests/sim/render/flag_world.h"

namespace {

std::uint64_t hash_of(const cv::Mat& picture) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (std::size_t i = 0; i < picture.total() * picture.elemSize(); ++i) {
    hash = (hash ^ picture.data[i]) * 1099511628211ULL;
  }
  return hash;
}

}  // namespace

int main() {
  using panoptes::sim::ahead;
  panoptes::sim::set_render_threads(2);
  try {
    panoptes::sim::Renderer renderer(panoptes::sim::flag_world());
    std::uint64_t hash = 0;
    for (int i = 0; i < 4; ++i) {
      const panoptes::sim::Drawn drawn =
          renderer.draw(ahead(0.3 + 0.2 * i, 0.1 * i), {.floor_label = i % 2 == 0, .depth = true});
      hash = hash * 31 + hash_of(drawn.bgr) + hash_of(drawn.depth_m);
    }
    std::cout << "LP_NUM_THREADS=" << std::getenv("LP_NUM_THREADS") << " pictures=" << hash << "\n";
  } catch (const panoptes::DeviceError& error) {
    std::cout << error.what() << "\n";
  }
  return 0;
}

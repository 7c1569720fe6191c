// SPDX-License-Identifier: BSD-3-Clause
// Draws a few pictures in a process of its own and prints a hash of them.
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

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

std::string setting(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

int main() {
  using namespace panoptes::sim;  // NOLINT(google-build-using-namespace)
  const std::string threads = setting("PANOPTES_TEST_THREADS");
  set_render_threads(threads.empty() ? 2 : std::stoi(threads));
  if (!setting("PANOPTES_TEST_SAME").empty()) {
    set_same_on_every_processor();
  }
  const std::string painter = setting("PANOPTES_TEST_PAINTER");
  std::vector<PainterKind> painters{painter == "egl"      ? PainterKind::kEgl
                                    : painter == "osmesa" ? PainterKind::kOsMesa
                                                          : PainterKind::kSoftware};
  if (painter == "osmesa and egl") {
    painters = {PainterKind::kOsMesa, PainterKind::kEgl};
  }
  try {
    World world = flag_world();
    world.ambient = 0.4;
    world.lights = {{{1, 1, 2.2}, {0.5, 0.3}, {0, 0, -1}, 2.0, ""}};
    std::vector<std::unique_ptr<Renderer>> renderers;
    for (const PainterKind kind : painters) {
      RendererOptions options;
      options.painter = kind;
      options.narrow_vectors = !setting("PANOPTES_TEST_SAME").empty();
      renderers.push_back(std::make_unique<Renderer>(world, options));
    }
    std::uint64_t hash = 0;
    for (int i = 0; i < 4; ++i) {
      const RenderOutputs outputs{.floor_label = i % 2 == 0, .depth = true, .instance = i % 3 == 0};
      std::uint64_t picture = 0;
      for (const auto& renderer : renderers) {
        const RenderedImage rendered = renderer->draw(ahead(0.3 + 0.2 * i, 0.1 * i), outputs);
        picture = hash_of(rendered.bgr) + 3 * hash_of(rendered.depth_m) +
                  5 * hash_of(rendered.instance) + 7 * hash_of(rendered.floor_label);
      }
      hash = hash * 31 + picture;
    }
    std::cout << "threads=" << render_threads()
              << " LP_NUM_THREADS=" << std::getenv("LP_NUM_THREADS") << " pictures=" << hash
              << "\n";
  } catch (const panoptes::DeviceError& error) {
    std::cout << error.what() << "\n";
  }
  return 0;
}

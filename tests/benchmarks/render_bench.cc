// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <string>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "sim/render/renderer.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"

namespace panoptes::sim {
namespace {

const World& office() {
  static const World world =
      load_world(std::string(PANOPTES_SOURCE_DIR) + "/scenes/worlds/office.yaml");
  return world;
}

/// The three cameras of the first rig, in turn at places in the aisles of the office; the last one
/// with its floor label. The CPU time of all threads counts.
void rig_of_three(benchmark::State& state) {
  cv::setNumThreads(1);
  set_render_threads(2);
  static Renderer renderer(office());
  const auto width_px = static_cast<int>(state.range(0));
  const Intrinsics intrinsics = pinhole(width_px, width_px * 3 / 4, deg_to_rad(80));
  const std::array<Pose3, 3> T_body_camera{mounted_camera({0.02, 0, 0.78}, 0, 0),
                                           mounted_camera({-0.02, 0, 0.78}, deg_to_rad(180), 0),
                                           mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28))};
  int k = 0;
  for (auto _ : state) {
    // Along the aisle at x = 5 m from south to north, turning on the way.
    const Pose2 T_scene_body{5.0, 1.2 + 7.6 * (k % 50) / 50.0, 0.5 * k};
    ++k;
    for (std::size_t i = 0; i < T_body_camera.size(); ++i) {
      benchmark::DoNotOptimize(renderer.draw(
          {intrinsics, on_floor(T_scene_body) * T_body_camera[i]}, {.floor_label = i == 2}));
    }
  }
}
BENCHMARK(rig_of_three)->Arg(320)->Arg(640)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

void body_layer(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(occupancy(office(), kFloorLayerTop_m, 0.8, 0.01));
  }
}
BENCHMARK(body_layer)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes::sim

BENCHMARK_MAIN();

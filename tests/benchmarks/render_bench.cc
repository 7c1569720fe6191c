// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "sim/render/lightmap.h"
#include "sim/render/renderer.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"

namespace panoptes::sim {
namespace {

constexpr std::size_t kTriangles = 38000;
constexpr double kFurniture_m = 2;  // longer edges are walls, floors, ceilings

const World& office() {
  static const World world = load_world(PANOPTES_SOURCE_DIR "/scenes/worlds/office.yaml");
  return world;
}

std::size_t triangles_of(const World& world) {
  std::size_t count = 0;
  for (const Object& object : world.objects) {
    count += object.triangles.size();
  }
  return count;
}

double longest_edge_m(const Triangle& t) {
  double longest_m = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    longest_m =
        std::max(longest_m, (t.corners[i].p_object - t.corners[(i + 1) % 3].p_object).norm());
  }
  return longest_m;
}

/// A triangle of furniture as four.
void cut_in_four(const Triangle& t, std::vector<Triangle>& out) {
  std::array<Corner, 3> middles;
  for (std::size_t i = 0; i < 3; ++i) {
    const Corner& a = t.corners[i];
    const Corner& b = t.corners[(i + 1) % 3];
    middles[i] = {(a.p_object + b.p_object) / 2, (a.uv + b.uv) / 2};
  }
  for (std::size_t i = 0; i < 3; ++i) {
    out.push_back({{t.corners[i], middles[i], middles[(i + 2) % 3]}, t.texture});
  }
  out.push_back({middles, t.texture});
}

/// The office with its furniture in finer triangles: some 40 thousand.
const World& fine_office() {
  static const World world = [] {
    World fine = office();
    while (triangles_of(fine) < kTriangles) {
      for (Object& object : fine.objects) {
        std::vector<Triangle> cut;
        for (const Triangle& t : object.triangles) {
          if (longest_edge_m(t) > kFurniture_m) {
            cut.push_back(t);
          } else {
            cut_in_four(t, cut);
          }
        }
        object.triangles = std::move(cut);
      }
    }
    return fine;
  }();
  return world;
}

template <PainterKind painter>
Renderer& fine_renderer() {
  cv::setNumThreads(1);
  set_render_threads(2);
  static Renderer renderer = [] {
    RendererOptions options;
    options.painter = painter;
    return Renderer(fine_office(), options);
  }();
  return renderer;
}

/// The k-th picture of three cameras, ahead, back and down on the floor, along the aisle at x = 5 m
/// from south to north, turning on the way.
View aisle_view(int k, int width_px) {
  static const std::array<Pose3, 3> T_body_camera{
      mounted_camera({0.02, 0, 0.78}, 0, 0), mounted_camera({-0.02, 0, 0.78}, deg_to_rad(180), 0),
      mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28))};
  const int set = k / 3;
  const Pose2 T_scene_body{5.0, 1.2 + 7.6 * (set % 50) / 50.0, 0.5 * set};
  return {pinhole(width_px, width_px * 3 / 4, deg_to_rad(80)),
          on_floor(T_scene_body) * T_body_camera[static_cast<std::size_t>(k % 3)]};
}

/// One picture; the CPU time of all threads counts.
template <PainterKind painter>
void draw_pictures(benchmark::State& state, const RenderOutputs& outputs) {
  Renderer& renderer = fine_renderer<painter>();
  int k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        renderer.draw(aisle_view(k++, static_cast<int>(state.range(0))), outputs));
  }
  state.counters["triangles"] = static_cast<double>(triangles_of(fine_office()));
}

void picture(benchmark::State& state) { draw_pictures<PainterKind::kSoftware>(state, {}); }
BENCHMARK(picture)->Arg(320)->Arg(640)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

void picture_by_osmesa(benchmark::State& state) { draw_pictures<PainterKind::kOsMesa>(state, {}); }
BENCHMARK(picture_by_osmesa)
    ->Arg(320)
    ->Arg(640)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

/// The same with floor label, instance and depth.
void picture_with_labels(benchmark::State& state) {
  draw_pictures<PainterKind::kSoftware>(state,
                                        {.floor_label = true, .depth = true, .instance = true});
}
BENCHMARK(picture_with_labels)
    ->Arg(320)
    ->Arg(640)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

/// The first picture of a process whose light and shadow are known: from the world in memory.
void first_picture(benchmark::State& state) {
  fine_renderer<PainterKind::kSoftware>();
  for (auto _ : state) {
    Renderer renderer(fine_office());
    benchmark::DoNotOptimize(renderer.draw(aisle_view(0, 320)));
  }
}
BENCHMARK(first_picture)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

void bake(benchmark::State& state) {
  const Charts charts = make_charts(office(), RendererOptions().lightmap_cell_m);
  for (auto _ : state) {
    benchmark::DoNotOptimize(bake_light(office(), charts, 2));
  }
}
BENCHMARK(bake)->MeasureProcessCPUTime()->Iterations(1)->Unit(benchmark::kSecond);

void body_layer(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(occupancy(office(), kFloorLayerTop_m, 0.8, 0.01));
  }
}
BENCHMARK(body_layer)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes::sim

BENCHMARK_MAIN();

// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/map/contours.h"
#include "core/map/floor_mapper.h"
#include "core/map/fusion.h"
#include "core/map/keyframe_grid.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

FloorScene office_scene() {
  FloorScene scene;
  scene.carpet = {Vec3(110, 95, 85), 0.1, 1};
  scene.second_carpet = {Vec3(70, 90, 120), 0.12, 2};
  scene.seam_x_m = 2.6;
  scene.contact_shade = 0.3;
  const Surface wood{Vec3(90, 140, 185), 0.12, 3};
  scene.boxes = {{Vec2(1.6, 0.6), Vec2(2.4, 2), 0.72, wood},
                 {Vec2(1.8, -2), Vec2(2.4, -0.9), 0.72, wood},
                 {Vec2(4.2, -3), Vec2(4.4, 3), 0.72, wood}};
  return scene;
}

std::vector<FloorReading> readings(int count) {
  Rng rng(1);
  const RigCamera camera = office_floor_camera();
  FloorMapper mapper({}, camera, {});
  std::vector<FloorReading> out;
  for (int i = 0; i < count; ++i) {
    const Pose2 T{0.027 * i, 0, 0};
    out.push_back(mapper.read(draw(office_scene(), camera, T, rng), T, true));
  }
  return out;
}

void ReadPicture(benchmark::State& state) {
  Rng rng(1);
  const RigCamera camera = office_floor_camera();
  std::vector<cv::Mat> pictures;
  constexpr int kPictures = 30;
  for (int i = 0; i < kPictures; ++i) {
    pictures.push_back(draw(office_scene(), camera, {0.027 * i, 0, 0}, rng));
  }
  FloorMapper mapper({}, camera, {});
  int frame = 0;
  for (auto _ : state) {
    const int i = frame++ % kPictures;
    benchmark::DoNotOptimize(
        mapper.read(pictures[static_cast<std::size_t>(i)], {0.027 * i, 0, 0}, true));
  }
}
BENCHMARK(ReadPicture)->Unit(benchmark::kMillisecond);

void AddReading(benchmark::State& state) {
  const std::vector<FloorReading> seen = readings(1);
  int i = 0;
  KeyframeGrid grid;
  for (auto _ : state) {
    grid.add(seen[0], {0.03 * (i % 8), 0, 0.05 * (i % 7)});
    ++i;
  }
}
BENCHMARK(AddReading)->Unit(benchmark::kMillisecond);

std::shared_ptr<const GridCrop> one_keyframe() {
  KeyframeGrid grid;
  const std::vector<FloorReading> seen = readings(9);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    grid.add(seen[i], {0.027 * static_cast<double>(i), 0, 0});
  }
  return std::make_shared<GridCrop>(grid.crop());
}

void UpdateLocalMap(benchmark::State& state) {
  const std::vector<FloorReading> seen = readings(1);
  LocalMap local(0.02, 3.5, 5);
  const auto crop = one_keyframe();
  for (int i = 0; i < 5; ++i) {
    local.close(crop, {0.25 * i, 0, 0.1 * i});
  }
  KeyframeGrid open;
  open.add(seen[0], {});
  for (auto _ : state) {
    benchmark::DoNotOptimize(local.map(open, {1.25, 0, 0.5}, Vec2(1.3, 0)));
  }
}
BENCHMARK(UpdateLocalMap)->Unit(benchmark::kMillisecond);

std::vector<PlacedGrid> a_tour(int keyframes) {
  const auto crop = one_keyframe();
  std::vector<PlacedGrid> placed;
  for (int i = 0; i < keyframes; ++i) {
    const double a = 0.1 * i;
    placed.push_back({crop, {3 * std::cos(a), 3 * std::sin(a), a}});
  }
  return placed;
}

void FuseOneKeyframe(benchmark::State& state) {
  const std::vector<PlacedGrid> placed = a_tour(1);
  EvidenceSum sum(0.01 * static_cast<double>(state.range(0)));
  for (auto _ : state) {
    sum.add(placed[0]);
    sum.subtract(placed[0]);
  }
  state.counters["bytes"] = static_cast<double>(placed[0].grid->cells.size());
}
BENCHMARK(FuseOneKeyframe)->Arg(1)->Arg(2)->Arg(5)->Unit(benchmark::kMillisecond);

void FuseWholeRun(benchmark::State& state) {
  const std::vector<PlacedGrid> placed = a_tour(1500);
  for (auto _ : state) {
    benchmark::DoNotOptimize(fuse(placed, 0.01));
  }
}
BENCHMARK(FuseWholeRun)->Unit(benchmark::kMillisecond)->Iterations(1);

void AlignContours(benchmark::State& state) {
  const OccupancyMap map = fuse(a_tour(4), 0.02);
  const std::vector<Vec2> contour = obstacle_contour(map);
  for (auto _ : state) {
    benchmark::DoNotOptimize(align_contours({}, contour, contour, {0.2, -0.1, 0.05}));
  }
  state.counters["points"] = static_cast<double>(contour.size());
}
BENCHMARK(AlignContours)->Unit(benchmark::kMillisecond);

void FindContour(benchmark::State& state) {
  const OccupancyMap map = fuse(a_tour(4), 0.02);
  for (auto _ : state) {
    benchmark::DoNotOptimize(obstacle_contour(map));
  }
}
BENCHMARK(FindContour)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes

BENCHMARK_MAIN();

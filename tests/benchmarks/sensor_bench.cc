// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "sim/render/renderer.h"
#include "sim/sensors/camera_sensor.h"
#include "sim/sensors/lens_view.h"
#include "sim/sensors/sensor_response.h"
#include "sim/world/load.h"

namespace panoptes::sim {
namespace {

enum Lens : int { kPlain, kBarrel, kWide, kFisheye };

Intrinsics lens_of(benchmark::State& state) {
  const auto width_px = static_cast<int>(state.range(0));
  const int height_px = width_px * 3 / 4;
  switch (state.range(1)) {
    case kBarrel:
      state.SetLabel("Brown-Conrady, 80 degrees");
      return lens_of_view(width_px, height_px, deg_to_rad(80),
                          BrownConrady{-0.25, 0.06, 0.0005, -0.0005, 0});
    case kWide:
      state.SetLabel("equidistant, 130 degrees");
      return lens_of_view(width_px, height_px, deg_to_rad(130), Equidistant{});
    case kFisheye:
      state.SetLabel("equidistant, 180 degrees");
      return lens_of_view(width_px, height_px, deg_to_rad(180), Equidistant{});
    default:
      state.SetLabel("pinhole, 80 degrees");
      return pinhole(width_px, height_px, deg_to_rad(80));
  }
}

RenderedImage rendered(const View& view, const RenderOutputs& outputs) {
  static Renderer renderer = [] {
    set_render_threads(2);
    return Renderer(load_world(PANOPTES_SOURCE_DIR "/scenes/worlds/office.yaml"));
  }();
  return renderer.draw(view, outputs);
}

// Along the aisle at x = 5 m from south to north, turning on the way.
Pose3 stop(int k) {
  return on_floor({5.0, 1.2 + 7.6 * (k % 50) / 50.0, 0.5 * k}) *
         mounted_camera({0.02, 0, 0.78}, 0, 0);
}

/// What one picture costs by its lens alone. The CPU time of all threads counts.
void lens(benchmark::State& state) {
  cv::setNumThreads(1);
  LensView view(lens_of(state));
  int k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(view.draw(rendered, stop(k++), 1, {}));
  }
}
BENCHMARK(lens)
    ->ArgsProduct({{320, 640}, {kPlain, kBarrel, kWide, kFisheye}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

/// The same with truth.
void lens_and_truth(benchmark::State& state) {
  cv::setNumThreads(1);
  LensView view(lens_of(state));
  int k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        view.draw(rendered, stop(k++), 1, {.floor_label = true, .depth = true, .instance = true}));
  }
}
BENCHMARK(lens_and_truth)
    ->ArgsProduct({{320, 640}, {kPlain, kBarrel}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

/// Exposure, vignetting and noise of a colour picture, and its metering.
void effects(benchmark::State& state) {
  cv::setNumThreads(1);
  SensorOptions options;
  options.exposure = AutoExposure{};
  const auto width_px = static_cast<int>(state.range(0));
  const Intrinsics lens = pinhole(width_px, width_px * 3 / 4, deg_to_rad(80));
  CameraSensor camera("front", lens, options, Rng(1));
  const cv::Mat grey(lens.height_px, lens.width_px, CV_8UC3, cv::Scalar(90, 110, 130));
  cv::Mat picture;
  const CameraSensor::Draw draw = [&](const View&, const RenderOutputs&) {
    RenderedImage out;
    out.bgr = picture;
    return out;
  };
  std::int64_t number = 0;
  for (auto _ : state) {
    state.PauseTiming();
    grey.copyTo(picture);
    state.ResumeTiming();
    benchmark::DoNotOptimize(camera.take(draw, [](Duration) { return Pose3(); }, number++, {}));
  }
}
BENCHMARK(effects)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);

/// A whole picture with the default sensor, exposed for 2 ms, of a camera that drives at 0.4 m/s
/// and turns at 0.4 rad/s.
void picture(benchmark::State& state) {
  cv::setNumThreads(1);
  SensorOptions options;
  options.exposure = FixedExposure{};
  CameraSensor camera("front", lens_of(state), options, Rng(1));
  int k = 0;
  for (auto _ : state) {
    const Pose3 here = stop(k);
    const auto at = [&here](Duration after) {
      const double s = to_seconds(after);
      Pose3 T_here_there{Eigen::Quaterniond(Eigen::AngleAxisd(-0.4 * s, Vec3::UnitY())),
                         Vec3(0, 0, 0.4 * s)};
      return here * T_here_there;
    };
    benchmark::DoNotOptimize(camera.take(rendered, at, k++, {}));
  }
}
BENCHMARK(picture)
    ->ArgsProduct({{320, 640}, {kPlain, kBarrel, kWide, kFisheye}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes::sim

BENCHMARK_MAIN();

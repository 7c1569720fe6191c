// SPDX-License-Identifier: BSD-3-Clause
//
// The simulator without a navigator: the office, three cameras of 320x240 at 15 Hz with exposure,
// vignetting and noise, the robot turning where the seed puts it. One iteration is one frame set.
// `real_time_factor` is simulated over wall time, `cpu_factor` simulated over CPU time.
//
//   sim_bench --benchmark_filter=frame_sets                       both cores: real_time_factor >= 6
//   taskset -c 0 sim_bench --benchmark_filter=frame_sets          one core: real_time_factor >= 4
//   for i in 1 2; do taskset -c $((i - 1)) sim_bench --benchmark_filter=frame_sets/1 & done; wait
//                      two processes: the sum of their factors >= 1.8 times that of one on one core
//   sim_bench --benchmark_filter=memory      peak memory after 2 and after 20 simulated minutes
#include <chrono>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>
#include <sys/resource.h>

#include "core/config/fields.h"
#include "core/config/geometry_fields.h"
#include "sim/simulated_robot.h"

namespace panoptes::sim {
namespace {

const std::string kScenes = PANOPTES_SOURCE_DIR "/scenes/";

enum Case : int { kPinhole, kBlur, kLens };

std::unique_ptr<SimulatedRobot> robot_of(int which) {
  cv::setNumThreads(1);
  set_render_threads(2);
  static const World world = load_world(kScenes + "worlds/office.yaml");
  static const Surroundings office = surroundings(world, Body{});
  Rig rig = read_settings<Rig>(kScenes + "rigs/front-back-floor.yaml");
  if (which == kLens) {
    for (auto& [name, camera] : rig.cameras) {
      camera.intrinsics.distortion = BrownConrady{-0.25, 0.08, 0.0005, -0.0003, 0};
    }
  }
  SimulatedOptions options = as_believed({});  // the lenses are those that are named
  options.sensor.exposure = AutoExposure{};
  options.sensor.motion_blur = which == kBlur;
  auto robot = std::make_unique<SimulatedRobot>(options, office, Body{}, rig, Rng(1));
  return robot;
}

/// One frame set, turning slowly all the while.
Observation turn_and_look(SimulatedRobot& robot) {
  robot.drive({0, 0.5}, std::chrono::seconds(1));
  return robot.observe(robot.now() + std::chrono::seconds(1));
}

double cpu_s() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

void frame_sets(benchmark::State& state) {
  const auto made = robot_of(static_cast<int>(state.range(0)));
  SimulatedRobot& robot = *made;
  turn_and_look(robot);  // what is made once
  const Time start = robot.now();
  const double start_cpu_s = cpu_s();
  const auto start_wall = std::chrono::steady_clock::now();
  for (auto _ : state) {
    benchmark::DoNotOptimize(turn_and_look(robot));
  }
  const double simulated_s = to_seconds(robot.now() - start);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_wall;
  state.counters["real_time_factor"] = simulated_s / wall.count();
  state.counters["cpu_factor"] = simulated_s / (cpu_s() - start_cpu_s);
}
BENCHMARK(frame_sets)
    ->ArgName("pinhole_blur_lens")
    ->Arg(kPinhole)
    ->Arg(kBlur)
    ->Arg(kLens)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->MinTime(5)
    ->Unit(benchmark::kMillisecond);

double peak_memory_mb() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / 1024;  // kB on Linux
}

void memory(benchmark::State& state) {
  for (auto _ : state) {
    const auto made = robot_of(kPinhole);
    SimulatedRobot& robot = *made;
    const auto run_until = [&](double minutes) {
      while (robot.now() < time_at(60 * minutes)) {
        turn_and_look(robot);
      }
      return peak_memory_mb();
    };
    state.counters["mb_after_2_min"] = run_until(2);
    state.counters["mb_after_20_min"] = run_until(20);
  }
}
BENCHMARK(memory)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace panoptes::sim

BENCHMARK_MAIN();

// SPDX-License-Identifier: BSD-3-Clause
// What the geometric scores of one rig cost. 200 000 rigs an hour on two cores are 36 ms of CPU
// time each.
#include <string>

#include <benchmark/benchmark.h>

#include "core/eval/rig_scores.h"

namespace panoptes {
namespace {

void score(benchmark::State& state, const std::string& rig_file) {
  const Rig rig = read_settings<Rig>(PANOPTES_SOURCE_DIR "/scenes/rigs/" + rig_file + ".yaml");
  const Body body;
  const RigScoreOptions options;
  for (auto _ : state) {
    benchmark::DoNotOptimize(placement_faults(rig, body));
    benchmark::DoNotOptimize(score_rig(options, rig, body));
  }
  state.counters["rigs_an_hour_on_two_cores"] = benchmark::Counter(
      2 * 3600.0 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(score, two_cameras, "front-alone")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(score, three_cameras, "front-back-floor")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(score, five_cameras, "four-corners")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(score, seven_cameras, "front-back-floor-corners")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(score, fisheye, "fisheye-up")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes

BENCHMARK_MAIN();

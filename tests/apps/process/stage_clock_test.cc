// SPDX-License-Identifier: BSD-3-Clause
#include "apps/process/stage_clock.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kBusy_ms = 20;  // far above what an idle stage costs
constexpr double kIdle_ms = 5;   // of CPU time while a stage sleeps: switches of threads alone
constexpr double kRoundoff = 1e-9;

void compute_for(double ms) {
  const double until_s = steady_s() + ms * 1e-3;
  while (steady_s() < until_s) {
  }
}

TEST(StageClock, CountsCpuTimeApartFromWallTime) {
  StageClock clock;
  for (int frame = 0; frame < 3; ++frame) {
    {
      const TimedStage stage(clock, "asleep");
      std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(kBusy_ms)));
    }
    clock.end_frame();
  }
  const StageFigures asleep = clock.figures().at("asleep");
  EXPECT_GE(asleep.p50_ms, kBusy_ms);
  EXPECT_LT(asleep.cpu_p99_ms, kIdle_ms);
}

TEST(StageClock, TellsTheWorstFramesFromTheMean) {
  StageClock clock;
  constexpr int kFrames = 10;
  for (int frame = 0; frame < kFrames; ++frame) {
    if (frame == 4) {  // a stage that runs in one frame set alone counts nothing in the others
      const TimedStage stage(clock, "seldom");
      compute_for(kBusy_ms);
    }
    clock.end_frame();
  }
  const StageFigures seldom = clock.figures().at("seldom");
  EXPECT_GT(seldom.cpu_mean_ms, 0);
  EXPECT_GT(seldom.cpu_p99_ms, 2 * seldom.cpu_mean_ms);
  EXPECT_LE(seldom.cpu_p99_ms, kFrames * seldom.cpu_mean_ms + kRoundoff);
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "core/explore/explorer.h"
#include "core/nav/driver.h"
#include "core/plan/dwa.h"
#include "core/plan/path_search.h"
#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

/// 12 x 12 m on 1 cm cells: rows of desks with aisles of 0.9 m, and one third not seen yet.
OccupancyMap office(bool whole) {
  OccupancyMap map = test::empty_room(12, 12, 0.01);
  for (double y = 1; y < 10.5; y += 2.4) {
    test::fill(map, 1, y, 5.3, y + 1.5, Cell::kOccupied);
    test::fill(map, 6.7, y, 11, y + 1.5, Cell::kOccupied);
  }
  if (!whole) {
    test::fill(map, 0, 8, 12, 12, Cell::kUnknown);
  }
  return map;
}

void search_across_the_office(benchmark::State& state) {
  const OccupancyMap map = office(true);
  const SearchOptions options;
  const Body body;
  for (auto _ : state) {
    const DrivableGrid grid = drivable_grid(options, body, map);
    benchmark::DoNotOptimize(search_path(options, grid, {0.5, 0.5}, {11.5, 11.5}));
  }
}
BENCHMARK(search_across_the_office)->Unit(benchmark::kMillisecond);

void choose_a_goal(benchmark::State& state) {
  const OccupancyMap map = office(false);
  const SearchOptions search;
  Explorer explorer({}, Body(), FloorWedge(), Rng(1));
  for (auto _ : state) {
    const DrivableGrid grid =
        drivable_grid_of_coarse(search, Body(), coarsen(map, search.cell_m, explorer.border_m()));
    benchmark::DoNotOptimize(explorer.choose(Time(), grid, {6, 1, 0}));
  }
}
BENCHMARK(choose_a_goal)->Unit(benchmark::kMillisecond);

/// 36 x 36 m on 5 cm cells: rooms of 6 m with doorways of 0.9 m, and patches that nobody has seen.
OccupancyMap building() {
  OccupancyMap map = test::empty_room(36, 36, 0.05);
  for (double wall = 6; wall < 36; wall += 6) {
    test::fill(map, wall, 0, wall + 0.1, 36, Cell::kOccupied);
    test::fill(map, 0, wall, 36, wall + 0.1, Cell::kOccupied);
  }
  for (double wall = 6; wall < 36; wall += 6) {
    for (double door = 2; door < 36; door += 6) {
      test::fill(map, wall, door, wall + 0.1, door + 0.9, Cell::kFree);
      test::fill(map, door, wall, door + 0.9, wall + 0.1, Cell::kFree);
    }
  }
  for (double patch = 0.5; patch < 36; patch += 6) {
    test::fill(map, patch, 35.5 - patch, patch + 1.5, 36.5 - patch, Cell::kUnknown);
  }
  return map;
}

void search_across_a_building(benchmark::State& state) {
  const SearchOptions options;
  const DrivableGrid grid = drivable_grid(options, Body(), building());
  for (auto _ : state) {
    benchmark::DoNotOptimize(search_path(options, grid, {3, 3}, {33, 33}));
  }
}
BENCHMARK(search_across_a_building)->Unit(benchmark::kMillisecond);

void choose_a_goal_in_a_building(benchmark::State& state) {
  const SearchOptions search;
  Explorer explorer({}, Body(), FloorWedge(), Rng(1));
  const DrivableGrid grid = drivable_grid_of_coarse(
      search, Body(), coarsen(building(), search.cell_m, explorer.border_m()));
  for (auto _ : state) {
    benchmark::DoNotOptimize(explorer.choose(Time(), grid, {3, 3, 0}));
  }
}
BENCHMARK(choose_a_goal_in_a_building)->Unit(benchmark::kMillisecond);

constexpr std::chrono::milliseconds kFrame(67);

void dynamic_window(benchmark::State& state) {
  const OccupancyMap map = office(true);
  const DwaOptions options;
  DriveTask task;
  task.local_odom = &map;
  task.map = &map;
  task.T_odom_body = {6, 3, 1.5};
  DwaRequest request;
  request.T_odom_body = task.T_odom_body;
  request.twist_body = {0.4, 0.1};
  request.cycle_s = to_seconds(kFrame);
  request.longest_cycle_s = request.cycle_s;
  request.lookahead_odom = {6.1, 3.7};
  for (auto _ : state) {
    const ClearanceMap window =
        clearance_map(window_map(options.cell_m, options.window_m, task, {}, 0), 1.0);
    benchmark::DoNotOptimize(choose_arc(options, Body(), window, request));
  }
}
BENCHMARK(dynamic_window)->Unit(benchmark::kMillisecond);

void driver_step_with_a_plan(benchmark::State& state) {
  const OccupancyMap map = office(true);
  for (auto _ : state) {
    Driver driver({}, Body(), {kFrame, kFrame});
    DriveTask task;
    task.local_odom = &map;
    task.map = &map;
    task.T_odom_body = {6, 3, 1.5};
    task.goal = DriveGoal{{6, 11, 0}, false};
    benchmark::DoNotOptimize(driver.step(task));
  }
}
BENCHMARK(driver_step_with_a_plan)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes

BENCHMARK_MAIN();

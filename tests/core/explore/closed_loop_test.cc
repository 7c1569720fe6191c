// SPDX-License-Identifier: BSD-3-Clause
// Explorer and driver together in generated offices, with a floor camera that is all but perfect.
#include <gtest/gtest.h>

#include "tests/support/grid_world.h"

namespace panoptes {
namespace {

std::string story(const test::GridRun& run) {
  std::string text;
  for (const std::string& line : run.said) {
    text += line + "\n";
  }
  return text;
}

TEST(ClosedLoop, MapsOfficesWithoutTouchingAnything) {
  for (const std::uint64_t seed : {1}) {
    const Rng rng(seed);
    const test::GridWorld world = test::make_office(rng.fork("office"));
    const Pose2 start = test::draw_start(world, Body().radius_m, 0.45, rng.fork("start"));
    const test::GridRun run =
        test::explore_world(world, start, ExploreOptions(), DriverOptions(), {}, 600, rng);
    EXPECT_EQ(run.contacts, 0) << story(run);
    EXPECT_GE(run.coverage.back().second, 0.95) << story(run);
    EXPECT_TRUE(run.done_s) << story(run);
    EXPECT_LE(run.when(0.85).value_or(600), 250) << story(run);
  }
}

TEST(ClosedLoop, TouchesNothingThoughRangesAndPosesAreNoisy) {
  for (const std::uint64_t seed : {2}) {
    const Rng rng(seed);
    const test::GridWorld world = test::make_office(rng.fork("office"));
    const Pose2 start = test::draw_start(world, Body().radius_m, 0.45, rng.fork("start"));
    const test::GridRun run = test::explore_world(world, start, ExploreOptions(), DriverOptions(),
                                                  {0.01, 0.02, 0.015}, 600, rng);
    EXPECT_EQ(run.contacts, 0) << story(run);
    EXPECT_GE(run.coverage.back().second, 0.9) << story(run);
  }
}

TEST(ClosedLoop, PassesADoorwayThatIsNarrow) {
  for (const double gap_m : {0.7, 0.88}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Rng rng(seed);
      const test::GridWorld world = test::make_two_rooms(gap_m, rng.fork("rooms"));
      const Pose2 start = test::draw_start(world, Body().radius_m, 0.45, rng.fork("start"));
      const test::GridRun run = test::explore_world(world, start, ExploreOptions(), DriverOptions(),
                                                    {0.01, 0.01, 0.01}, 150, rng);
      EXPECT_EQ(run.contacts, 0) << gap_m << " " << seed << "\n" << story(run);
      EXPECT_GT(run.coverage.back().second, 0.8) << gap_m << " " << seed << "\n" << story(run);
    }
  }
}

TEST(ClosedLoop, RepeatsToTheBit) {
  const Rng rng(6);
  const test::GridWorld world = test::make_office(rng.fork("office"));
  const Pose2 start = test::draw_start(world, Body().radius_m, 0.45, rng.fork("start"));
  const auto run = [&] {
    return test::explore_world(world, start, ExploreOptions(), DriverOptions(), {0.01, 0.02, 0.015},
                               30, rng);
  };
  const test::GridRun first = run();
  const test::GridRun second = run();
  EXPECT_EQ(first.coverage, second.coverage);
  EXPECT_EQ(first.said, second.said);
}

}  // namespace
}  // namespace panoptes

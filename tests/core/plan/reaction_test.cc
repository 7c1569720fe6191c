// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/reaction.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

using std::chrono::milliseconds;

TEST(Reaction, IsWhatThePlatformStatesBeforeAnythingIsMeasured) {
  const Reaction reaction({milliseconds(100), milliseconds(250)});
  EXPECT_DOUBLE_EQ(reaction.cycle_s(), 0.1);
  EXPECT_DOUBLE_EQ(reaction.lag_s(), 0.25);
  EXPECT_DOUBLE_EQ(reaction.reaction_s(), 0.35);
}

TEST(Reaction, TakesTheCycleAsItIsMeasured) {
  Reaction reaction({milliseconds(100), milliseconds(250)});
  for (int i = 0; i <= 20; ++i) {
    reaction.decide(time_at(0.05 * i));
  }
  EXPECT_NEAR(reaction.cycle_s(), 0.05, 1e-9);
  EXPECT_NEAR(reaction.lag_s(), 0.25, 1e-9);  // quicker decisions deliver nothing sooner
  EXPECT_NEAR(reaction.reaction_s(), 0.30, 1e-9);
}

TEST(Reaction, CountsALateDecisionUntilItIsFiveSecondsOld) {
  Reaction reaction({milliseconds(100), milliseconds(250)});
  double t = 0;
  const auto decide_for = [&](double s) {
    for (const double end = t + s; t < end;) {
      reaction.decide(time_at(t += 0.1));
    }
  };
  decide_for(2);
  reaction.decide(time_at(t += 0.5));
  EXPECT_NEAR(reaction.cycle_s(), 0.1, 1e-9);       // as a rule
  EXPECT_NEAR(reaction.lag_s(), 0.25 + 0.4, 1e-9);  // the decision took so much too long
  EXPECT_NEAR(reaction.reaction_s(), 0.65 + 0.5, 1e-9);
  decide_for(4.5);
  EXPECT_NEAR(reaction.reaction_s(), 1.15, 1e-9);
  decide_for(1);
  EXPECT_NEAR(reaction.reaction_s(), 0.35, 1e-9);
}

TEST(Reaction, CountsTheSameInstantOnce) {
  Reaction reaction({milliseconds(100), milliseconds(250)});
  for (int i = 0; i < 5; ++i) {
    reaction.decide(time_at(1));
  }
  EXPECT_DOUBLE_EQ(reaction.cycle_s(), 0.1);
}

TEST(Reaction, TheSpeedThatStopsInADistanceHasItAsItsStoppingDistance) {
  for (const double distance_m : {0.01, 0.3, 1.0, 7.0}) {
    for (const double reaction_s : {0.0, 0.07, 0.5}) {
      const double v = speed_that_stops_mps(distance_m, reaction_s, 0.6);
      EXPECT_NEAR(stopping_distance_m(v, reaction_s, 0.6), distance_m, 1e-12);
    }
  }
  EXPECT_EQ(speed_that_stops_mps(0, 0.1, 0.6), 0);
  EXPECT_EQ(speed_that_stops_mps(-1, 0.1, 0.6), 0);
  EXPECT_EQ(speed_that_stops_mps(0, 0, 0.6), 0);
}

}  // namespace
}  // namespace panoptes

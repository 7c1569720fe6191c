// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/report_clock.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "core/base/rng.h"

namespace panoptes::hw {
namespace {

constexpr double kCycle_s = 0.1;
constexpr double kRoundoff_s = 1e-8;  // of nanoseconds

/// A robot whose reports leave every cycle and arrive in order, held up or lost.
struct Reports {
  ReportClock clock;
  double cycle_s = kCycle_s;
  bool moves = true;
  int number = 0;
  int last = 0;
  double free_s = 0;  // nothing arrives before what left earlier

  double left_s() const { return number * cycle_s; }

  /// By how much the next one's stamp is late.
  double next(double held_up_s) {
    ++number;
    free_s = std::max(free_s, left_s() + held_up_s);
    const Time arrival = time_at(free_s);
    const double since_s = (number - last) * cycle_s;
    const ReportClock::Departure departure = clock.departure(
        arrival, moves ? ReportClock::Elapsed{since_s, since_s} : ReportClock::Elapsed{});
    clock.take(arrival, departure);
    last = number;
    return to_seconds(departure.stamp.time_since_epoch()) - left_s();
  }
  void lose(int count) { number += count; }
};

TEST(ReportClock, TakesPunctualReportsAsTheyArrive) {
  Reports reports;
  for (int i = 0; i < 500; ++i) {
    EXPECT_NEAR(reports.next(0.02), 0.02, kRoundoff_s);
  }
}

TEST(ReportClock, IsNotMovedByWhatIsHeldUp) {
  Reports reports;
  for (int i = 0; i < 50; ++i) {
    reports.next(0);
  }
  Rng rng(1);
  for (int i = 0; i < 3000; ++i) {
    EXPECT_NEAR(reports.next(i % 5 == 0 ? rng.uniform(0, 0.4) : 0), 0, 2e-3) << i;
  }
}

// Uniform up to 0.3 s, in order: one in seven is held up by less than 83 ms, in which 0.6 m/s are
// 5 cm.
TEST(ReportClock, FindsWhenReportsLeaveThoughEveryOneIsHeldUp) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Rng rng(seed);
    Reports reports;
    double worst_s = 0;
    for (int i = 0; i < 3000; ++i) {
      const double late_s = reports.next(rng.uniform(0, 0.3));
      worst_s = i < 50 ? 0 : std::max(worst_s, std::abs(late_s));
    }
    EXPECT_LT(worst_s, 0.083) << seed;
  }
}

// The end of a uniform distribution is nearer than the least of what was seen of it.
TEST(ReportClock, IsAsOftenEarlyAsLate) {
  double sum_s = 0;
  int count = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    Rng rng(seed);
    Reports reports;
    for (int i = 0; i < 3000; ++i) {
      const double late_s = reports.next(rng.uniform(0, 0.15));
      sum_s += i < 100 ? 0 : late_s;
      count += i < 100 ? 0 : 1;
    }
  }
  EXPECT_NEAR(sum_s / count, 0, 2e-3);
}

TEST(ReportClock, KnowsALinkThatIsOnTimeSoonAndOneThatHoldsUpLater) {
  Reports punctual;
  int few = 0;
  for (; !punctual.clock.settled(); ++few) {
    punctual.next(0.004);
  }
  EXPECT_EQ(few, 5);
  EXPECT_FALSE(punctual.clock.holds_up());
  EXPECT_LT(to_seconds(punctual.clock.longest_hold()), kRoundoff_s);
  Rng rng(4);
  Reports held_up;
  int many = 0;
  for (; !held_up.clock.settled(); ++many) {
    held_up.next(rng.uniform(0, 0.3));
  }
  EXPECT_GE(many, 40);
  EXPECT_LT(many, 50);  // it begins anew when it finds out
  EXPECT_TRUE(held_up.clock.holds_up());
  EXPECT_GT(to_seconds(held_up.clock.longest_hold()), 0.2);
  EXPECT_LT(to_seconds(held_up.clock.longest_hold()), 0.32);
}

TEST(ReportClock, FollowsAServersOwnCycle) {
  for (const double cycle_s : {0.099, 0.101}) {
    Rng rng(3);
    Reports reports;
    reports.cycle_s = cycle_s;
    for (int i = 0; i < 2000; ++i) {
      const double late_s = reports.next(rng.uniform(0, 0.004));
      EXPECT_TRUE(i < 60 || std::abs(late_s) < 0.012) << cycle_s << " " << i << " " << late_s;
    }
  }
}

TEST(ReportClock, TellsLostReportsFromThoseHeldUp) {
  for (const bool moves : {true, false}) {
    Rng rng(7);
    Reports reports;
    reports.moves = moves;
    for (int i = 0; i < 2000; ++i) {
      if (rng.uniform(0, 1) < 0.1) {
        reports.lose(1 + static_cast<int>(rng.uniform(0, 4)));
      }
      EXPECT_NEAR(reports.next(0.005), 0.005, 1e-6) << i;
    }
  }
}

// Half of the time the robot stands, and nothing tells how many were lost of reports that are held
// up as well. A count that is wrong is found out by those that follow.
TEST(ReportClock, FindsItsCountAgain) {
  for (const std::uint64_t seed : {100, 101, 102, 103, 104, 105}) {
    Rng rng(seed);
    Reports reports;
    int wrong = 0;
    for (int i = 0; i < 3000; ++i) {
      reports.moves = i % 100 < 50;
      if (rng.uniform(0, 1) < 0.005) {
        reports.lose(1 + static_cast<int>(rng.uniform(0, 5)));
      }
      wrong += std::abs(reports.next(rng.uniform(0, 0.3))) > 0.083 ? 1 : 0;
    }
    EXPECT_LT(wrong, 150) << seed;  // some 15 losses, each for no longer than a second
  }
}

TEST(ReportClock, NeverGoesBack) {
  Rng rng(5);
  ReportClock clock;
  Time arrival{};
  Time last(Duration(-1));
  for (int i = 0; i < 2000; ++i) {
    arrival += from_seconds(rng.uniform(0, 1) < 0.3 ? 0 : rng.uniform(0, 0.3));
    const ReportClock::Departure departure =
        clock.departure(arrival, {rng.uniform(0, 0.5), rng.uniform(0.5, 2)});
    EXPECT_GT(departure.stamp, last);
    last = departure.stamp;
    clock.take(arrival, departure);
  }
}

}  // namespace
}  // namespace panoptes::hw

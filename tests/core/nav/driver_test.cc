// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/driver.h"

#include <cmath>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr double kFrame_s = 1.0 / 15;
const Timing kTiming{from_seconds(kFrame_s), from_seconds(kFrame_s)};

/// A disc that does as it is told a frame later, within its limits; odom is map unless set apart.
struct Ride {
  OccupancyMap map = test::empty_room(6, 4, 0.02);
  OccupancyMap local;  // what the driver is shown; the map itself unless changed
  Pose2 T_map_odom;
  Pose2 T_map_body{1, 2, 0};
  Twist2 twist;
  Twist2 pending;
  Time now;
  Body body;
  Driver driver{DriverOptions(), Body(), kTiming};
  bool bumper = false;
  bool held = false;  // something holds the robot: the wheels stand
  double frame_s = kFrame_s;
  double latency_s = kFrame_s;                     // from an observation until a command acts
  std::deque<std::pair<double, Twist2>> commands;  // when they act, latest last
  double least_v_mps = 0;
  double most_v_mps = 0;
  double least_gap_m = 1e9;

  DriveStep step(const std::optional<DriveGoal>& goal) {
    DriveTask task;
    task.stamp = now;
    task.local_odom = &local;
    task.map = &map;
    task.T_map_odom = T_map_odom;
    task.T_odom_body = T_map_odom.inverse() * T_map_body;
    task.twist_body = twist;
    task.bumper_pressed = bumper;
    task.goal = goal;
    DriveStep out = driver.step(task);
    commands.emplace_back(to_seconds(now) + latency_s, out.command_body);
    const int parts = static_cast<int>(std::lround(8 * frame_s / kFrame_s));
    for (int i = 0; i < parts; ++i) {
      const double dt = frame_s / parts;
      while (!commands.empty() && commands.front().first <= to_seconds(now) + i * dt + 1e-6) {
        pending = commands.front().second;
        commands.pop_front();
      }
      const auto towards = [](double from, double to, double most) {
        return from + std::clamp(to - from, -most, most);
      };
      twist.v_mps = towards(twist.v_mps, pending.v_mps, body.max_accel_mps2 * dt);
      twist.w_radps = towards(twist.w_radps, pending.w_radps, body.max_turn_accel_radps2 * dt);
      if (held) {
        twist = {};
      }
      T_map_body = T_map_body * exp_twist(twist, dt);
    }
    now = now + from_seconds(frame_s);
    most_v_mps = std::max(most_v_mps, twist.v_mps);
    least_v_mps = std::min(least_v_mps, twist.v_mps);
    return out;
  }

  /// Until `stop` says so; the last step.
  DriveStep drive(const std::optional<DriveGoal>& goal, double at_most_s,
                  const std::function<bool(const DriveStep&)>& stop) {
    DriveStep out;
    const Time end = now + from_seconds(at_most_s);
    while (now < end) {
      out = step(goal);
      if (stop(out)) {
        break;
      }
    }
    return out;
  }
};

Ride ride() {
  Ride r;
  r.local = test::empty_room(6, 4, 0.02);
  return r;
}

bool finished(const DriveStep& s) { return s.goal_reached || s.goal_given_up; }

TEST(Driver, StandsWithoutAGoal) {
  Ride r = ride();
  const DriveStep step = r.step(std::nullopt);
  EXPECT_EQ(step.command_body.v_mps, 0);
  EXPECT_EQ(step.command_body.w_radps, 0);
  EXPECT_EQ(step.state, PilotState::kStopped);
}

TEST(Driver, ReachesAGoalAndItsHeadingBehindIt) {
  Ride r = ride();
  r.T_map_body = {4, 2, 0};
  const DriveStep last = r.drive(DriveGoal{{1, 1, deg_to_rad(90)}, true}, 40, finished);
  EXPECT_TRUE(last.goal_reached) << last.reason;
  EXPECT_LE((r.T_map_body.position() - Vec2(1, 1)).norm(), DriverOptions().reached_m + 0.02);
  EXPECT_LE(std::abs(wrap_angle(r.T_map_body.theta_rad - deg_to_rad(90))), deg_to_rad(12));
  EXPECT_GE(r.least_v_mps, 0);  // it turns, it does not reverse
}

TEST(Driver, DrivesTheSameWhereverOdomLies) {
  Ride plain = ride();
  const DriveGoal goal{{4.5, 3, 0}, false};
  EXPECT_TRUE(plain.drive(goal, 40, finished).goal_reached);
  Ride moved = ride();
  moved.T_map_odom = {0.4, -0.2, 0.7};
  // The local map in its own frame: the same room, turned. The map fills in what is cut off.
  moved.local = test::floor_plan({"????"}, 1.0, 0.02);
  EXPECT_TRUE(moved.drive(goal, 40, finished).goal_reached);
  EXPECT_NEAR((plain.T_map_body.position() - moved.T_map_body.position()).norm(), 0,
              2 * DriverOptions().reached_m);
}

TEST(Driver, PassesTheNarrowestGapOfTheOfficeWithoutTouching) {
  Ride r = ride();
  test::fill(r.map, 2.9, 0, 3.1, 1.56, Cell::kOccupied);
  test::fill(r.map, 2.9, 2.44, 3.1, 4, Cell::kOccupied);
  r.local = r.map;
  r.T_map_body = {1, 1, deg_to_rad(120)};
  const ClearanceMap truth = clearance_map(r.map, 1);
  const DriveStep last = r.drive(DriveGoal{{5, 3, 0}, false}, 60, [&](const DriveStep& s) {
    const Vec2 p = r.T_map_body.position();
    r.least_gap_m =
        std::min(r.least_gap_m,
                 truth.to_occupied_m[truth.index(truth.column(p), truth.row(p))] - r.body.radius_m);
    return finished(s);
  });
  EXPECT_TRUE(last.goal_reached) << last.reason;
  EXPECT_GE(r.least_gap_m, 0.05);
}

// A wall comes into view no nearer than the robot can stop by what its platform states.
TEST(Driver, StopsBeforeAWallThatComesIntoViewWhateverThePlatformsTiming) {
  for (const auto& [period_s, latency_s] : std::vector<std::pair<double, double>>{
           {1 / 30.0, 0.01}, {1 / 15.0, 1 / 15.0}, {1 / 15.0, 0.4}, {0.2, 0.3}, {0.5, 0.5}}) {
    SCOPED_TRACE(testing::Message() << period_s << " s, " << latency_s << " s");
    Ride r = ride();
    r.frame_s = period_s;
    r.latency_s = latency_s;
    r.driver = Driver(DriverOptions(), Body(), {from_seconds(period_s), from_seconds(latency_s)});
    r.local = r.map;
    double wall_m = 0;
    r.drive(DriveGoal{{5.7, 2, 0}, false}, 20, [&](const DriveStep&) {
      if (wall_m == 0 && r.T_map_body.position().x() > 2.5) {
        const double gap_m =
            stopping_distance_m(r.twist.v_mps, period_s + latency_s, r.body.max_accel_mps2);
        wall_m = r.T_map_body.position().x() + r.body.radius_m + gap_m + 2 * r.map.cell_m;
        test::fill(r.map, wall_m, 0, wall_m + 0.2, 4, Cell::kOccupied);
        r.local = r.map;
      }
      return false;
    });
    EXPECT_GT(wall_m, 0);
    EXPECT_LE(r.T_map_body.position().x() + r.body.radius_m, wall_m + 0.5 * r.map.cell_m);
    const double limit_mps = std::min(
        r.body.max_speed_mps, speed_that_stops_mps(1, period_s + latency_s, r.body.max_accel_mps2));
    EXPECT_LE(r.most_v_mps, limit_mps + 1e-9);
    EXPECT_GE(r.most_v_mps, 0.5 * limit_mps);
  }
}

TEST(Driver, LowersItsSpeedWhereTheCycleIsLongerThanThePlatformStates) {
  Ride r = ride();
  const DriveGoal goal{{5.5, 2, 0}, false};
  r.drive(goal, 3, finished);
  EXPECT_EQ(r.driver.speed_limit_mps(), r.body.max_speed_mps);
  r.frame_s = 0.8;
  bool said = false;
  r.drive(goal, 2.4, [&](const DriveStep& out) {
    said =
        said || out.reason.find("as fast as it can stop in the floor it knows") != out.reason.npos;
    return false;
  });
  EXPECT_TRUE(said);
  EXPECT_LT(r.twist.v_mps, 0.5);
  const double lag_s = kFrame_s + (r.frame_s - kFrame_s);
  EXPECT_NEAR(r.driver.speed_limit_mps(),
              speed_that_stops_mps(1, lag_s + r.frame_s, r.body.max_accel_mps2), 1e-6);
}

TEST(Driver, DrivesNoFasterThanItCanStopInTheFloorThatIsSeen) {
  Ride r = ride();
  r.driver = Driver(DriverOptions(), Body(), kTiming, 0.2);
  EXPECT_TRUE(r.drive(DriveGoal{{5, 2, 0}, false}, 60, finished).goal_reached);
  EXPECT_LE(r.most_v_mps, speed_that_stops_mps(0.2, 2 * kFrame_s, r.body.max_accel_mps2) + 1e-9);
  EXPECT_GT(r.most_v_mps, 0.3);
}

TEST(Driver, RefusesAnUnreachableGoalWithoutMoving) {
  Ride r = ride();
  test::fill(r.map, 2.9, 0, 3.1, 4, Cell::kOccupied);
  r.local = r.map;
  const DriveStep last = r.drive(DriveGoal{{5, 2, 0}, false}, 5, finished);
  EXPECT_TRUE(last.goal_given_up);
  EXPECT_THAT(last.reason, HasSubstr("no way to the goal"));
  EXPECT_EQ((r.T_map_body.position() - Vec2(1, 2)).norm(), 0);
}

TEST(Driver, LooksOnceAtWhatOnlyTheLocalMapHasInTheWayAndDoesNotDriveAtIt) {
  Ride r = ride();
  test::fill(r.map, 2.9, 0, 3.1, 4, Cell::kOccupied);
  r.local = r.map;
  test::fill(r.map, 2.9, 1.5, 3.1, 2.5, Cell::kFree);
  r.T_map_body = {2, 2, 0};
  double turned_rad = 0;
  const auto drive = [&](const DriveGoal& goal) {
    turned_rad = 0;
    return r.drive(goal, 60, [&](const DriveStep& s) {
      turned_rad += std::abs(r.twist.w_radps) * kFrame_s;
      return finished(s);
    });
  };
  EXPECT_TRUE(drive(DriveGoal{{5, 2, 0}, false}).goal_given_up);
  EXPECT_NEAR(turned_rad, 2 * std::numbers::pi, 0.2);
  EXPECT_TRUE(drive(DriveGoal{{5, 3, 0}, false}).goal_given_up);  // looked about already
  EXPECT_LT(turned_rad, 0.2);
  EXPECT_LT((r.T_map_body.position() - Vec2(2, 2)).norm(), 0.02);
}

TEST(Driver, TriesEachRecoveryOnceAtAPlaceAndThenAnotherWay) {
  Ride r = ride();
  test::fill(r.map, 2.9, 1.2, 3.1, 4, Cell::kOccupied);  // a way round below,
  test::fill(r.map, 2.9, 2.4, 3.1, 3.2, Cell::kFree);    // and a gap: a pane is in it
  r.local = r.map;
  int looks = 0;
  int retreats = 0;
  std::string said;
  r.T_map_body = {1, 2.8, 0};
  const DriveStep last = r.drive(DriveGoal{{4.5, 2.8, 0}, false}, 200, [&](const DriveStep& s) {
    if (r.T_map_body.y_m > 2.2 && r.T_map_body.x_m < 2.9) {
      r.T_map_body.x_m = std::min(r.T_map_body.x_m, 2.8);
    }
    looks += s.reason != said && s.reason.find("to look") != std::string::npos ? 1 : 0;
    retreats += s.reason != said && s.reason.find("retreating") != std::string::npos ? 1 : 0;
    said = s.reason;
    return finished(s);
  });
  EXPECT_TRUE(last.goal_reached) << last.reason;
  EXPECT_EQ(looks, 1);
  EXPECT_EQ(retreats, 1);
}

TEST(Driver, PassesWhereNothingGotOnWhenItIsToTryAgain) {
  Ride r = ride();
  test::fill(r.map, 2.9, 0, 3.1, 4, Cell::kOccupied);
  test::fill(r.map, 2.9, 1.4, 3.1, 2.6, Cell::kFree);
  r.local = r.map;
  r.held = true;
  r.T_map_body = {2.6, 2, 0};
  const DriveGoal goal{{5, 2, 0}, false};
  EXPECT_TRUE(r.drive(goal, 200, finished).goal_given_up);
  r.held = false;
  EXPECT_TRUE(r.drive(goal, 60, finished).goal_given_up) << "the place is closed";
  EXPECT_TRUE(r.driver.try_blocked_again());
  EXPECT_FALSE(r.driver.try_blocked_again());
  const DriveStep last = r.drive(goal, 60, finished);
  EXPECT_TRUE(last.goal_reached) << last.reason;
}

TEST(Driver, DoesNotTurnBackToTheWayThatIsBlockedNearBy) {
  // Two ways through a wall. From farther away than the local map is asked the short one looks
  // free.
  Ride ride;
  ride.map = test::empty_room(9, 6, 0.02);
  test::fill(ride.map, 0, 2.9, 9, 3.1, Cell::kOccupied);
  test::fill(ride.map, 1.5, 2.9, 2.5, 3.1, Cell::kFree);
  test::fill(ride.map, 7, 2.9, 8, 3.1, Cell::kFree);
  ride.local = ride.map;
  test::fill(ride.local, 1.5, 2.95, 2.5, 3.05, Cell::kOccupied);
  ride.T_map_body = {2, 0.5, deg_to_rad(90)};
  double way_m = 0;
  Vec2 before = ride.T_map_body.position();
  const DriveStep end = ride.drive(DriveGoal{{2, 5.3, 0}, false}, 120, [&](const DriveStep& out) {
    way_m += (ride.T_map_body.position() - before).norm();
    before = ride.T_map_body.position();
    return out.goal_reached || out.goal_given_up;
  });
  EXPECT_TRUE(end.goal_reached) << end.reason;
  EXPECT_LT(way_m, 18) << "there and back and then round takes 14 m";
}

TEST(Driver, DetoursAroundWhatOnlyTheLocalMapKnows) {
  Ride r = ride();
  test::fill(r.local, 2.9, 1.2, 3.1, 3, Cell::kOccupied);
  const ClearanceMap truth = clearance_map(r.local, 1);
  double least = 1;
  const DriveStep last = r.drive(DriveGoal{{5, 2, 0}, false}, 60, [&](const DriveStep& s) {
    const Vec2 p = r.T_map_body.position();
    least =
        std::min<double>(least, truth.to_occupied_m[truth.index(truth.column(p), truth.row(p))]);
    return finished(s);
  });
  EXPECT_TRUE(last.goal_reached) << last.reason;
  EXPECT_GT(least, r.body.radius_m);
}

TEST(Driver, BacksOffAlongItsTrackWhenTouchedAndDoesNotTouchAgain) {
  Ride r = ride();
  const DriveGoal goal{{5, 2, 0}, false};
  r.drive(goal, 4, [&](const DriveStep&) { return r.T_map_body.x_m > 2; });
  const double touched_at = r.T_map_body.x_m;
  // Stopped by the thing it hit: the wheels stand at once.
  r.bumper = true;
  r.twist = {};
  const DriveStep hit = r.step(goal);
  EXPECT_EQ(hit.command_body.v_mps, 0);
  EXPECT_EQ(hit.state, PilotState::kRecovering);
  r.bumper = false;
  const DriveStep back =
      r.drive(goal, 10, [](const DriveStep& s) { return s.state == PilotState::kDriving; });
  EXPECT_EQ(back.state, PilotState::kDriving) << back.reason;
  EXPECT_LT(r.T_map_body.x_m, touched_at - 0.3);
  EXPECT_LT(r.least_v_mps, 0);
  double nearest = 1;
  const Vec2 thing(touched_at + r.body.radius_m + 0.05, 2);
  const DriveStep last = r.drive(goal, 40, [&](const DriveStep& s) {
    nearest = std::min(nearest, (r.T_map_body.position() - thing).norm());
    return finished(s);
  });
  EXPECT_TRUE(last.goal_reached) << last.reason;
  EXPECT_GT(nearest, r.body.radius_m);
}

TEST(Driver, BacksOffNoFartherThanToWhoHasComeBehind) {
  Ride r = ride();
  const DriveGoal goal{{5, 2, 0}, false};
  r.drive(goal, 10, [&](const DriveStep&) { return r.T_map_body.x_m > 2.5; });
  const double touched_at = r.T_map_body.x_m;
  const double behind_m = touched_at - r.body.radius_m - 0.2;
  test::fill(r.local, behind_m - 0.2, 1.8, behind_m, 2.2, Cell::kOccupied);
  r.bumper = true;
  r.twist = {};
  r.step(goal);
  r.bumper = false;
  double least_x_m = touched_at;
  r.drive(goal, 20, [&](const DriveStep& s) {
    least_x_m = std::min(least_x_m, r.T_map_body.x_m);
    return finished(s);
  });
  EXPECT_LT(least_x_m, touched_at - 0.05);
  EXPECT_GT(least_x_m, behind_m + r.body.radius_m);
}

TEST(Driver, RecoversInOrderAndGivesUpWhenHeld) {
  Ride r = ride();
  const DriveGoal goal{{5, 2, 0}, false};
  r.drive(goal, 4, [&](const DriveStep&) { return r.T_map_body.x_m > 2; });
  r.held = true;
  bool looked = false;
  bool retreated = false;
  const DriveStep last = r.drive(goal, 120, [&](const DriveStep& s) {
    looked = looked || s.reason.find("to look") != std::string::npos;
    if (s.reason.find("retreating") != std::string::npos) {
      EXPECT_TRUE(looked);
      retreated = true;
    }
    return finished(s);
  });
  EXPECT_TRUE(looked);
  EXPECT_TRUE(retreated);
  EXPECT_TRUE(last.goal_given_up) << last.reason;
}

bool recovers(const DriveStep& s) { return s.state == PilotState::kRecovering; }

TEST(Driver, WaitsAfreshWhereItIsBlockedAfterATurnAndForAnotherGoal) {
  DriverOptions options;
  options.dwa.margin_m = 5;  // no nearer to any wall than it is: blocked ahead, free behind
  const DriveGoal ahead{{5.5, 2, 0}, false};
  const double nearly_s = options.blocked_s - 0.3;
  const auto wait = [&](const DriveGoal& first, const DriveGoal& between, const DriveGoal& then) {
    Ride r = ride();
    r.driver = Driver(options, Body(), kTiming);
    r.T_map_body = {5, 2, 0};
    EXPECT_FALSE(recovers(r.drive(first, nearly_s, recovers)));
    EXPECT_FALSE(recovers(r.drive(between, 0.8, recovers)));
    const Time since = r.now;
    EXPECT_TRUE(recovers(r.drive(then, 5, recovers)));
    return to_seconds(r.now - since);
  };
  EXPECT_GE(wait(ahead, DriveGoal{{1, 2, 0}, false}, ahead), options.blocked_s);
  const DriveGoal beside{{5.5, 2.05, 0}, false};
  EXPECT_GE(wait(ahead, beside, ahead), options.blocked_s);
}

TEST(Driver, ALookAboutEndsWithItsTurn) {
  DriverOptions options;
  options.dwa.margin_m = 5;  // blocked ahead
  Ride r = ride();
  r.driver = Driver(options, Body(), kTiming);
  r.T_map_body = {5, 2, 0};
  const DriveGoal goal{{5.5, 2, 0}, false};
  const auto looks = [](const DriveStep& s) {
    return s.reason.find("to look") != std::string::npos;
  };
  ASSERT_TRUE(looks(r.drive(goal, 5, looks)));
  const Time since = r.now;
  r.drive(goal, 30, [&](const DriveStep& s) { return !looks(s); });
  const double turn_s = 2 * std::numbers::pi / options.look_radps;
  EXPECT_GT(to_seconds(r.now - since), 0.9 * turn_s);
  EXPECT_LT(to_seconds(r.now - since), turn_s + 2);
}

/// Walls with one gap of 0.88 m, which what was touched in its middle closes.
Ride ride_to_a_gap() {
  Ride r = ride();
  test::fill(r.map, 2.9, 0, 3.1, 1.56, Cell::kOccupied);
  test::fill(r.map, 2.9, 2.44, 3.1, 4, Cell::kOccupied);
  r.local = r.map;
  return r;
}

// Drives until the goal is reached, though it be given up, for so long; touches what stands in the
// gap the first `touches` times that it comes there. When it touched it.
std::vector<double> touch_in_the_gap(Ride& r, int touches, double at_most_s, bool& reached) {
  const DriveGoal goal{{5, 2, 0}, false};
  std::vector<double> touched_s;
  while (to_seconds(r.now - Time()) < at_most_s) {
    const bool there = r.T_map_body.x_m > 2.7 && r.T_map_body.x_m < 3;
    r.bumper =
        there && !r.bumper && r.twist.v_mps > 0 && static_cast<int>(touched_s.size()) < touches;
    if (r.bumper) {
      r.twist = r.pending = {};
      touched_s.push_back(to_seconds(r.now - Time()));
    }
    if (r.step(goal).goal_reached) {
      reached = true;
      break;
    }
  }
  return touched_s;
}

TEST(Driver, GoesWhereSomebodyWasBumpedOnceHeHasHadTimeToGo) {
  Ride r = ride_to_a_gap();
  bool reached = false;
  const std::vector<double> touched_s = touch_in_the_gap(r, 1, 120, reached);
  EXPECT_EQ(touched_s.size(), 1U);
  EXPECT_TRUE(reached);
}

TEST(Driver, LeavesWhatItTouchesAgainAloneForTwiceAsLong) {
  Ride r = ride_to_a_gap();
  bool reached = false;
  const std::vector<double> touched_s = touch_in_the_gap(r, 3, 300, reached);
  ASSERT_EQ(touched_s.size(), 3U);
  EXPECT_TRUE(reached);
  EXPECT_GE(touched_s[1] - touched_s[0], 30);
  EXPECT_GE(touched_s[2] - touched_s[1], 60);
  EXPECT_GE(to_seconds(r.now - Time()) - touched_s[2], 120);
}

TEST(Driver, KeepsClearOfWhatItTouchedLongAgoWhereThereIsAnotherWay) {
  Ride r = ride();
  const DriveGoal east{{5, 2, 0}, false};
  const DriveGoal west{{1, 2, 0}, false};
  r.drive(east, 4, [&](const DriveStep&) { return r.T_map_body.x_m > 2; });
  const Vec2 thing(r.T_map_body.x_m + r.body.radius_m + 0.05, 2);
  r.bumper = true;
  r.twist = {};
  r.step(east);
  r.bumper = false;
  ASSERT_TRUE(r.drive(east, 60, finished).goal_reached);
  r.drive(std::nullopt, 120, [](const DriveStep&) { return false; });
  double nearest = 1;
  const DriveStep last = r.drive(west, 60, [&](const DriveStep& s) {
    nearest = std::min(nearest, (r.T_map_body.position() - thing).norm());
    return finished(s);
  });
  EXPECT_TRUE(last.goal_reached) << last.reason;
  EXPECT_GT(nearest, r.body.radius_m);
}

TEST(Driver, HandsBackTheWindowWhenAsked) {
  Ride r = ride();
  DriveTask task;
  task.local_odom = &r.local;
  task.map = &r.map;
  task.T_odom_body = {1, 2, 0};
  task.goal = DriveGoal{{5, 2, 0}, false};
  task.keep_window = true;
  const DriveStep step = r.driver.step(task);
  EXPECT_FALSE(step.window.empty());
  EXPECT_TRUE(step.lookahead_odom);
  EXPECT_FALSE(step.path_map.empty());
}

}  // namespace
}  // namespace panoptes

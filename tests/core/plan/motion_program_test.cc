// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/motion_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kPeriod_s = 1.0 / 15;
constexpr double kLag_s = 0.04;
constexpr int kParts = 15;         // of a period, in which the body moves
constexpr double kTick_m = 0.003;  // where a segment may end, and what the creeping adds
constexpr double kTick_rad = deg_to_rad(0.5);
const std::vector<MotionProgramOptions> kPrograms{LegsAndTurns(), Sawtooth(), Rose(), Circle()};

/// A body that follows commands within its limits, a lag after they are told, and wheels that turn
/// `slip` times as far as it.
struct Simulation {
  Body body;
  double leg_slip = 1;
  double turn_slip = 1;
  Pose2 T_odom_start{};

  struct Seen {
    double t_s = 0;
    Pose2 T_odom_body;
    Pose2 true_pose;
    Twist2 command_body;
    double heading_rad = 0;  // by the wheels, beyond a whole turn
    std::size_t segment = 0;
  };

  std::vector<Seen> driven(const MotionProgramOptions& options) const {
    MotionProgram program(options, body, {from_seconds(kPeriod_s), from_seconds(kLag_s)});
    std::vector<Seen> seen;
    Odometry odometry;
    odometry.T_odom_body = T_odom_start;
    Pose2 truth;
    Twist2 twist;
    Twist2 acting;
    double heading_rad = 0;
    for (double t = 0; t < 300 && !program.done(); t += kPeriod_s) {
      const Twist2 next = program.command(odometry, from_seconds(kPeriod_s));
      seen.push_back({t, odometry.T_odom_body, truth, next, heading_rad, program.at()});
      const double dt = kPeriod_s / kParts;
      for (int i = 0; i < kParts; ++i) {
        const Twist2& told = i * dt < kLag_s ? acting : next;
        twist.v_mps += std::clamp(told.v_mps - twist.v_mps, -body.max_accel_mps2 * dt,
                                  body.max_accel_mps2 * dt);
        twist.w_radps += std::clamp(told.w_radps - twist.w_radps, -body.max_turn_accel_radps2 * dt,
                                    body.max_turn_accel_radps2 * dt);
        truth = truth * exp_twist(twist, dt);
        const Twist2 rolled{leg_slip * twist.v_mps, turn_slip * twist.w_radps};
        odometry.T_odom_body = odometry.T_odom_body * exp_twist(rolled, dt);
        heading_rad += rolled.w_radps * dt;
        odometry.twist_body = rolled;
      }
      acting = next;
    }
    return seen;
  }
};

/// Where it stood at the end of each segment.
std::vector<Simulation::Seen> ends(const std::vector<Simulation::Seen>& seen) {
  std::vector<Simulation::Seen> out;
  for (std::size_t i = 1; i < seen.size(); ++i) {
    if (seen[i].segment != seen[i - 1].segment) {
      out.push_back(seen[i]);
    }
  }
  return out;
}

Vec2 end_of(const MotionSegment& segment) {
  if (segment.radius_m > 0) {  // whole rounds
    return segment.from_m;
  }
  const double gone_m = segment.kind == MotionSegment::Kind::kLeg ? segment.amount : 0;
  return segment.from_m +
         gone_m * Vec2(std::cos(segment.heading_rad), std::sin(segment.heading_rad));
}

std::vector<int> headings_deg(const MotionProgramOptions& program) {
  std::vector<int> out;
  for (const MotionSegment& segment : segments_of(program)) {
    out.push_back(static_cast<int>(std::lround(rad_to_deg(segment.heading_rad))));
  }
  return out;
}

TEST(MotionProgram, LegsAndTurnsGoesThereAndBackAndThenFartherRoundEachTime) {
  const std::vector<MotionSegment> all = segments_of(LegsAndTurns());
  ASSERT_EQ(all.size(), 27U);
  EXPECT_EQ(told(all[0]), "ahead 1.00 m");
  EXPECT_EQ(told(all[1]), "back 1.00 m");
  EXPECT_EQ(told(all[2]), "left 15 degrees");
  EXPECT_EQ(told(all[3]), "right 30 degrees");
  EXPECT_EQ(told(all[4]), "left 45 degrees");
  EXPECT_EQ(told(all[26]), "left 375 degrees");
  const std::vector<int> headings = headings_deg(LegsAndTurns());
  EXPECT_EQ(headings[25], -180);
  EXPECT_EQ(headings[26], 195);
}

TEST(MotionProgram, SawtoothTurnsBackHalfOfWhatItTurnsOn) {
  EXPECT_EQ(headings_deg(Sawtooth()), (std::vector<int>{90, 45, 135, 90, 180, 135, 225, 180, 270,
                                                        225, 315, 270, 360, 315, 405}));
}

TEST(MotionProgram, RoseHasPetalsAllRoundAndOneMore) {
  const std::vector<MotionSegment> all = segments_of(Rose());
  EXPECT_EQ(all.size(), 32U);
  EXPECT_EQ(headings_deg(Rose()).back(), 400);
  for (const MotionSegment& segment : all) {
    EXPECT_LE(end_of(segment).norm(), 0.5 + 1e-12);
  }
}

TEST(MotionProgram, CircleKeepsToItsRadius) {
  EXPECT_EQ(told(segments_of(Circle()).at(0)), "left 2160 degrees round 0.40 m");
  const Vec2 middle(0, Circle().radius_m);
  for (const Pose2& pose : poses_of(Circle())) {
    EXPECT_NEAR((pose.position() - middle).norm(), 0.4, 1e-9);
  }
  // Also by wheels that say less of legs than of turns, as the wheels see it.
  const Simulation slipping{.body = {}, .leg_slip = 0.97, .turn_slip = 1.02};
  for (const auto& seen : slipping.driven(Circle())) {
    EXPECT_NEAR((seen.T_odom_body.position() - middle).norm(), 0.4, 0.03);
  }
}

TEST(MotionProgram, EveryProgramEndsEverySegmentWhereItShould) {
  for (const MotionProgramOptions& options : kPrograms) {
    const std::vector<MotionSegment> all = segments_of(options);
    const auto seen = ends(Simulation{}.driven(options));
    ASSERT_EQ(seen.size(), all.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_NEAR((seen[i].true_pose.position() - end_of(all[i])).norm(), 0, 2 * kTick_m) << i;
      EXPECT_NEAR(seen[i].heading_rad, all[i].heading_rad, kTick_rad) << i;
    }
  }
}

TEST(MotionProgram, EveryProgramTakesAPioneerOneToOneAndAHalfMinutes) {
  for (const MotionProgramOptions& options : kPrograms) {
    const double took_s = Simulation{}.driven(options).back().t_s;
    EXPECT_GE(took_s, 60) << options.index();
    EXPECT_LE(took_s, 90) << options.index();
    EXPECT_NEAR(expected_s(options, Body()), took_s, 3) << options.index();
  }
}

TEST(MotionProgram, OvershootsNothing) {
  for (const MotionProgramOptions& options : kPrograms) {
    const std::vector<MotionSegment> all = segments_of(options);
    for (const auto& seen : Simulation{}.driven(options)) {
      const MotionSegment& segment = all[std::min(seen.segment, all.size() - 1)];
      const double sign = segment.amount > 0 ? 1 : -1;
      if (segment.kind == MotionSegment::Kind::kTurn) {
        EXPECT_LE(sign * (seen.heading_rad - segment.heading_rad), kTick_rad);
      } else {
        const Vec2 along(std::cos(segment.heading_rad), std::sin(segment.heading_rad));
        EXPECT_LE(sign * (seen.T_odom_body.position() - end_of(segment)).dot(along), kTick_m);
      }
    }
  }
}

TEST(MotionProgram, AcceleratesNoFasterThanItIsToldTo) {
  constexpr double kRoundoff = 1e-9;
  for (const MotionProgramOptions& options : kPrograms) {
    const MotionPace pace = std::visit([](const auto& o) { return o.pace; }, options);
    Twist2 last;
    for (const auto& seen : Simulation{}.driven(options)) {
      const Twist2& now = seen.command_body;
      EXPECT_LE(std::abs(now.v_mps), pace.speed_mps);
      EXPECT_LE(std::abs(now.w_radps), pace.turn_radps);
      // what it creeps with at the least comes at once
      EXPECT_LE(std::abs(now.v_mps) - std::abs(last.v_mps),
                std::max(0.01, pace.accel_mps2 * kPeriod_s + kRoundoff));
      last = now;
    }
  }
}

TEST(MotionProgram, IsSlowedToWhatTheBodyCanDo) {
  Body slow;
  slow.max_turn_radps = 0.4;
  slow.max_speed_mps = 0.2;
  const Simulation simulation{.body = slow};
  const auto seen = simulation.driven(Rose());
  for (const auto& at : seen) {
    EXPECT_LE(std::abs(at.command_body.v_mps), 0.2);
    EXPECT_LE(std::abs(at.command_body.w_radps), 0.4);
  }
  EXPECT_GT(seen.back().t_s, 90);
}

// The wheels say 3 % more of legs and 2 % more of turns than is true: by the wheels it ends where
// it should, however many segments there were.
TEST(MotionProgram, ClosesOnWhatTheWheelsTell) {
  const Simulation slipping{.body = {}, .leg_slip = 1.03, .turn_slip = 1.02};
  for (const MotionProgramOptions& options : kPrograms) {
    const std::vector<MotionSegment> all = segments_of(options);
    const auto seen = slipping.driven(options);
    EXPECT_NEAR(seen.back().heading_rad, all.back().heading_rad, kTick_rad);
    EXPECT_NEAR((seen.back().T_odom_body.position() - end_of(all.back())).norm(), 0, 2 * kTick_m);
  }
  const auto rose = ends(slipping.driven(Rose()));
  EXPECT_NEAR(rose[0].true_pose.position().norm(), 0.5 / 1.03, kTick_m);
}

TEST(MotionProgram, BeginsWhereTheOdometryIs) {
  const Simulation elsewhere{.body = {}, .T_odom_start = {3, -2, deg_to_rad(170)}};
  const auto here = Simulation{}.driven(Rose());
  const auto there = elsewhere.driven(Rose());
  ASSERT_EQ(here.size(), there.size());
  EXPECT_NEAR((there.back().true_pose.position() - here.back().true_pose.position()).norm(), 0,
              kTick_m);
}

TEST(MotionProgram, SaysWhatItDoes) {
  MotionProgram program(LegsAndTurns(), Body(), {from_seconds(kPeriod_s), from_seconds(kLag_s)});
  EXPECT_EQ(program.doing(), "segment 1 of 27: ahead 1.00 m");
}

TEST(MotionProgram, CommandsTheSameBitsTwice) {
  for (const MotionProgramOptions& options : kPrograms) {
    const auto once = Simulation{}.driven(options);
    const auto again = Simulation{}.driven(options);
    ASSERT_EQ(once.size(), again.size());
    for (std::size_t i = 0; i < once.size(); ++i) {
      EXPECT_EQ(once[i].command_body.v_mps, again[i].command_body.v_mps);
      EXPECT_EQ(once[i].command_body.w_radps, again[i].command_body.w_radps);
    }
  }
}

TEST(MotionProgram, TellsTheFloorThatItTakes) {
  const double reach_m = 0.35;
  const FloorNeeded legs = floor_needed(poses_of(LegsAndTurns()), reach_m);
  EXPECT_NEAR(legs.ahead_m, 1.35, 1e-12);
  EXPECT_NEAR(legs.behind_m, 0.35, 1e-12);
  EXPECT_EQ(told(legs),
            "1.35 m ahead of where the robot starts, 0.35 m behind, 0.35 m to the left and 0.35 m "
            "to the right");
  EXPECT_NEAR(floor_needed(poses_of(Sawtooth()), reach_m).ahead_m, 0.35, 1e-12);
  EXPECT_NEAR(floor_needed(poses_of(Rose()), reach_m).behind_m,
              0.35 + 0.5 * std::cos(deg_to_rad(20)), 1e-12);
}

TEST(MotionProgram, PassesPlacesNoFartherApartThanFiveCentimetres) {
  for (const MotionProgramOptions& options : kPrograms) {
    const std::vector<Pose2> poses = poses_of(options);
    for (std::size_t i = 1; i < poses.size(); ++i) {
      EXPECT_LE((poses[i].position() - poses[i - 1].position()).norm(), 0.05 + 1e-9);
    }
  }
}

TEST(MotionProgram, StopStartRoundACircleIsInPiecesOfIt) {
  Circle circle;
  circle.radius_m = 2;
  circle.pace.stand_s = 0.4;
  Vec2 at = Vec2::Zero();
  double turned_rad = 0;
  for (const MotionSegment& piece : segments_of(circle)) {
    EXPECT_LE(piece.amount * piece.radius_m, circle.pace.piece_m + 1e-9);
    EXPECT_NEAR((piece.from_m - at).norm(), 0, 1e-9);
    turned_rad += piece.amount;
    EXPECT_NEAR(piece.heading_rad, turned_rad, 1e-9);
    at = Vec2(0, 2) + 2 * Vec2(std::sin(turned_rad), -std::cos(turned_rad));
  }
  EXPECT_NEAR(turned_rad, 6 * 2 * std::numbers::pi, 1e-9);
}

TEST(MotionProgram, StopStartEndsWhereTheWholeProgramDoes) {
  Rose rose;
  const std::vector<MotionSegment> whole = segments_of(rose);
  rose.pace.stand_s = 0.4;
  rose.pace.piece_m = 0.2;
  const std::vector<MotionSegment> pieces = segments_of(rose);
  double legs_m = 0;
  double turns_rad = 0;
  for (const MotionSegment& piece : pieces) {
    const bool is_leg = piece.kind == MotionSegment::Kind::kLeg;
    (is_leg ? legs_m : turns_rad) += std::abs(piece.amount);
    EXPECT_LE(std::abs(piece.amount), (is_leg ? rose.pace.piece_m : rose.pace.piece_rad) + 1e-9);
  }
  for (const MotionSegment& segment : whole) {
    (segment.kind == MotionSegment::Kind::kLeg ? legs_m : turns_rad) -= std::abs(segment.amount);
  }
  EXPECT_NEAR(legs_m, 0, 1e-9);
  EXPECT_NEAR(turns_rad, 0, 1e-9);
  EXPECT_LT((end_of(pieces.back()) - end_of(whole.back())).norm(), 1e-9);
  EXPECT_NEAR(pieces.back().heading_rad, whole.back().heading_rad, 1e-9);
}

TEST(MotionProgram, StopStartStandsAfterEveryPiece) {
  Rose rose;
  rose.pace.stand_s = 0.4;
  rose.pace.piece_m = 0.2;
  const Simulation pioneer{Body{}};
  const auto seen = pioneer.driven(rose);
  EXPECT_EQ(seen.back().segment, segments_of(rose).size());
  std::vector<double> stands_s(segments_of(rose).size(), 0);
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
    if ((seen[i].true_pose.inverse() * seen[i + 1].true_pose).position().norm() < 1e-6 &&
        std::abs(wrap_angle(seen[i].heading_rad - seen[i + 1].heading_rad)) < 1e-6) {
      stands_s[seen[i].segment] += seen[i + 1].t_s - seen[i].t_s;
    }
  }
  for (std::size_t i = 0; i < stands_s.size(); ++i) {
    EXPECT_GT(stands_s[i], rose.pace.stand_s - 1.5 * kPeriod_s) << "segment " << i;
  }
}

}  // namespace
}  // namespace panoptes

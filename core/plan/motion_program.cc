// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/motion_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "core/plan/reaction.h"

namespace panoptes {
namespace {

constexpr double kWholeTurn_rad = 2 * std::numbers::pi;
constexpr double kRoundoff_rad = 1e-9;
constexpr double kApart_m = 0.05;

// A tick of a Pioneer's wheels is 1.2 mm of path and 0.2 degrees of turn: nearer nobody can tell.
constexpr double kArrived_m = 0.002;
constexpr double kArrived_rad = deg_to_rad(0.3);
// A controller knows whole millimetres and degrees a second; at this pace nothing is overshot.
constexpr double kCreep_mps = 0.01;
constexpr double kCreep_radps = 0.03;
constexpr double kStands_mps = 0.01;
constexpr double kStands_radps = 0.02;
// Along a leg the body is led back to its line within about half a metre, without swinging.
constexpr double kHeadingGain_per_m = 4;
constexpr double kOffsetGain_per_m2 = 4;
constexpr double kMostSteering_radps = 0.3;
// Along an arc it is led back to it within a round: metres wider for each metre that it is behind.
constexpr double kArcGain = 1;
constexpr double kMostWidening = 0.2;
constexpr double kSettling_s = 0.1;  // at the end of a segment

const Rule kLength = between(0.05, 10);
const Rule kStep = between(deg_to_rad(1), std::numbers::pi);
const Rule kOver = between(0, kWholeTurn_rad);
const Rule kManyTurns = between(0, 20 * kWholeTurn_rad);

void bind_pace(Fields& f, MotionPace& o) {
  f("speed_mps", o.speed_mps, between(0.02, 10));
  f("accel_mps2", o.accel_mps2, between(0.02, 10));
  f("turn_radps", o.turn_radps, between(0.05, 10));
  f("turn_accel_radps2", o.turn_accel_radps2, between(0.05, 100));
  f("stand_s", o.stand_s, between(0, 60));
  f("piece_m", o.piece_m, kLength);
  f.angle("piece", o.piece_rad, kStep);
}

MotionPace pace_of(const MotionProgramOptions& program) {
  return std::visit([](const auto& chosen) { return chosen.pace; }, program);
}

MotionPace pace_of(const MotionProgramOptions& program, const Body& body) {
  MotionPace pace = pace_of(program);
  pace.speed_mps = std::min(pace.speed_mps, body.max_speed_mps);
  pace.accel_mps2 = std::min(pace.accel_mps2, body.max_accel_mps2);
  pace.turn_radps = std::min(pace.turn_radps, body.max_turn_radps);
  pace.turn_accel_radps2 = std::min(pace.turn_accel_radps2, body.max_turn_accel_radps2);
  return pace;
}

Vec2 ahead_of(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

/// Where a turn has the body after `left_rad` of it.
Pose2 turned(const MotionSegment& turn, double left_rad) {
  const double from_rad = turn.heading_rad - turn.amount;
  const auto to_the_left = [](double heading_rad) {
    return ahead_of(heading_rad + std::numbers::pi / 2);
  };
  const Vec2 middle = turn.from_m + turn.radius_m * to_the_left(from_rad);
  const Vec2 at = middle - turn.radius_m * to_the_left(from_rad + left_rad);
  return {at.x(), at.y(), wrap_angle(from_rad + left_rad)};
}

/// Along an arc the body goes no faster than along a leg, also where it is led back to it.
MotionPace turn_pace(MotionPace pace, const MotionSegment& turn) {
  if (turn.radius_m > 0) {
    const double widest_m = (1 + kMostWidening) * turn.radius_m;
    pace.turn_radps = std::min(pace.turn_radps, pace.speed_mps / widest_m);
    pace.turn_accel_radps2 = std::min(pace.turn_accel_radps2, pace.accel_mps2 / widest_m);
  }
  return pace;
}

// Adds one segment after another, each from where the last one ended.
class Segments {
 public:
  void leg(double ahead_m) {
    all_.push_back({MotionSegment::Kind::kLeg, ahead_m, at_, heading_rad_});
    at_ += ahead_m * Vec2(std::cos(heading_rad_), std::sin(heading_rad_));
  }
  void there_and_back(double ahead_m) {
    const Vec2 here = at_;
    leg(ahead_m);
    leg(-ahead_m);
    at_ = here;  // without roundoff
  }
  void turn_to(double heading_rad) {
    all_.push_back({MotionSegment::Kind::kTurn, heading_rad - heading_rad_, at_, heading_rad});
    heading_rad_ = heading_rad;
  }
  void arc(double left_rad, double radius_m) {
    all_.push_back({MotionSegment::Kind::kTurn, left_rad, at_, heading_rad_ + left_rad, radius_m});
    at_ = turned(all_.back(), left_rad).position();
    heading_rad_ += left_rad;
  }
  double heading_rad() const { return heading_rad_; }
  std::vector<MotionSegment> take() { return std::move(all_); }

 private:
  std::vector<MotionSegment> all_;
  Vec2 at_ = Vec2::Zero();
  double heading_rad_ = 0;
};

void add(const LegsAndTurns& program, Segments& to) {
  to.there_and_back(program.leg_m);
  const int half = static_cast<int>(std::ceil(std::numbers::pi / program.step_rad - kRoundoff_rad));
  for (int i = 1; i <= half; ++i) {
    to.turn_to(i * program.step_rad);
    to.turn_to(-i * program.step_rad);
  }
  to.turn_to((half + 1) * program.step_rad);
}

void add(const Sawtooth& program, Segments& to) {
  const double end_rad = kWholeTurn_rad + program.over_rad - kRoundoff_rad;
  while (true) {
    to.turn_to(to.heading_rad() + program.left_rad);
    if (to.heading_rad() >= end_rad) {
      return;
    }
    to.turn_to(to.heading_rad() - program.right_rad);
  }
}

void add(const Rose& program, Segments& to) {
  const int turns = static_cast<int>(
      std::ceil((kWholeTurn_rad + program.over_rad) / program.step_rad - kRoundoff_rad));
  for (int i = 0; i <= turns; ++i) {
    if (i > 0) {
      to.turn_to(i * program.step_rad);
    }
    to.there_and_back(program.petal_m);
  }
}

void add(const Circle& program, Segments& to) {
  to.arc(kWholeTurn_rad + program.over_rad, program.radius_m);
}

/// A segment in pieces of the same length.
void add_pieces(const MotionSegment& whole, const MotionPace& pace,
                std::vector<MotionSegment>& to) {
  const bool is_leg = whole.kind == MotionSegment::Kind::kLeg;
  const double most = is_leg               ? pace.piece_m
                      : whole.radius_m > 0 ? std::min(pace.piece_rad, pace.piece_m / whole.radius_m)
                                           : pace.piece_rad;
  const int pieces = static_cast<int>(std::ceil(std::abs(whole.amount) / most - kRoundoff_rad));
  MotionSegment piece = whole;
  piece.amount = whole.amount / std::max(1, pieces);
  for (int i = 0; i < pieces; ++i) {
    if (is_leg) {
      piece.from_m = whole.from_m + i * piece.amount * ahead_of(whole.heading_rad);
    } else {
      piece.heading_rad = whole.heading_rad - (pieces - 1 - i) * piece.amount;
      piece.from_m = turned(whole, i * piece.amount).position();
    }
    to.push_back(piece);
  }
}

double trapezoid_s(double way, double speed, double accel) {
  return way > speed * speed / accel ? way / speed + speed / accel : 2 * std::sqrt(way / accel);
}

}  // namespace

void bind(Fields& f, LegsAndTurns& o) {
  f("leg_m", o.leg_m, kLength);
  f.angle("step", o.step_rad, kStep);
  bind_pace(f, o.pace);
}

void bind(Fields& f, Sawtooth& o) {
  f.angle("left", o.left_rad, kStep);
  f.angle("right", o.right_rad, kStep);
  f.angle("over", o.over_rad, kOver);
  f.require(o.left_rad - o.right_rad >= deg_to_rad(1) - kRoundoff_rad, "right_deg",
            "must be at least a degree less than left_deg, or it would never come round");
  bind_pace(f, o.pace);
}

void bind(Fields& f, Rose& o) {
  f("petal_m", o.petal_m, kLength);
  f.angle("step", o.step_rad, kStep);
  f.angle("over", o.over_rad, kOver);
  bind_pace(f, o.pace);
}

void bind(Fields& f, Circle& o) {
  f("radius_m", o.radius_m, kLength);
  f.angle("over", o.over_rad, kManyTurns);
  bind_pace(f, o.pace);
}

std::vector<MotionSegment> segments_of(const MotionProgramOptions& program) {
  Segments segments;
  std::visit([&segments](const auto& chosen) { add(chosen, segments); }, program);
  const MotionPace pace = pace_of(program);
  std::vector<MotionSegment> whole = segments.take();
  if (pace.stand_s == 0) {
    return whole;
  }
  std::vector<MotionSegment> pieces;
  for (const MotionSegment& segment : whole) {
    add_pieces(segment, pace, pieces);
  }
  return pieces;
}

std::string told(const MotionSegment& segment) {
  const bool forth = segment.amount > 0;
  const std::string along =
      segment.radius_m > 0 ? fmt::format(" round {:.2f} m", segment.radius_m) : "";
  return segment.kind == MotionSegment::Kind::kLeg
             ? fmt::format("{} {:.2f} m", forth ? "ahead" : "back", std::abs(segment.amount))
             : fmt::format("{} {:.0f} degrees{}", forth ? "left" : "right",
                           rad_to_deg(std::abs(segment.amount)), along);
}

std::vector<Pose2> poses_of(const MotionProgramOptions& program) {
  std::vector<Pose2> poses{Pose2{}};
  for (const MotionSegment& segment : segments_of(program)) {
    const bool is_leg = segment.kind == MotionSegment::Kind::kLeg;
    const double way_m = std::abs(segment.amount) * (is_leg ? 1 : segment.radius_m);
    const int parts = std::max(1, static_cast<int>(std::ceil(way_m / kApart_m - 1e-9)));
    for (int i = 1; i <= parts; ++i) {
      const double gone = segment.amount * i / parts;
      const Vec2 at = segment.from_m + gone * ahead_of(segment.heading_rad);
      poses.push_back(is_leg ? Pose2{at.x(), at.y(), wrap_angle(segment.heading_rad)}
                             : turned(segment, gone));
    }
  }
  return poses;
}

FloorNeeded floor_needed(const std::vector<Pose2>& T_start_body, double reach_m) {
  FloorNeeded floor{reach_m, reach_m, reach_m, reach_m};
  for (const Pose2& pose : T_start_body) {
    floor.ahead_m = std::max(floor.ahead_m, pose.x_m + reach_m);
    floor.behind_m = std::max(floor.behind_m, -pose.x_m + reach_m);
    floor.left_m = std::max(floor.left_m, pose.y_m + reach_m);
    floor.right_m = std::max(floor.right_m, -pose.y_m + reach_m);
  }
  return floor;
}

std::string told(const FloorNeeded& floor) {
  return fmt::format(
      "{:.2f} m ahead of where the robot starts, {:.2f} m behind, {:.2f} m to the left and "
      "{:.2f} m to the right",
      floor.ahead_m, floor.behind_m, floor.left_m, floor.right_m);
}

double expected_s(const MotionProgramOptions& program, const Body& body) {
  const MotionPace pace = pace_of(program, body);
  double all_s = 0;
  for (const MotionSegment& segment : segments_of(program)) {
    const double way = std::abs(segment.amount);
    const MotionPace turning = turn_pace(pace, segment);
    all_s += kSettling_s + pace.stand_s +
             (segment.kind == MotionSegment::Kind::kLeg
                  ? trapezoid_s(way, pace.speed_mps, pace.accel_mps2)
                  : trapezoid_s(way, turning.turn_radps, turning.turn_accel_radps2));
  }
  return all_s;
}

MotionProgram::MotionProgram(const MotionProgramOptions& options, const Body& body,
                             const Timing& platform)
    : segments_(segments_of(options)),
      pace_(pace_of(options, body)),
      cycle_s_(to_seconds(platform.period)),
      lag_s_(to_seconds(platform.worst_latency)) {}

void MotionProgram::locate(const Pose2& T_odom_body) {
  if (!started_) {
    started_ = true;
    T_odom_start_ = T_odom_body;
  }
  T_start_body_ = T_odom_start_.inverse() * T_odom_body;
  heading_rad_ += wrap_angle(T_start_body_.theta_rad - heading_rad_);
}

// What is still driven of the last command is left out of what can be braked in; the rest is
// trapezoids.
double MotionProgram::speed_for(double rest, double before, double most, double accel,
                                double creep) const {
  const double sign = rest < 0 ? -1 : 1;
  const double left = std::abs(rest) - std::max(0.0, sign * before) * lag_s_;
  if (left <= 0) {
    return 0;
  }
  const double least = std::min(creep, most);
  const double faster = std::max(0.0, sign * before) + accel * since_last_s_;
  const double speed = std::min({most, faster, speed_that_stops_mps(left, cycle_s_, accel)});
  return sign * std::max(least, speed);
}

MotionProgram::Reached MotionProgram::drive(const MotionSegment& leg) const {
  const Vec2 along = ahead_of(leg.heading_rad);
  const Vec2 gone = T_start_body_.position() - leg.from_m;
  Reached out;
  out.rest = leg.amount - gone.dot(along);
  out.command_body.v_mps =
      speed_for(out.rest, last_.v_mps, pace_.speed_mps, pace_.accel_mps2, kCreep_mps);
  const double to_the_left_m = along.x() * gone.y() - along.y() * gone.x();
  const double v = out.command_body.v_mps;
  out.command_body.w_radps =
      std::clamp(-kHeadingGain_per_m * std::abs(v) * (heading_rad_ - leg.heading_rad) -
                     kOffsetGain_per_m2 * v * to_the_left_m,
                 -kMostSteering_radps, kMostSteering_radps);
  return out;
}

MotionProgram::Reached MotionProgram::turn(const MotionSegment& turn) const {
  Reached out;
  const MotionPace pace = turn_pace(pace_, turn);
  out.rest = turn.heading_rad - heading_rad_;
  out.command_body.w_radps =
      speed_for(out.rest, last_.w_radps, pace.turn_radps, pace.turn_accel_radps2, kCreep_radps);
  if (turn.radius_m > 0) {
    const Vec2 lacks = turned(turn, turn.amount - out.rest).position() - T_start_body_.position();
    const double wider_m = kArcGain * lacks.dot(ahead_of(heading_rad_));
    const double most_m = kMostWidening * turn.radius_m;
    out.command_body.v_mps =
        (turn.radius_m + std::clamp(wider_m, -most_m, most_m)) * out.command_body.w_radps;
  }
  return out;
}

Twist2 MotionProgram::command(const Odometry& odometry, Duration since_last) {
  locate(odometry.T_odom_body);
  since_last_s_ = to_seconds(since_last);
  const bool stands = last_.v_mps == 0 && last_.w_radps == 0 &&
                      std::abs(odometry.twist_body.v_mps) < kStands_mps &&
                      std::abs(odometry.twist_body.w_radps) < kStands_radps;
  while (!done()) {
    const MotionSegment& segment = segments_[next_];
    const bool is_leg = segment.kind == MotionSegment::Kind::kLeg;
    const Reached reached = is_leg ? drive(segment) : turn(segment);
    gone_ = segment.amount - reached.rest;
    if (std::abs(reached.rest) > (is_leg ? kArrived_m : kArrived_rad)) {
      last_ = reached.command_body;
      return last_;
    }
    if (!stands) {
      break;
    }
    if (stood_s_ < pace_.stand_s) {
      stood_s_ += since_last_s_;
      break;
    }
    ++next_;
    stood_s_ = 0;
    gone_ = 0;
  }
  last_ = {};
  return last_;
}

std::string MotionProgram::doing() const {
  return done() ? "all segments are driven"
                : fmt::format("segment {} of {}: {}", next_ + 1, segments_.size(),
                              told(segments_[next_]));
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/timing.h"
#include "core/camera/observation.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// How fast a programmed motion goes; what the body cannot do is cut to what it can. With `stand_s`
/// it goes stop-start, in pieces, and stands so long after each, so that cameras that cannot be
/// synchronised all see it from one place (thesis 4.3.1).
struct MotionPace {
  double speed_mps = 0.35;
  double accel_mps2 = 0.35;
  double turn_radps = 0.6;
  double turn_accel_radps2 = 1.2;
  double stand_s = 0;
  double piece_m = 0.25;  ///< at most, between two stops
  double piece_rad = deg_to_rad(20);
};

/// A leg ahead and back, then turns on the spot to the left and to the right, each longer than the
/// one before, until views of a whole turn overlap (thesis 4.3.1). The turns add up to 4875 degrees
/// by default, which no slower pace does in a minute and a half.
struct LegsAndTurns {
  static constexpr std::string_view kName = "legs_and_turns";
  double leg_m = 1;
  double step_rad = deg_to_rad(15);
  MotionPace pace{
      .speed_mps = 0.4, .accel_mps2 = 0.4, .turn_radps = 1.45, .turn_accel_radps2 = 2.5};
};
void bind(Fields& f, LegsAndTurns& o);

/// Turns on the spot, `left` and some way back to the right, again and again, until a whole turn
/// and `over` more are done (thesis 4.4). Tells nothing of lengths.
struct Sawtooth {
  static constexpr std::string_view kName = "sawtooth";
  double left_rad = deg_to_rad(90);
  double right_rad = deg_to_rad(45);
  double over_rad = deg_to_rad(45);
  MotionPace pace{.turn_radps = 0.32, .turn_accel_radps2 = 0.8};
};
void bind(Fields& f, Sawtooth& o);

/// Ahead and back, turned on by `step` and again, until a whole turn and `over` more are done.
struct Rose {
  static constexpr std::string_view kName = "rose";
  double petal_m = 0.5;
  double step_rad = deg_to_rad(40);
  double over_rad = deg_to_rad(40);
  MotionPace pace;
};
void bind(Fields& f, Rose& o);

/// Round and round to the left. Tells neither how cameras are turned about the vertical nor where
/// they sit: to see what becomes of a motion that leaves something open.
struct Circle {
  static constexpr std::string_view kName = "circle";
  double radius_m = 0.4;
  double over_rad = deg_to_rad(1800);  ///< more than one round
  MotionPace pace;
};
void bind(Fields& f, Circle& o);

using MotionProgramOptions = std::variant<LegsAndTurns, Sawtooth, Rose, Circle>;

/// A straight leg, or a turn on the spot or along an arc, of a program, in the frame of its start.
/// Headings go on beyond a whole turn.
struct MotionSegment {
  enum class Kind { kLeg, kTurn };
  Kind kind = Kind::kLeg;
  double amount = 0;       ///< metres ahead, or radians to the left
  Vec2 from_m{0, 0};       ///< where it begins,
  double heading_rad = 0;  ///< and the heading it is to end with
  double radius_m = 0;     ///< of a turn: how far to the left its middle is
};
std::vector<MotionSegment> segments_of(const MotionProgramOptions& program);

/// "ahead 0.50 m", "right 105 degrees"
std::string told(const MotionSegment& segment);

/// All places that the body passes, no farther apart than 5 cm, in the frame of its start.
std::vector<Pose2> poses_of(const MotionProgramOptions& program);

/// The floor that a disc which comes within `reach_m` of such places takes, from where it starts.
struct FloorNeeded {
  double ahead_m = 0;
  double behind_m = 0;
  double left_m = 0;
  double right_m = 0;
};
FloorNeeded floor_needed(const std::vector<Pose2>& T_start_body, double reach_m);
/// "1.35 m ahead of where the robot starts, 0.35 m behind, 0.35 m to the left and ..."
std::string told(const FloorNeeded& floor);

/// How long a body takes for it, about.
double expected_s(const MotionProgramOptions& program, const Body& body);

/// Drives a body through a program by what its wheels tell. Every segment ends where the program
/// has it in the frame of the start, so that what one leaves over the next makes up for; it ends
/// when the odometry says that the body stands there, however long that takes.
class MotionProgram {
 public:
  MotionProgram(const MotionProgramOptions& options, const Body& body, const Timing& platform);

  /// The next velocity, `since_last` after the one before. Starts where it is asked first.
  Twist2 command(const Odometry& odometry, Duration since_last);

  bool done() const { return next_ >= segments_.size(); }
  const std::vector<MotionSegment>& segments() const { return segments_; }
  std::size_t at() const { return next_; }  ///< of the segments, the one that is being driven
  double gone() const { return gone_; }     ///< of it, metres or radians

  /// "segment 7 of 26: left 105 degrees"
  std::string doing() const;

 private:
  struct Reached {
    Twist2 command_body;
    double rest = 0;  // of the segment's own unit
  };

  void locate(const Pose2& T_odom_body);
  double speed_for(double rest, double before, double most, double accel, double creep) const;
  Reached drive(const MotionSegment& leg) const;
  Reached turn(const MotionSegment& turn) const;

  std::vector<MotionSegment> segments_;
  MotionPace pace_;
  double cycle_s_;
  double lag_s_;
  double since_last_s_ = 0;
  double stood_s_ = 0;  // at the end of a segment
  bool started_ = false;
  Pose2 T_odom_start_;
  Pose2 T_start_body_;
  double heading_rad_ = 0;  // of the body, from the start on, beyond a whole turn
  Twist2 last_;             // commanded
  std::size_t next_ = 0;
  double gone_ = 0;
};

}  // namespace panoptes

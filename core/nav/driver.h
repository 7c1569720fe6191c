// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/config/fields.h"
#include "core/explore/given_up.h"
#include "core/geometry/body.h"
#include "core/graph/anchored_pose.h"
#include "core/nav/pilot_step.h"
#include "core/plan/dwa.h"
#include "core/plan/path_search.h"
#include "core/plan/reaction.h"

namespace panoptes {

struct DriverOptions {
  SearchOptions search;
  DwaOptions dwa;
  double lookahead_m = 0.7;  ///< ahead on the path
  double replan_s = 0.7;
  double replan_failed_s = 0.2;  ///< between plans while there is none
  int plan_failures = 3;  ///< one after another, then recover: a speck in the local map lasts for a
                          ///< picture or two
  double overlay_m = 1.6;  ///< a plan takes the local map so far about the robot, else the map
  double turn_first_rad =
      deg_to_rad(60);        ///< a lookahead point farther aside than this is turned to on the spot
  double turned_rad = 0.26;  ///< 15 degrees: the dynamic window takes it from there
  double standing_mps = 0.05;  ///< slower than this it may turn on the spot: 3 mm a picture
  double reached_m = 0.10;
  double reached_rad = deg_to_rad(8);
  double stuck_s = 8;      ///< without getting on by half a body, turns apart: recover
  double blocked_s = 1.5;  ///< without any arc that gets on: recover
  double look_about_rad =
      deg_to_rad(720);  ///< on the spot, which is getting on too, at a second a rad: two full turns
  double look_radps = 1.0;  ///< on the spot: pictures of 80 degrees overlap by nine tenths
  double retreat_m = 0.4;   ///< along the own track
  double retreat_mps = 0.12;
  double retreat_turn_rad = 0.35;  ///< back to a track farther aside than this: on the spot first
  double recovery_s = 12;          ///< twice what a full turn or a retreat takes; then it ends
  double same_place_m = 0.5;       ///< what is tried so near to a place was tried there
  double same_goal_m = 0.3;
  double looked_s = 30;       ///< having looked about, it does not again for so long
  double blocked_for_s = 10;  ///< where nothing got on, at least; doubled every time
  double touched_m = 0.05;    ///< around a touched point that is an obstacle: a cell of a plan
  double touched_s = 30;  ///< as long as a goal given up is left alone, and likewise doubled each
                          ///< time: what no camera sees and stays is touched a few times in a
                          ///< run, the logarithm of its length, at most
};
void bind(Fields& f, DriverOptions& o);

struct DriveGoal {
  Pose2 pose_map;
  bool heading_matters = false;  ///< turn to the pose's heading on arrival
  /// Instead of the options of these names, for a goal that is no mere place to look from.
  std::optional<double> goal_tolerance_m = {};
  std::optional<double> reached_m = {};
};

/// What the driver is told at one observation.
struct DriveTask {
  Time stamp;
  const OccupancyMap* local_odom =
      nullptr;  ///< last keyframes and the open one; what it does not know is taken from the map
  const OccupancyMap* map = nullptr;
  std::span<const Pose2> T_map_keyframes;  ///< what was touched is held by them
  Pose2 T_map_odom;
  Pose2 T_odom_body;
  Twist2 twist_body;
  bool bumper_pressed = false;
  std::optional<DriveGoal> goal;  ///< none: stand
  double border_m = 0;   ///< of unknown cells around the known map, for who chooses the goals
  bool relaxed = false;  ///< the map has moved: plan again at once
  bool keep_window = false;
};

struct DriveStep {
  Twist2 command_body;
  PilotState state = PilotState::kStopped;
  std::string reason;
  bool goal_reached = false;
  bool goal_given_up = false;
  bool no_path = false;      ///< to the goal, as things are
  bool way_blocked = false;  ///< what is near blocks it, and plans keep clear of that place from
                             ///< now on: there may be another way, or another goal
  std::optional<Vec2> lookahead_odom;
  std::vector<WindowScore> window;
  std::vector<Vec2> path_map;  ///< the path being followed
  bool replanned = false;
};

/// A square of `side_m` around the robot on cells of `cell_m` in `odom`: the local map, the global
/// one where that knows nothing, and discs of `touched_m` about `touched_odom` as occupied.
/// Single unknown cells among free ones are holes between pixels and count as free.
OccupancyMap window_map(double cell_m, double side_m, const DriveTask& task,
                        const std::vector<Vec2>& touched_odom, double touched_m);

/// Drives to one goal after another: a path over the map, a lookahead point on it, the dynamic
/// window over the local map. Where that fails it recovers, each at most once at one place on the
/// way to one goal, in this order: turn on the spot to look (safe for a disc), retreat slowly along
/// its own track (its only way of reversing), take another way, give the goal up.
class Driver {
 public:
  /// `floor_ahead_m` is how far ahead of the body the floor is seen, at most. It drives no faster
  /// than it can stop in that.
  Driver(const DriverOptions& options, const Body& body, const Timing& timing,
         double floor_ahead_m = 1e9);

  /// The highest speed that it drives at, with the reaction time as it is now.
  double speed_limit_mps() const;
  double reaction_s() const { return reaction_.reaction_s(); }
  double floor_ahead_m() const { return floor_ahead_m_; }

  DriveStep step(const DriveTask& task);

  /// Where it drives, as it sees things at this observation: the map, over which the local map and
  /// what was touched are laid around the robot, on the cells that the dynamic window works on.
  /// Places where nothing got on are occupied. Good until the next call.
  const DrivableGrid& drivable(const DriveTask& task);

  /// The same by the map alone: what passes here and not there is blocked for the moment.
  DrivableGrid drivable_by_map(const DriveTask& task) const;

  /// The same without what was touched and where nothing got on.
  DrivableGrid drivable_unblocked(const DriveTask& task) const;

  /// Where nothing got on.
  std::vector<Vec2> blocked_places_map() const { return blocked_.places_map(); }

  /// Opens those about which the map has changed, for who waits for just that.
  void reopen_changed(const DriveTask& task);

  /// Opens the places where nothing got on once. False where there are none.
  bool try_blocked_again();

 private:
  enum class Mode { kDrive, kLook, kRetreat };

  /// What was tried at a place to get on to a goal.
  enum class Attempt { kNone, kLooked, kRetreated, kWentAnotherWay };
  struct Attempts {
    AnchoredPose place;
    AnchoredPose goal;
    Attempt last = Attempt::kNone;
  };

  /// Where the bumper was pressed: an obstacle until whoever stood there has had time to go, and
  /// from then on where there is another way. For what stays, twice as long each time that it is
  /// touched again.
  struct Touched {
    AnchoredPose place;
    Time until;
    double for_s = 0;
  };

  void plan(const DriveTask& task);
  DrivableGrid grid_near(const DriveTask& task) const;
  OccupancyMap coarse_map(const DriveTask& task, const std::vector<Vec2>& blocked_map) const;
  DrivableGrid grid_by_map(const DriveTask& task, const std::vector<Vec2>& blocked_map) const;
  SearchOptions search_for_goal() const;
  double reached_m() const;
  void follow(const DriveTask& task);
  Attempts& attempts_here(const DriveTask& task);
  bool looked_here(const DriveTask& task) const;
  void start_look(const DriveTask& task, const std::string& why, DriveStep& out);
  void block(const DriveTask& task, const Vec2& p_map);
  bool block_path_ahead(const DriveTask& task);
  bool turns_away(const DriveTask& task, const Path& now) const;
  void leave_way(const DriveTask& task);
  bool block_way_by_map(const DriveTask& task, const Path& by_map);
  void give_up(const std::string& why, DriveStep& out);
  void without_path(const DriveTask& task, DriveStep& out);
  void remember_track(const DriveTask& task);
  void recover(const DriveTask& task, const std::string& why, DriveStep& out);
  void start_retreat(const DriveTask& task, const std::string& why);
  void touch(const DriveTask& task);
  std::vector<Vec2> touched_map(Time now) const;
  std::vector<Vec2> blocked_map(Time now) const;  // and where nothing got on
  void drive(const DriveTask& task, std::optional<Time> blocked_since, DriveStep& out);
  void look(const DriveTask& task, DriveStep& out);
  void retreat(const DriveTask& task, DriveStep& out);
  bool something_behind(const DriveTask& task) const;
  bool took_too_long(const DriveTask& task) const;  // this recovery
  void count_as_getting_on(const DriveTask& task);
  bool getting_on(const DriveTask& task);
  /// Where it is, and how fast, when what is decided now begins to act.
  struct Ahead {
    Pose2 T_odom_body;
    Twist2 twist_body;
  };
  struct Command {
    Time stamp;  // of the observation that it answers
    Twist2 twist_body;
  };

  Ahead look_ahead(const DriveTask& task) const;
  void remember_command(Time now, const Twist2& command_body);
  Twist2 turn_by(double angle_rad, double speed_radps) const;
  Twist2 brake() const;

  DriverOptions options_;
  Body body_;
  Reaction reaction_;
  double floor_ahead_m_;
  Mode mode_ = Mode::kDrive;
  Time mode_since_;
  std::string why_;  // the recovery was begun
  std::optional<DriveGoal> goal_;
  std::optional<DrivableGrid> grid_;
  std::optional<Time> grid_at_;  // made at this observation, and nothing has been touched since
  std::optional<Path> path_;
  std::optional<Path> way_;  // to about this goal, which a plan may lead away from
  int turned_away_ = 0;      // plans in a row that do
  std::string no_path_;      // why not
  int plans_failed_ = 0;     // one after another
  std::size_t along_ = 0;    // point of the path reached
  std::optional<Time> planned_;
  bool turning_ = false;  // to a lookahead point too far aside
  std::vector<Attempts> attempts_;
  std::optional<AnchoredPose> looked_;  // about here, last
  Time looked_at_;
  GivenUp blocked_;  // places of paths where nothing got on
  bool bumper_was_ = false;
  std::deque<Pose2> track_odom_;  // where the body has been, latest last
  double retreat_left_m_ = 0;
  double look_left_rad_ = 0;
  std::optional<Pose2> last_odom_;
  std::deque<Command> commands_;  // that are still to act, and the one that acts
  Ahead ahead_;
  Vec2 got_on_odom_ = Vec2::Zero();  // last place that counted as progress
  Time got_on_;
  double turned_rad_ = 0;              // on the spot since then
  std::optional<Time> blocked_since_;  // and at every step from then on
  std::vector<Touched> touched_;
  bool past_touched_ = false;  // the present plan leads by where something was touched long ago
};

}  // namespace panoptes

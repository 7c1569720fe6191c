// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/base/timing.h"
#include "core/camera/observation.h"
#include "core/config/fields.h"
#include "core/explore/explorer.h"
#include "core/explore/given_up.h"
#include "core/explore/revisit.h"
#include "core/geometry/body.h"
#include "core/nav/driver.h"
#include "core/nav/goal_list.h"
#include "core/nav/pilot_step.h"
#include "core/nav/slam.h"

namespace panoptes {

/// How the places are driven to that it is told.
struct GoalOptions {
  double tolerance_m = 0.06;  ///< a goal that cannot be stood on is moved by at most this and half
                              ///< a cell's diagonal of the search
  double reached_m = 0.04;    ///< nearer than the driver's: what is left over is the map's error
  double given_up_m = 0.3;    ///< around a goal that the driver gave up,
  double given_up_s = 30;     ///< and for so long at least, doubled every time
  double patience_s = 20;     ///< for what blocks a way that the map knows to go
};
void bind(Fields& f, GoalOptions& o);

struct NavigatorOptions {
  SlamOptions slam;
  ExploreOptions explore;
  RevisitOptions revisit;
  DriverOptions driver;
  GoalOptions goals;
  double choose_s = 1.5;          ///< between two looks for a better goal
  int looks_in_vain = 3;          ///< in a row are the end: the map settles for a moment after the
                                  ///< last goal, so that one without a goal is not
  double revisit_ahead_m = 0.6;   ///< how far ahead on a stretch driven again it aims
  double camera_patience_s = 10;  ///< for a lost camera that it steers by to come back
  int revisits_last = 0;  ///< stretches driven again, at most, where no closure is due any more
  bool keep_pictures = false;  ///< window scores in every step
};
void bind(Fields& f, NavigatorOptions& o);

/// Chooses where to go and drives there (thesis 6.3.5): explores what slam maps, then drives
/// earlier paths again where loop closures are due. Told where to drive, it drives there in turn
/// instead: where the map has no way it explores towards the goal, and a goal that nothing leads to
/// is refused at a stand. Equal steps of slam give equal steps, bit for
/// bit. Knows no clock, no file and no truth. While a camera is lost that the floor is mapped by,
/// it stands and chooses nothing; so it does where the odometry tells nothing.
class Navigator {
 public:
  /// `slam` outlives it, and has stepped before each of its steps.
  Navigator(const NavigatorOptions& options, const Body& body, const Timing& timing, Slam& slam,
            const Rng& rng, StageListener listener = {}, const std::vector<Vec2>& goals_map = {});

  /// What the user ought to know before it drives, in words: a top speed that it will not drive at.
  std::vector<std::string> warnings() const;

  PilotStep step(const Observation& seen, const SlamStep& at);

  /// Nothing is left to explore or worth driving again, or every goal is reached or refused.
  bool done() const { return done_; }

  /// What has become of the goals that it was told.
  const std::vector<GoalProgress>& goals() const { return goals_.all(); }

  /// A camera that it steers by has been lost for longer than it waits, in words; else empty.
  const std::string& lost_cameras() const { return lost_cameras_; }

 private:
  void plan(const Observation& seen, const SlamStep& at, PilotStep& step);
  bool camera_lost(Time now);
  void stand(const Observation& seen, const SlamStep& at, PilotStep& step);
  DriveTask task_of(const Observation& seen, const SlamStep& at) const;
  void choose_goal(const Observation& seen, const SlamStep& at);
  ExploreChoice choose_view(const DriveTask& task, const SlamStep& at,
                            const std::optional<ExploreTarget>& target);
  void explore(const DriveTask& task, const SlamStep& at);
  bool waits_for_way(const DriveTask& task, const SlamStep& at);
  void pursue(const DriveTask& task, const SlamStep& at);
  void look_towards_goal(const DriveTask& task, const SlamStep& at, const ExploreTarget& target);
  bool way_to_goal(const DriveTask& task, const DrivableGrid& grid) const;
  bool way_to_goal(const DriveTask& task);
  bool settle(const Observation& seen, const SlamStep& at);
  void end_at_goal(const DriveStep& driven, const DriveTask& task);
  void next_goal();
  std::vector<VisitedPose> visited(const SlamStep& at) const;
  bool begin_revisit(const DriveTask& task, const SlamStep& at,
                     const std::vector<VisitedPose>& visited, bool only_due);
  void choose_revisit_goal(const DriveTask& task, const SlamStep& at);
  DriveGoal revisit_goal(const Pose2& T_map_body);
  void drive(const Observation& seen, const SlamStep& at, PilotStep& step);

  NavigatorOptions options_;
  Body body_;
  Slam& slam_;
  StageListener listener_;
  std::vector<std::string> steers_by_;
  Explorer explorer_;
  Driver driver_;

  std::string lost_cameras_;
  bool done_ = false;
  bool exploring_ = true;  // else driving earlier stretches again
  bool frontier_reachable_ = true;
  OccupancyMap plan_map_;
  std::optional<DriveGoal> goal_;
  std::optional<Time> chosen_;
  std::string why_no_goal_;
  bool driver_tries_ = false;  // to get on to the goal: no other is looked for meanwhile
  std::deque<int> revisit_;    // keyframes of the stretch still to be driven over
  int revisits_ = 0;
  int looks_in_vain_ = 0;       // choices in a row that found nothing left to do
  std::vector<int> revisited_;  // keyframes of stretches that were driven again

  GoalList goals_;
  GivenUp goals_given_up_;
  bool to_goal_ = false;     // goal_ is the present one of goals_, else a place to look from
  bool arrived_ = false;     // and comes to rest there
  int looks_against_ = 0;    // choices in a row by which nothing leads to it
  std::string refusal_;      // why it is refused as soon as the robot is at rest
  bool makes_room_ = false;  // goal_ is a place to wait at
  std::optional<Time> blocked_since_;  // the way that the map knows, to it or to what is unknown
  double nearest_m_ = 0;               // it came to it
};

}  // namespace panoptes

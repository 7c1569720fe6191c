// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/observation.h"
#include "core/camera/rectify.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/explore/explorer.h"
#include "core/explore/revisit.h"
#include "core/geometry/body.h"
#include "core/nav/driver.h"
#include "core/nav/localiser.h"
#include "core/nav/mapper.h"
#include "core/nav/nav_step.h"
#include "core/nav/stage.h"
#include "core/vision/camera_health.h"

namespace panoptes {

struct NavigatorOptions {
  LocaliserOptions localiser;
  MapperOptions mapper;
  ExploreOptions explore;
  RevisitOptions revisit;
  DriverOptions driver;
  double choose_s = 1.5;          ///< between two looks for a better goal
  double revisit_ahead_m = 0.6;   ///< how far ahead on a stretch driven again it aims
  double camera_patience_s = 10;  ///< for a lost camera that it steers by to come back
  int revisits_last = 12;      ///< stretches driven again, at most, once nothing is left to explore
  bool keep_pictures = false;  ///< floor likelihood and window scores in every step
};
void bind(Fields& f, NavigatorOptions& o);

/// The one recipe (thesis chapter 6): localise, map, choose, drive. Equal observations give equal
/// steps, bit for bit. Knows no clock, no file and no truth. Pictures of cameras that are not good
/// are left out; while one of those is lost that the floor is mapped by, it stands and chooses
/// nothing. Pictures that a lens bends are straightened: all that follows, the floor likelihood
/// kept in a step as well, is of pinholes. An observation whose wheels tell no number is passed
/// over, standing.
class Navigator {
 public:
  Navigator(const NavigatorOptions& options, const Body& body, const Rig& rig, Rng rng,
            StageListener listener = {});

  NavStep step(const Observation& raw);

  /// Nothing is left to explore or worth driving again.
  bool done() const { return done_; }

  /// Of every camera of the rig, up to now.
  const CameraReports& cameras() const { return cameras_.reports(); }

  /// A camera that it steers by has been lost for longer than it waits, in words; else empty.
  const std::string& given_up() const { return given_up_; }

  /// Why the robot must not move from where it was started; empty when it may.
  const std::string& start_fault() const { return start_fault_; }

  const std::vector<Keyframe>& keyframes() const { return localiser_.keyframes(); }
  const PoseGraph& graph() const { return localiser_.graph(); }

  /// What a keyframe looked like, and the floor around each as it was seen from there.
  const LoopPlace& place(int keyframe) const { return localiser_.place(keyframe); }
  std::vector<PlacedGrid> grids() const { return mapper_.placed(graph().T_map_node); }

  /// The map, made anew from every keyframe's grid where relaxation has put it.
  OccupancyMap map(double cell_m) const;

  /// The map as the planner has it now: cheap.
  OccupancyMap planning_map();

 private:
  NavStep step_straight(const Observation& seen);
  NavStep step_believed(const Observation& seen);
  bool blind(Time now);
  void stand(const Observation& seen, const Located& located, const Mapped& mapped, NavStep& step);
  DriveTask task_of(const Observation& seen, const Located& located, const Mapped& mapped) const;
  void choose_goal(const Observation& seen, const Located& located, NavStep& step);
  void choose_revisit_goal(const Observation& seen, const Located& located, NavStep& step);
  DriveGoal revisit_goal();
  void drive(const Observation& seen, const Located& located, const Mapped& mapped, NavStep& step);

  NavigatorOptions options_;
  Body body_;
  StageListener listener_;
  CameraHealth cameras_;
  std::vector<std::string> steers_by_;
  std::string given_up_;
  Rectifier rectifier_;
  Localiser localiser_;
  Mapper mapper_;
  Explorer explorer_;
  Driver driver_;

  Pose2 T_map_body_;
  Pose2 T_odom_body_;
  bool looked_at_floor_ = false;
  std::string start_fault_;
  bool done_ = false;
  bool exploring_ = true;  // else driving earlier stretches again
  bool frontier_reachable_ = true;
  OccupancyMap plan_map_;
  std::optional<DriveGoal> goal_;
  std::optional<Time> chosen_;
  std::string why_no_goal_;
  std::deque<int> revisit_;  // keyframes of the stretch still to be driven over
  int revisits_ = 0;
  int looks_in_vain_ = 0;       // choices in a row that found nothing left to do
  std::vector<int> revisited_;  // keyframes that stretches were begun at
};

}  // namespace panoptes

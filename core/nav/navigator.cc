// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/navigator.h"

#include <cmath>
#include <utility>

namespace panoptes {
namespace {

// The map still settles for a moment after the last goal, so one look without a goal is not the
// end.
constexpr int kLooksInVain = 3;

// The floor that the foremost floor camera's mapped part shows, as a sector about the robot's
// heading; what others see besides is not planned for.
FloorWedge wedge_of(const FloorProjection& projection, const Rig& rig, const Body& body) {
  const RigCamera& camera = rig.cameras.at(floor_cameras(rig).front());
  FloorWedge wedge;
  wedge.width_rad = 2 * std::atan(camera.intrinsics.width_px / (2 * camera.intrinsics.fx_px));
  wedge.near_m = projection.front_m;
  wedge.far_m = body.radius_m + camera.floor->far_m;
  return wedge;
}

bool tells_numbers(const Odometry& odometry) {
  const Pose2& T = odometry.T_odom_body;
  const Twist2& twist = odometry.twist_body;
  return std::isfinite(T.x_m) && std::isfinite(T.y_m) && std::isfinite(T.theta_rad) &&
         std::isfinite(twist.v_mps) && std::isfinite(twist.w_radps);
}

}  // namespace

void bind(Fields& f, NavigatorOptions& o) {
  f("localiser", o.localiser);
  f("mapper", o.mapper);
  f("explore", o.explore);
  f("revisit", o.revisit);
  f("driver", o.driver);
  f("choose_s", o.choose_s, positive);
  f("camera_patience_s", o.camera_patience_s, positive);
  f("revisit_ahead_m", o.revisit_ahead_m, positive);
  f("revisits_last", o.revisits_last, not_negative);
  f("keep_pictures", o.keep_pictures);
}

Navigator::Navigator(const NavigatorOptions& options, const Body& body, const Rig& rig, Rng rng,
                     StageListener listener)
    : options_(options),
      body_(body),
      listener_(std::move(listener)),
      cameras_(rig),
      steers_by_(floor_cameras(rig)),
      rectifier_(rig),
      localiser_(options.localiser, body, rectifier_.rig(), rng.fork("localiser")),
      mapper_(options.mapper, body, rectifier_.rig()),
      explorer_(options.explore, body, wedge_of(mapper_.projection(), rectifier_.rig(), body),
                rng.fork("explorer")),
      driver_(options.driver, body) {}

OccupancyMap Navigator::map(double cell_m) const {
  return mapper_.finished_map(cell_m, localiser_.graph().T_map_node);
}

OccupancyMap Navigator::planning_map() { return mapper_.map(localiser_.graph().T_map_node); }

void Navigator::choose_goal(const Observation& seen, const Located& located, NavStep& step) {
  const bool waited = !chosen_ || to_seconds(seen.stamp - *chosen_) >= options_.choose_s;
  const bool due = waited || located.relaxed || (!goal_ && looks_in_vain_ == 0);
  if (!due) {
    return;
  }
  chosen_ = seen.stamp;
  plan_map_ = planning_map();
  step.mapped_free_m2 = plan_map_.free_m2();
  const ExploreChoice choice =
      explorer_.choose(seen.stamp, plan_map_, step.T_map_body, localiser_.graph().T_map_node);
  frontier_reachable_ = choice.frontier_reachable;
  exploring_ = choice.goal.has_value();
  why_no_goal_ = choice.reason;
  if (choice.goal) {
    looks_in_vain_ = 0;
    goal_ = DriveGoal{choice.goal->pose_map, choice.goal->heading_matters};
    revisit_.clear();
  } else {
    choose_revisit_goal(seen, located, step);
  }
}

void Navigator::choose_revisit_goal(const Observation& seen, const Located& located,
                                    NavStep& step) {
  const PoseGraph& graph = localiser_.graph();
  if (revisit_.empty() && revisits_ < options_.revisits_last) {
    const std::vector<Mat3> covariances = path_covariances(graph, located.keyframe);
    std::vector<Place> places;
    for (std::size_t k = 0; k < graph.T_map_node.size(); ++k) {
      places.push_back({graph.T_map_node[k], localiser_.keyframes()[k].stamp,
                        std::sqrt(covariances[k].topLeftCorner<2, 2>().trace())});
    }
    std::vector<Vec2> revisited_map;
    for (const int keyframe : revisited_) {
      revisited_map.push_back(graph.T_map_node[static_cast<std::size_t>(keyframe)].position());
    }
    if (const auto stretch =
            choose_revisit(options_.revisit, options_.explore.search, body_, plan_map_,
                           step.T_map_body, seen.stamp, places, revisited_map)) {
      revisit_.assign(stretch->places.begin(), stretch->places.end());
      revisited_.push_back(revisit_.front());
      ++revisits_;
    }
  }
  if (revisit_.empty()) {
    goal_.reset();
    done_ = ++looks_in_vain_ >= kLooksInVain;
    return;
  }
  looks_in_vain_ = 0;
  goal_ = revisit_goal();
}

// The next place of the stretch, far enough ahead that the robot need not slow down for it.
DriveGoal Navigator::revisit_goal() {
  const std::vector<Pose2>& T_map_nodes = localiser_.graph().T_map_node;
  const auto place = [&] { return T_map_nodes[static_cast<std::size_t>(revisit_.front())]; };
  while (revisit_.size() > 1 &&
         (place().position() - T_map_body_.position()).norm() < options_.revisit_ahead_m) {
    revisit_.pop_front();
  }
  return {place(), false};
}

DriveTask Navigator::task_of(const Observation& seen, const Located& located,
                             const Mapped& mapped) const {
  DriveTask task;
  task.stamp = seen.stamp;
  task.local_odom = &mapped.local_odom;
  task.map = &plan_map_;
  task.T_map_keyframes = localiser_.graph().T_map_node;
  task.T_map_odom = located.T_map_body * located.T_odom_body.inverse();
  task.T_odom_body = located.T_odom_body;
  task.twist_body = seen.odometry.twist_body;
  task.bumper_pressed = seen.health.bumper_pressed;
  task.relaxed = located.relaxed;
  task.keep_window = options_.keep_pictures;
  return task;
}

// Whether a camera is lost that it steers by; it has no others to steer by instead.
bool Navigator::blind(Time now) {
  bool lost = false;
  for (const std::string& name : steers_by_) {
    const auto report = cameras_.reports().find(name);
    if (report == cameras_.reports().end() || report->second.state == CameraState::kGood) {
      continue;
    }
    lost = true;
    if (to_seconds(now - report->second.since) >= options_.camera_patience_s) {
      given_up_ = told(cameras_.reports());
    }
  }
  return lost;
}

// The driver has no goal meanwhile, so that the time it stands counts for nothing.
void Navigator::stand(const Observation& seen, const Located& located, const Mapped& mapped,
                      NavStep& step) {
  step.command_body = driver_.step(task_of(seen, located, mapped)).command_body;
  step.command_body.v_mps = 0;
  step.state = NavState::kStopped;
  step.reason = step.cameras_told;
  step.blind = true;
}

void Navigator::drive(const Observation& seen, const Located& located, const Mapped& mapped,
                      NavStep& step) {
  if (goal_ && !revisit_.empty()) {
    goal_ = revisit_goal();
  }
  DriveTask task = task_of(seen, located, mapped);
  task.goal = goal_;
  DriveStep driven = driver_.step(task);
  step.command_body = driven.command_body;
  step.state = driven.state;
  step.reason = goal_ ? driven.reason : why_no_goal_;
  step.carrot_odom = driven.carrot_odom;
  step.window = std::move(driven.window);
  if (driven.goal_reached || driven.goal_given_up) {
    if (revisit_.empty()) {
      driven.goal_reached ? explorer_.reached() : explorer_.give_up(seen.stamp);
    }
    revisit_.clear();
    goal_.reset();
  }
}

NavStep Navigator::step(const Observation& raw) {
  if (!tells_numbers(raw.odometry)) {
    NavStep stands;
    stands.stamp = raw.stamp;
    stands.T_map_body = T_map_body_;
    stands.T_odom_body = T_odom_body_;
    stands.reason = "the wheels tell no number";
    stands.cameras_told = told(cameras_.reports());
    stands.mapped_free_m2 = plan_map_.free_m2();
    stands.frontier_reachable = frontier_reachable_;
    return stands;
  }
  if (told(cameras_.look(raw)).empty()) {
    return step_believed(raw);
  }
  return step_believed(cameras_.believable(raw));
}

NavStep Navigator::step_believed(const Observation& raw) {
  if (!rectifier_.bends()) {
    return step_straight(raw);
  }
  Observation straight;
  {
    const StageScope scope(listener_, "rectifying");
    straight = rectifier_.rectified(raw);
  }
  return step_straight(straight);
}

NavStep Navigator::step_straight(const Observation& seen) {
  NavStep step;
  step.stamp = seen.stamp;
  step.cameras_told = told(cameras_.reports());
  const std::vector<Pose2>& T_map_nodes = localiser_.graph().T_map_node;
  const Located located = localiser_.step(
      seen, [&](int keyframe) { return mapper_.contour(keyframe, T_map_nodes); }, listener_,
      cameras_.reports());
  T_map_body_ = located.T_map_body;
  T_odom_body_ = located.T_odom_body;
  step.T_map_body = located.T_map_body;
  step.T_odom_body = located.T_odom_body;
  step.keyframe_made = located.keyframe_made;
  step.closures = located.closures;
  step.relaxed = located.relaxed;
  Mapped mapped;
  {
    const StageScope scope(listener_, "mapping");
    mapped = mapper_.step(seen, located, localiser_.keyframes(), T_map_nodes);
  }
  if (options_.keep_pictures) {
    step.floor_log_ratio = mapped.reading.log_ratio;
  }
  if (!looked_at_floor_ && mapped.reading.projection) {
    looked_at_floor_ = true;
    start_fault_ = mapped.reading.sees_floor ? "" : mapped.reading.fault;
  }
  {
    const StageScope scope(listener_, "planning");
    if (!start_fault_.empty()) {
      step.reason = start_fault_;
    } else if (blind(seen.stamp)) {
      stand(seen, located, mapped, step);
    } else if (!looked_at_floor_) {
      step.reason = "waits for the first pictures";
    } else if (!localiser_.keyframes().empty() && !done_) {
      choose_goal(seen, located, step);
      drive(seen, located, mapped, step);
    } else if (done_) {
      step.reason = "nothing is left to explore";
    }
  }
  if (!step.cameras_told.empty() && !step.blind) {
    step.reason += "; " + step.cameras_told;
  }
  if (goal_ && !step.blind) {
    step.goal_map = goal_->pose_map.position();
  }
  step.frontier_reachable = frontier_reachable_;
  if (step.mapped_free_m2 == 0) {
    step.mapped_free_m2 = plan_map_.free_m2();
  }
  return step;
}

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/navigator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/explore/make_room.h"

namespace panoptes {
namespace {

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

constexpr const char* kWaits = "waits for what blocks the way to go";

ExploreOptions with_search(ExploreOptions options, const SearchOptions& search) {
  options.search = search;
  return options;
}

}  // namespace

void bind(Fields& f, GoalOptions& o) {
  f("tolerance_m", o.tolerance_m, not_negative);
  f("reached_m", o.reached_m, positive);
  f("given_up_m", o.given_up_m, not_negative);
  f("given_up_s", o.given_up_s, positive);
  f("patience_s", o.patience_s, not_negative);
}

void bind(Fields& f, NavigatorOptions& o) {
  f("camera_health", o.slam.camera_health);
  f("localiser", o.slam.localiser);
  f("mapper", o.slam.mapper);
  f("explore", o.explore);
  f("revisit", o.revisit);
  f("driver", o.driver);
  f("goals", o.goals);
  f("choose_s", o.choose_s, positive);
  f("looks_in_vain", o.looks_in_vain, at_least(1));
  f("camera_patience_s", o.camera_patience_s, positive);
  f("revisit_ahead_m", o.revisit_ahead_m, positive);
  f("revisits_last", o.revisits_last, not_negative);
  f("keep_pictures", o.keep_pictures);
}

Navigator::Navigator(const NavigatorOptions& options, const Body& body, const Timing& timing,
                     Slam& slam, const Rng& rng, StageListener listener,
                     const std::vector<Vec2>& goals_map)
    : options_(options),
      body_(body),
      slam_(slam),
      listener_(std::move(listener)),
      steers_by_(floor_cameras(slam.rig())),
      explorer_(with_search(options.explore, options.driver.search), body,
                wedge_of(slam.floor_projection(), slam.rig(), body), rng.fork("explorer")),
      driver_(options.driver, body, timing,
              wedge_of(slam.floor_projection(), slam.rig(), body).far_m - body.radius_m),
      goals_(goals_map),
      goals_given_up_(options.goals.given_up_m, options.goals.given_up_s) {
  next_goal();
}

std::vector<std::string> Navigator::warnings() const {
  const double limit_mps = driver_.speed_limit_mps();
  if (limit_mps >= body_.max_speed_mps) {
    return {};
  }
  return {
      fmt::format("robot.max_speed_mps: it drives at {:.2f} m/s at most and not at {:.2f}: it "
                  "takes {:.2f} s to "
                  "react, and has to stop within the {:.2f} m ahead that are looked at",
                  limit_mps, body_.max_speed_mps, driver_.reaction_s(), driver_.floor_ahead_m())};
}

void Navigator::choose_goal(const Observation& seen, const SlamStep& at) {
  const bool waited = !chosen_ || to_seconds(at.stamp - *chosen_) >= options_.choose_s;
  const bool due = waited || at.relaxed || (!goal_ && looks_in_vain_ == 0 && looks_against_ == 0);
  if (!due || (goal_ && driver_tries_) || arrived_ || !refusal_.empty()) {
    return;
  }
  chosen_ = at.stamp;
  plan_map_ = slam_.planning_map();
  const DriveTask task = task_of(seen, at);
  goals_.empty() ? explore(task, at) : pursue(task, at);
}

ExploreChoice Navigator::choose_view(const DriveTask& task, const SlamStep& at,
                                     const std::optional<ExploreTarget>& target) {
  const std::optional<std::vector<Vec2>> standing = slam_.standing();
  const std::vector<Vec2>* standing_map = standing ? &*standing : nullptr;
  ExploreChoice choice = explorer_.choose(at.stamp, driver_.drivable(task), at.T_map_body,
                                          task.T_map_keyframes, standing_map, target);
  if (!choice.goal) {
    // By the map alone: what is near may block the way for the moment.
    choice = explorer_.choose(at.stamp, driver_.drivable_by_map(task), at.T_map_body,
                              task.T_map_keyframes, standing_map, target);
  }
  return choice;
}

void Navigator::explore(const DriveTask& task, const SlamStep& at) {
  if (blocked_since_ && !goal_) {
    driver_.reopen_changed(task);
  }
  ExploreChoice choice = choose_view(task, at, std::nullopt);
  frontier_reachable_ = choice.frontier_reachable;
  if (choice.goal) {
    blocked_since_.reset();
  } else if (revisit_.empty() && !driver_.blocked_places_map().empty()) {
    if (waits_for_way(task, at)) {
      return;
    }
    // where nothing got on may be the only way on: it is tried once more
    if (driver_.try_blocked_again()) {
      choice = choose_view(task, at, std::nullopt);
      frontier_reachable_ = choice.frontier_reachable;
    }
  }
  exploring_ = choice.goal.has_value();
  why_no_goal_ = choice.reason;
  makes_room_ = false;
  if (choice.goal) {
    looks_in_vain_ = 0;
    goal_ = DriveGoal{choice.goal->pose_map, choice.goal->heading_matters};
    revisit_.clear();
  } else {
    choose_revisit_goal(task, at);
  }
}

// Whether it gives what blocks the way to more unknown floor a while longer to go, where things
// come and go. Somebody who stands there may wait for the robot: it makes room first.
bool Navigator::waits_for_way(const DriveTask& task, const SlamStep& at) {
  if (!slam_.something_came()) {
    return false;
  }
  if (blocked_since_ && to_seconds(at.stamp - *blocked_since_) >= options_.goals.patience_s) {
    return false;
  }
  if (!explorer_
           .choose(at.stamp, driver_.drivable_unblocked(task), at.T_map_body, task.T_map_keyframes)
           .goal) {
    return false;
  }
  if (!blocked_since_) {
    blocked_since_ = at.stamp;
    goal_.reset();
    const std::optional<Vec2> room =
        place_to_make_room(options_.driver.search, driver_.drivable(task), at.T_map_body.position(),
                           driver_.blocked_places_map());
    makes_room_ = room.has_value();
    if (room) {
      goal_ = DriveGoal{{room->x(), room->y(), 0}, false};
    }
  } else if (!makes_room_) {
    goal_.reset();
  }
  looks_in_vain_ = 1;  // and the next look is not at once
  why_no_goal_ = kWaits;
  return true;
}

bool Navigator::way_to_goal(const DriveTask& task, const DrivableGrid& grid) const {
  SearchOptions search = options_.driver.search;
  search.goal_tolerance_m = options_.goals.tolerance_m;
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  return search_path(search, grid, here_map, goals_.present().goal_map).path.has_value();
}

// By the map alone as well: what is near may block the way for the moment.
bool Navigator::way_to_goal(const DriveTask& task) {
  return way_to_goal(task, driver_.drivable(task)) ||
         way_to_goal(task, driver_.drivable_by_map(task));
}

void Navigator::pursue(const DriveTask& task, const SlamStep& at) {
  const Vec2 goal_map = goals_.present().goal_map;
  nearest_m_ = std::min(nearest_m_, (goal_map - at.T_map_body.position()).norm());
  goals_given_up_.update(
      at.stamp, [this](const Vec2& p_map) { return plan_map_.at(p_map); }, task.T_map_keyframes);
  to_goal_ = false;
  const bool left_alone = goals_given_up_.contains(goal_map);
  if ((goal_map - at.T_map_body.position()).norm() <= options_.goals.reached_m) {
    arrived_ = true;
    goal_.reset();
  } else if (!left_alone && way_to_goal(task)) {
    to_goal_ = true;
    looks_against_ = 0;
    looks_in_vain_ = 0;
    blocked_since_.reset();
    goal_ = DriveGoal{{goal_map.x(), goal_map.y(), 0},
                      false,
                      options_.goals.tolerance_m,
                      options_.goals.reached_m};
  } else {
    look_towards_goal(task, at, {goal_map, options_.goals.tolerance_m});
  }
}

// Where the map has no way to the goal yet.
void Navigator::look_towards_goal(const DriveTask& task, const SlamStep& at,
                                  const ExploreTarget& target) {
  const auto stand = [&](int& looks, const std::string& why) {
    goal_.reset();
    why_no_goal_ = why;
    if (++looks >= options_.looks_in_vain) {
      refusal_ = why;
    }
  };
  const DrivableGrid unblocked = driver_.drivable_unblocked(task);
  const std::optional<std::vector<Vec2>> standing = slam_.standing();
  const TargetOutlook outlook = explorer_.outlook(
      target, unblocked, at.T_map_body, task.T_map_keyframes, standing ? &*standing : nullptr);
  if (outlook != TargetOutlook::kOpen) {
    stand(looks_against_,
          outlook == TargetOutlook::kObstructed ? "something stands there" : "no way leads there");
    return;
  }
  looks_against_ = 0;
  const ExploreChoice choice = choose_view(task, at, target);
  frontier_reachable_ = choice.frontier_reachable;
  if (choice.goal) {
    looks_in_vain_ = 0;
    blocked_since_.reset();
    goal_ = DriveGoal{choice.goal->pose_map, choice.goal->heading_matters};
    return;
  }
  if (way_to_goal(task, unblocked)) {
    blocked_since_ = blocked_since_.value_or(at.stamp);
    if (to_seconds(at.stamp - *blocked_since_) < options_.goals.patience_s) {
      looks_in_vain_ = 1;  // and the next look is not at once
      goal_.reset();
      why_no_goal_ = kWaits;
      return;
    }
    stand(looks_in_vain_, "the way there that the map shows is blocked");
    return;
  }
  stand(looks_in_vain_,
        fmt::format("nothing leads there that can be seen from anywhere reachable; it came within "
                    "{:.2f} m",
                    nearest_m_));
}

void Navigator::next_goal() {
  to_goal_ = false;
  arrived_ = false;
  looks_against_ = 0;
  looks_in_vain_ = 0;
  refusal_.clear();
  blocked_since_.reset();
  nearest_m_ = std::numeric_limits<double>::infinity();
  goal_.reset();
  chosen_.reset();
}

// Ends the present goal where it has come to something and the robot is at rest. True where nothing
// is left to do.
bool Navigator::settle(const Observation& seen, const SlamStep& at) {
  if (goals_.empty() || done_) {
    return done_;
  }
  constexpr double kRest_mps = 0.01;
  constexpr double kRest_radps = 0.02;
  goals_.begin(at.stamp);
  nearest_m_ = std::min(nearest_m_, (goals_.present().goal_map - at.T_map_body.position()).norm());
  const Twist2& twist = seen.odometry.twist_body;
  if ((!arrived_ && refusal_.empty()) || std::abs(twist.v_mps) > kRest_mps ||
      std::abs(twist.w_radps) > kRest_radps) {
    return false;
  }
  if (arrived_) {
    goals_.reach(at.stamp);
  } else {
    goals_.refuse(at.stamp, refusal_);
  }
  next_goal();
  done_ = goals_.done();
  return done_;
}

// The keyframes, and how uncertain they are seen from here. By one path through the graph first;
// where many join two places one alone says too much, so of those that seem to be owed a closure
// the whole graph is asked.
std::vector<VisitedPose> Navigator::visited(const SlamStep& at) const {
  const SharedGraph& graph = slam_.graph();
  const std::vector<Mat3> covariances =
      path_covariances(graph, at.keyframe, state_covariance(graph));
  const auto in_plane_m = [](const Mat3& covariance) {
    return std::sqrt(covariance.topLeftCorner<2, 2>().trace());
  };
  std::vector<VisitedPose> visited;
  for (std::size_t k = 0; k < graph.T_map_node.size(); ++k) {
    visited.push_back(
        {graph.T_map_node[k], slam_.keyframes()[k].stamp, in_plane_m(covariances[k])});
  }
  constexpr std::size_t kApart = 8;  // keyframes, two metres: those between are as sure
  std::optional<SharedUncertainty> whole;
  std::size_t asked = 0;
  for (std::size_t k = 0; k < visited.size(); ++k) {
    const double away_m = (visited[k].T_map_body.position() - at.T_map_body.position()).norm();
    if (!closure_due(options_.revisit, at.stamp, visited, k, away_m)) {
      continue;
    }
    if (whole && k < asked + kApart) {
      visited[k].uncertainty_m = visited[asked].uncertainty_m;
      continue;
    }
    if (!whole) {
      whole.emplace(graph);
    }
    asked = k;
    visited[k].uncertainty_m = in_plane_m(whole->relative(at.keyframe, static_cast<int>(k)));
  }
  return visited;
}

bool Navigator::begin_revisit(const DriveTask& task, const SlamStep& at,
                              const std::vector<VisitedPose>& visited, bool only_due) {
  std::vector<Vec2> revisited_map;
  for (const int keyframe : revisited_) {
    revisited_map.push_back(visited[static_cast<std::size_t>(keyframe)].T_map_body.position());
  }
  const auto stretch =
      choose_revisit(options_.revisit, options_.driver.search, driver_.drivable(task),
                     at.T_map_body, at.stamp, visited, revisited_map, only_due);
  if (!stretch) {
    return false;
  }
  revisit_.assign(stretch->places.begin(), stretch->places.end());
  // where a closure was due it is tried once, all along
  const auto tried = only_due ? revisit_.end() : revisit_.begin() + 1;
  revisited_.insert(revisited_.end(), revisit_.begin(), tried);
  return true;
}

void Navigator::choose_revisit_goal(const DriveTask& task, const SlamStep& at) {
  if (revisit_.empty()) {
    const std::vector<VisitedPose> places = visited(at);
    if (!begin_revisit(task, at, places, true) && revisits_ < options_.revisits_last &&
        begin_revisit(task, at, places, false)) {
      ++revisits_;
    }
  }
  if (revisit_.empty()) {
    goal_.reset();
    done_ = ++looks_in_vain_ >= options_.looks_in_vain;
    return;
  }
  looks_in_vain_ = 0;
  goal_ = revisit_goal(at.T_map_body);
}

// The next place of the stretch, far enough ahead that the robot need not slow down for it.
DriveGoal Navigator::revisit_goal(const Pose2& T_map_body) {
  const std::vector<Pose2>& T_map_nodes = slam_.graph().T_map_node;
  const auto place = [&] { return T_map_nodes[static_cast<std::size_t>(revisit_.front())]; };
  while (revisit_.size() > 1 &&
         (place().position() - T_map_body.position()).norm() < options_.revisit_ahead_m) {
    revisit_.pop_front();
  }
  return {place(), false};
}

DriveTask Navigator::task_of(const Observation& seen, const SlamStep& at) const {
  DriveTask task;
  task.stamp = at.stamp;
  task.local_odom = &at.local_odom;
  task.map = &plan_map_;
  task.T_map_keyframes = slam_.graph().T_map_node;
  task.T_map_odom = at.T_map_body * at.T_odom_body.inverse();
  task.T_odom_body = at.T_odom_body;
  task.twist_body = seen.odometry.twist_body;
  task.bumper_pressed = seen.health.bumper_pressed;
  task.relaxed = at.relaxed;
  task.border_m = explorer_.border_m();
  task.keep_window = options_.keep_pictures;
  return task;
}

// Whether a camera is lost that it steers by; it has no others to steer by instead.
bool Navigator::camera_lost(Time now) {
  bool lost = false;
  for (const std::string& name : steers_by_) {
    const auto report = slam_.cameras().find(name);
    if (report == slam_.cameras().end() || report->second.state == CameraState::kGood) {
      continue;
    }
    lost = true;
    if (to_seconds(now - report->second.since) >= options_.camera_patience_s) {
      lost_cameras_ = told(slam_.cameras());
    }
  }
  return lost;
}

// The driver has no goal meanwhile, so that the time it stands counts for nothing.
void Navigator::stand(const Observation& seen, const SlamStep& at, PilotStep& step) {
  step.command_body = driver_.step(task_of(seen, at)).command_body;
  step.command_body.v_mps = 0;
  step.reason = at.cameras_told;
  step.camera_lost = true;
}

void Navigator::drive(const Observation& seen, const SlamStep& at, PilotStep& step) {
  if (goal_ && !revisit_.empty()) {
    goal_ = revisit_goal(at.T_map_body);
  }
  DriveTask task = task_of(seen, at);
  task.goal = goal_;
  DriveStep driven = driver_.step(task);
  driver_tries_ = driven.no_path || driven.state == PilotState::kRecovering;
  step.command_body = driven.command_body;
  step.state = driven.state;
  step.reason = goal_ ? driven.reason : arrived_ ? "stops at the goal" : why_no_goal_;
  step.lookahead_odom = driven.lookahead_odom;
  step.window = std::move(driven.window);
  if (driven.goal_reached || driven.goal_given_up) {
    if (to_goal_) {
      end_at_goal(driven, task);
    } else if (revisit_.empty() && !makes_room_) {
      if (driven.goal_reached) {
        explorer_.reached();
      } else {
        explorer_.abandon(at.stamp, driver_.drivable(task).clearance.map, task.T_map_keyframes);
      }
    }
    revisit_.clear();
    goal_.reset();
    makes_room_ = false;
  } else if (driven.way_blocked) {
    revisit_.clear();
    goal_.reset();
    makes_room_ = false;
  }
}

// A goal that the map has a way to all the same is left alone for a while.
void Navigator::end_at_goal(const DriveStep& driven, const DriveTask& task) {
  arrived_ = driven.goal_reached;
  if (driven.goal_given_up && way_to_goal(task)) {
    const Vec2 goal_map = goals_.present().goal_map;
    goals_given_up_.add(
        task.stamp, {goal_map.x(), goal_map.y(), 0},
        [this](const Vec2& p_map) { return plan_map_.at(p_map); }, task.T_map_keyframes);
  }
}

PilotStep Navigator::step(const Observation& seen, const SlamStep& at) {
  PilotStep step;
  if (!at.passed_over.empty()) {
    step.reason = at.passed_over;
  } else {
    plan(seen, at, step);
  }
  step.frontier_reachable = frontier_reachable_;
  step.mapped_free_m2 = plan_map_.area_m2(Cell::kFree);
  step.goals = goals_.all();
  return step;
}

void Navigator::plan(const Observation& seen, const SlamStep& at, PilotStep& step) {
  {
    const StageScope scope(listener_, "planning");
    if (!slam_.start_fault().empty()) {
      step.reason = slam_.start_fault();
    } else if (camera_lost(at.stamp)) {
      stand(seen, at, step);
    } else if (!slam_.looked_at_floor()) {
      step.reason = "waits for the first pictures";
    } else if (!slam_.keyframes().empty() && !settle(seen, at)) {
      choose_goal(seen, at);
      drive(seen, at, step);
    } else if (done_) {
      step.reason = goals_.empty() ? "nothing is left to explore" : "no goal is left";
    }
  }
  if (!at.cameras_told.empty() && !step.camera_lost) {
    step.reason += "; " + at.cameras_told;
  }
  if (goal_ && !step.camera_lost) {
    step.goal_map = goal_->pose_map.position();
  }
}

}  // namespace panoptes

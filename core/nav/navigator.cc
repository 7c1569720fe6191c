// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/navigator.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

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

ExploreOptions with_search(ExploreOptions options, const SearchOptions& search) {
  options.search = search;
  return options;
}

}  // namespace

void bind(Fields& f, NavigatorOptions& o) {
  f("camera_health", o.slam.camera_health);
  f("localiser", o.slam.localiser);
  f("mapper", o.slam.mapper);
  f("explore", o.explore);
  f("revisit", o.revisit);
  f("driver", o.driver);
  f("choose_s", o.choose_s, positive);
  f("looks_in_vain", o.looks_in_vain, at_least(1));
  f("camera_patience_s", o.camera_patience_s, positive);
  f("revisit_ahead_m", o.revisit_ahead_m, positive);
  f("revisits_last", o.revisits_last, not_negative);
  f("keep_pictures", o.keep_pictures);
}

Navigator::Navigator(const NavigatorOptions& options, const Body& body, const Timing& timing,
                     Slam& slam, const Rng& rng, StageListener listener)
    : options_(options),
      body_(body),
      slam_(slam),
      listener_(std::move(listener)),
      steers_by_(floor_cameras(slam.rig())),
      explorer_(with_search(options.explore, options.driver.search), body,
                wedge_of(slam.floor_projection(), slam.rig(), body), rng.fork("explorer")),
      driver_(options.driver, body, timing,
              wedge_of(slam.floor_projection(), slam.rig(), body).far_m - body.radius_m) {}

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
  const bool due = waited || at.relaxed || (!goal_ && looks_in_vain_ == 0);
  if (!due || (goal_ && driver_tries_)) {
    return;
  }
  chosen_ = at.stamp;
  plan_map_ = slam_.planning_map();
  const DriveTask task = task_of(seen, at);
  const std::vector<Pose2>& T_map_nodes = slam_.graph().T_map_node;
  const std::optional<std::vector<Vec2>> standing = slam_.standing();
  const std::vector<Vec2>* standing_map = standing ? &*standing : nullptr;
  ExploreChoice choice =
      explorer_.choose(at.stamp, driver_.drivable(task), at.T_map_body, T_map_nodes, standing_map);
  if (!choice.goal) {
    // By the map alone: what is near may block the way for the moment.
    choice = explorer_.choose(at.stamp, driver_.drivable_by_map(task), at.T_map_body, T_map_nodes,
                              standing_map);
  }
  frontier_reachable_ = choice.frontier_reachable;
  exploring_ = choice.goal.has_value();
  why_no_goal_ = choice.reason;
  if (choice.goal) {
    looks_in_vain_ = 0;
    goal_ = DriveGoal{choice.goal->pose_map, choice.goal->heading_matters};
    revisit_.clear();
  } else {
    choose_revisit_goal(task, at);
  }
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
  step.reason = goal_ ? driven.reason : why_no_goal_;
  step.lookahead_odom = driven.lookahead_odom;
  step.window = std::move(driven.window);
  if (driven.goal_reached || driven.goal_given_up) {
    if (revisit_.empty()) {
      if (driven.goal_reached) {
        explorer_.reached();
      } else {
        explorer_.abandon(at.stamp, driver_.drivable(task).clearance.map, task.T_map_keyframes);
      }
    }
    revisit_.clear();
    goal_.reset();
  } else if (driven.way_blocked) {
    revisit_.clear();
    goal_.reset();
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
    } else if (!slam_.keyframes().empty() && !done_) {
      choose_goal(seen, at);
      drive(seen, at, step);
    } else if (done_) {
      step.reason = "nothing is left to explore";
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

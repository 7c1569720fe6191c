// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/driver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kDetour_m = 0.5;  // longer than another, a path is another way
constexpr double kTrackStep_m = 0.02;
constexpr double kTrackLength_m = 2.0;

/// What is known of a point, by the local map first.
Cell known(const DriveTask& task, const Vec2& p_map) {
  const Cell near = task.local_odom->at(task.T_map_odom.inverse() * p_map);
  return near != Cell::kUnknown ? near : task.map->at(p_map);
}

OccupancyMap unknown_around(const Vec2& p, double within_m, double cell_m) {
  OccupancyMap map;
  map.cell_m = cell_m;
  map.origin = p - Vec2::Constant(within_m);
  const int side = static_cast<int>(std::ceil(2 * within_m / cell_m));
  map.assign(side, side);
  return map;
}

}  // namespace

void bind(Fields& f, DriverOptions& o) {
  f("search", o.search);
  f("dwa", o.dwa);
  f("lookahead_m", o.lookahead_m, positive);
  f("replan_s", o.replan_s, positive);
  f("replan_failed_s", o.replan_failed_s, not_negative);
  f("plan_failures", o.plan_failures, at_least(1));
  f("overlay_m", o.overlay_m, between(0.1, 20));
  f.angle("turn_first", o.turn_first_rad, between(0.2, std::numbers::pi));
  f.angle("turned", o.turned_rad, between(0.01, std::numbers::pi));
  f("standing_mps", o.standing_mps, positive);
  f("reached_m", o.reached_m, positive);
  f.angle("reached", o.reached_rad, positive);
  f("stuck_s", o.stuck_s, positive);
  f("blocked_s", o.blocked_s, positive);
  f.angle("look_about", o.look_about_rad, not_negative);
  f("look_radps", o.look_radps, positive);
  f("retreat_m", o.retreat_m, positive);
  f("retreat_mps", o.retreat_mps, positive);
  f.angle("retreat_turn", o.retreat_turn_rad, between(0.01, std::numbers::pi));
  f("recovery_s", o.recovery_s, positive);
  f("same_place_m", o.same_place_m, positive);
  f("same_goal_m", o.same_goal_m, positive);
  f("looked_s", o.looked_s, not_negative);
  f("blocked_for_s", o.blocked_for_s, positive);
  f("touched_m", o.touched_m, between(0, 1));
  f("touched_s", o.touched_s, not_negative);
  f.renamed("carrot_m", "lookahead_m");
}

OccupancyMap window_map(double cell_m, double side_m, const DriveTask& task,
                        const std::vector<Vec2>& touched_odom, double touched_m) {
  const OccupancyMap& local = *task.local_odom;
  OccupancyMap window;
  window.cell_m = cell_m;
  const int side = static_cast<int>(std::ceil(side_m / cell_m));
  window.assign(side, side);
  // On a fixed grid in odom, so that cells do not shift under the robot from one step to the next.
  const Vec2 corner =
      task.T_odom_body.position() - Vec2::Constant(0.5 * window.columns * window.cell_m);
  window.origin = {std::floor(corner.x() / window.cell_m) * window.cell_m,
                   std::floor(corner.y() / window.cell_m) * window.cell_m};
  const Mat2 R_map_odom = task.T_map_odom.rotation();
  // Both grids lie along odom's axes: columns and rows correspond once and for all.
  const int samples = parts_a_side(window.cell_m, local.cell_m);
  const auto corresponding = [&](double start, double local_start) {
    std::vector<int> cells(static_cast<std::size_t>(side) * samples);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double p = start + window.cell_m * (static_cast<double>(i) + 0.5) / samples;
      cells[i] = static_cast<int>(std::floor((p - local_start) / local.cell_m));
    }
    return cells;
  };
  const std::vector<int> local_columns = corresponding(window.origin.x(), local.origin.x());
  const std::vector<int> local_rows = corresponding(window.origin.y(), local.origin.y());
  for (int row = 0; row < window.rows; ++row) {
    for (int column = 0; column < window.columns; ++column) {
      Cell cell = resampled(samples, [&](int i, int j) {
        return local.at(local_columns[static_cast<std::size_t>(column) * samples + i],
                        local_rows[static_cast<std::size_t>(row) * samples + j]);
      });
      if (cell == Cell::kUnknown) {
        cell = task.map->at(task.T_map_odom.position() + R_map_odom * window.centre(column, row));
      }
      window(column, row) = cell;
    }
  }
  const OccupancyMap known = window;
  constexpr int kMostFree = 6;  // of eight neighbours: a lone cell or a pair
  for (int row = 1; row + 1 < window.rows; ++row) {
    for (int column = 1; column + 1 < window.columns; ++column) {
      if (known(column, row) != Cell::kUnknown) {
        continue;
      }
      int free = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          free += known(column + dx, row + dy) == Cell::kFree ? 1 : 0;
        }
      }
      if (free >= kMostFree) {
        window(column, row) = Cell::kFree;
      }
    }
  }
  for (const Vec2& p : touched_odom) {
    occupy_disc(window, p, touched_m);
  }
  return window;
}

Driver::Driver(const DriverOptions& options, const Body& body, const Timing& timing,
               double floor_ahead_m)
    : options_(options),
      body_(body),
      reaction_(timing),
      floor_ahead_m_(std::min(floor_ahead_m, options.dwa.distance_cap_m)),
      blocked_(body.radius_m, options.blocked_for_s) {}

double Driver::speed_limit_mps() const {
  return std::min(body_.max_speed_mps, speed_that_stops_mps(floor_ahead_m_, reaction_.reaction_s(),
                                                            body_.max_accel_mps2));
}

SearchOptions Driver::search_for_goal() const {
  SearchOptions search = options_.search;
  search.goal_tolerance_m = goal_->goal_tolerance_m.value_or(search.goal_tolerance_m);
  return search;
}

double Driver::reached_m() const { return goal_->reached_m.value_or(options_.reached_m); }

DrivableGrid Driver::drivable_by_map(const DriveTask& task) const {
  return grid_by_map(task, blocked_map(task.stamp));
}

DrivableGrid Driver::drivable_unblocked(const DriveTask& task) const {
  return grid_by_map(task, {});
}

void Driver::reopen_changed(const DriveTask& task) {
  grid_at_.reset();
  blocked_.reopen_changed([&](const Vec2& p_map) { return known(task, p_map); });
}

bool Driver::try_blocked_again() {
  grid_at_.reset();
  return blocked_.try_again();
}

OccupancyMap Driver::coarse_map(const DriveTask& task, const std::vector<Vec2>& blocked_map) const {
  OccupancyMap coarse =
      coarsen(*task.map, options_.search.cell_m, std::max(options_.overlay_m, task.border_m));
  if (coarse.cells.empty()) {
    const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
    coarse = unknown_around(here_map, options_.overlay_m, coarse.cell_m);
  }
  for (const Vec2& p : blocked_map) {
    occupy_disc(coarse, p, options_.touched_m);
  }
  return coarse;
}

DrivableGrid Driver::grid_by_map(const DriveTask& task,
                                 const std::vector<Vec2>& blocked_map) const {
  return drivable_grid_of_coarse(from_afar(options_.search), body_, coarse_map(task, blocked_map));
}

DrivableGrid Driver::grid_near(const DriveTask& task) const {
  const Pose2 T_odom_map = task.T_map_odom.inverse();
  const std::vector<Vec2> blocked = blocked_map(task.stamp);
  std::vector<Vec2> blocked_odom = blocked;
  for (Vec2& p : blocked_odom) {
    p = T_odom_map * p;
  }
  NearMap near;
  near.T_window_map = T_odom_map;
  near.robot_map = (task.T_map_odom * task.T_odom_body).position();
  near.within_m = options_.overlay_m;
  const double reach_m = body_.radius_m + options_.search.margin_m +
                         options_.search.inflation_distance_m + options_.search.cell_m;
  const double side_m = 2 * (near.within_m + reach_m);
  near.window = clearance_map(
      window_map(options_.dwa.cell_m, side_m, task, blocked_odom, options_.touched_m), reach_m);
  return drivable_grid_with(options_.search, body_, coarse_map(task, blocked), std::move(near));
}

const DrivableGrid& Driver::drivable(const DriveTask& task) {
  if (grid_at_ != task.stamp || !grid_) {
    grid_ = grid_near(task);
    grid_at_ = task.stamp;
  }
  return *grid_;
}

// Whether a new path is a detour from the way that it was on, to about the same place.
bool Driver::turns_away(const DriveTask& task, const Path& now) const {
  if (!way_ || (way_->points.back() - now.points.back()).norm() > options_.same_goal_m) {
    return false;
  }
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  const std::vector<Vec2>& way = way_->points;
  const auto nearest = std::min_element(way.begin(), way.end(), [&](const Vec2& a, const Vec2& b) {
    return (a - here_map).squaredNorm() < (b - here_map).squaredNorm();
  });
  double left_m = (*nearest - here_map).norm();
  if (left_m > options_.same_place_m) {
    return false;
  }
  for (auto p = nearest + 1; p < way.end(); ++p) {
    left_m += (*p - *(p - 1)).norm();
  }
  return now.length_m > left_m + kDetour_m;
}

// Where what is near stands in the short way, which from farther away looks free again, the robot
// would turn to and fro. A speck that lasts for a plan or two closes nothing.
void Driver::leave_way(const DriveTask& task) {
  if (!path_) {
    return;
  }
  if (!turns_away(task, *path_)) {
    way_ = path_;
    turned_away_ = 0;
    return;
  }
  if (++turned_away_ < options_.plan_failures) {
    return;
  }
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  const std::optional<Path> by_map =
      search_path(search_for_goal(), drivable_by_map(task), here_map, goal_->pose_map.position())
          .path;
  if (by_map && by_map->length_m + kDetour_m < path_->length_m) {
    block_way_by_map(task, *by_map);
  }
  way_ = path_;
  turned_away_ = 0;
}

void Driver::plan(const DriveTask& task) {
  planned_ = task.stamp;
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  PathSearch found;
  for (const bool past_touched : {false, true}) {
    if (past_touched_ != past_touched) {
      past_touched_ = past_touched;
      grid_at_.reset();
    }
    found = search_path(search_for_goal(), drivable(task), here_map, goal_->pose_map.position());
    if (found.path || touched_.empty()) {
      break;
    }
  }
  path_ = std::move(found.path);
  leave_way(task);
  no_path_ = std::move(found.reason);
  plans_failed_ = path_ ? 0 : plans_failed_ + 1;
  along_ = 0;
}

void Driver::remember_track(const DriveTask& task) {
  if (mode_ == Mode::kRetreat) {
    return;
  }
  if (track_odom_.empty() ||
      (track_odom_.back().position() - task.T_odom_body.position()).norm() >= kTrackStep_m) {
    track_odom_.push_back(task.T_odom_body);
    if (track_odom_.size() > static_cast<std::size_t>(kTrackLength_m / kTrackStep_m)) {
      track_odom_.pop_front();
    }
  }
}

Twist2 Driver::turn_by(double angle_rad, double speed_radps) const {
  // The speed from which it can just stop in time at half the limit, less what a cycle covers.
  const double left = std::max(0.0, std::abs(angle_rad) - 0.02);
  const double speed = std::min(speed_radps, std::sqrt(body_.max_turn_accel_radps2 * left));
  const double wanted = angle_rad < 0 ? -speed : speed;
  const double dw = body_.max_turn_accel_radps2 * reaction_.cycle_s();
  const double now = ahead_.twist_body.w_radps;
  return {0, std::clamp(wanted, now - dw, now + dw)};
}

Twist2 Driver::brake() const {
  // On the same arc, which was chosen so that one can stop on it.
  const Twist2& now = ahead_.twist_body;
  const double dv = body_.max_accel_mps2 * reaction_.longest_cycle_s();
  const double v = now.v_mps > 0 ? std::max(0.0, now.v_mps - dv) : std::min(0.0, now.v_mps + dv);
  const double share = std::abs(now.v_mps) > 1e-6 ? v / now.v_mps : 0.0;
  return {v, share * now.w_radps};
}

// A robot that obeys goes at a speed between that of the command that acts now and that of the
// latest one, but for what it gains or loses in a cycle or two.
Driver::Ahead Driver::look_ahead(const DriveTask& task) const {
  const Duration lag = from_seconds(reaction_.lag_s());
  const double tolerance_mps = 2 * body_.max_accel_mps2 * reaction_.longest_cycle_s();
  double low_mps = 0;
  double high_mps = 0;
  if (!commands_.empty()) {
    const auto [low, high] = std::minmax_element(
        commands_.begin(), commands_.end(),
        [](const auto& a, const auto& b) { return a.twist_body.v_mps < b.twist_body.v_mps; });
    low_mps = low->twist_body.v_mps;
    high_mps = high->twist_body.v_mps;
  }
  if (task.twist_body.v_mps < low_mps - tolerance_mps ||
      task.twist_body.v_mps > high_mps + tolerance_mps) {
    return {task.T_odom_body * exp_twist(task.twist_body, to_seconds(lag)), task.twist_body};
  }
  Ahead ahead{task.T_odom_body, commands_.empty() ? Twist2{} : commands_.back().twist_body};
  for (std::size_t i = 0; i < commands_.size(); ++i) {
    const Time begin = std::max(task.stamp, commands_[i].stamp + lag);
    const Time end = i + 1 < commands_.size() ? commands_[i + 1].stamp + lag : task.stamp + lag;
    if (end > begin) {
      ahead.T_odom_body =
          ahead.T_odom_body * exp_twist(commands_[i].twist_body, to_seconds(end - begin));
    }
  }
  return ahead;
}

// The commands that act between this observation and the command that answers it.
void Driver::remember_command(Time now, const Twist2& command_body) {
  commands_.push_back({now, command_body});
  const Duration lag = from_seconds(reaction_.lag_s());
  while (commands_.size() > 1 && commands_[1].stamp + lag <= now) {
    commands_.pop_front();
  }
}

void Driver::start_retreat(const DriveTask& task, const std::string& why) {
  mode_ = Mode::kRetreat;
  mode_since_ = task.stamp;
  turning_ = false;
  why_ = why;
  retreat_left_m_ = options_.retreat_m;
}

Driver::Attempts& Driver::attempts_here(const DriveTask& task) {
  const Pose2 T_map_body = task.T_map_odom * task.T_odom_body;
  const auto same = std::find_if(attempts_.begin(), attempts_.end(), [&](const Attempts& tried) {
    return (tried.place.p_map() - T_map_body.position()).norm() <= options_.same_place_m &&
           (tried.goal.p_map() - goal_->pose_map.position()).norm() <= options_.same_goal_m;
  });
  if (same != attempts_.end()) {
    return *same;
  }
  attempts_.push_back({AnchoredPose(T_map_body, task.T_map_keyframes),
                       AnchoredPose(goal_->pose_map, task.T_map_keyframes)});
  return attempts_.back();
}

bool Driver::looked_here(const DriveTask& task) const {
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  return looked_ && to_seconds(task.stamp - looked_at_) < options_.looked_s &&
         (looked_->p_map() - here_map).norm() <= options_.same_place_m;
}

void Driver::start_look(const DriveTask& task, const std::string& why, DriveStep& out) {
  mode_ = Mode::kLook;
  mode_since_ = task.stamp;
  why_ = why;
  look_left_rad_ = 2 * std::numbers::pi;
  looked_.emplace(task.T_map_odom * task.T_odom_body, task.T_map_keyframes);
  looked_at_ = task.stamp;
  out.reason = why + ": turning on the spot to look";
}

void Driver::recover(const DriveTask& task, const std::string& why, DriveStep& out) {
  turning_ = false;
  count_as_getting_on(task);
  out.state = PilotState::kRecovering;
  out.command_body = brake();
  Attempts& tried = attempts_here(task);
  if (tried.last == Attempt::kNone) {
    tried.last = Attempt::kLooked;
    if (!looked_here(task)) {
      start_look(task, why, out);
      return;
    }
  }
  if (tried.last == Attempt::kLooked) {
    tried.last = Attempt::kRetreated;
    if (track_odom_.size() > 1) {
      start_retreat(task, why);
      out.reason = why + ": retreating along the own track";
      return;
    }
  }
  if (tried.last == Attempt::kRetreated) {
    tried.last = Attempt::kWentAnotherWay;
    if (block_path_ahead(task)) {
      plan(task);
      out.replanned = true;
      if (path_) {
        out.reason = why + ": taking another way";
        return;
      }
    }
  }
  give_up(why, out);
}

void Driver::give_up(const std::string& why, DriveStep& out) {
  std::erase_if(attempts_, [&](const Attempts& tried) {
    return (tried.goal.p_map() - goal_->pose_map.position()).norm() <= options_.same_goal_m;
  });
  out.goal_given_up = true;
  out.reason = why + ": goal given up";
  goal_.reset();
  path_.reset();
}

void Driver::block(const DriveTask& task, const Vec2& p_map) {
  blocked_.add(
      task.stamp, {p_map.x(), p_map.y(), 0}, [&](const Vec2& p) { return known(task, p); },
      task.T_map_keyframes);
  grid_at_.reset();
}

// Closes the place to all plans where what is near blocks the path that the map alone knows.
bool Driver::block_way_by_map(const DriveTask& task, const Path& by_map) {
  const DrivableGrid& grid = drivable(task);
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  const double away_m = body_.radius_m + options_.search.margin_m + options_.touched_m;
  const auto blocked = std::find_if(by_map.points.begin(), by_map.points.end(), [&](const Vec2& p) {
    return (p - here_map).norm() > away_m &&
           !grid.drivable(grid.clearance.column(p), grid.clearance.row(p));
  });
  if (blocked == by_map.points.end()) {
    return false;
  }
  block(task, *blocked);
  return true;
}

// Closes the path to all plans where it leads away from here. False where it ends before.
bool Driver::block_path_ahead(const DriveTask& task) {
  if (!path_) {
    return false;
  }
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  const double away_m = body_.radius_m + options_.search.margin_m + 2 * options_.touched_m;
  const auto ahead = std::find_if(
      path_->points.begin() + static_cast<std::ptrdiff_t>(std::min(along_, path_->points.size())),
      path_->points.end(), [&](const Vec2& p) { return (p - here_map).norm() >= away_m; });
  if (ahead == path_->points.end()) {
    return false;
  }
  block(task, *ahead);
  return true;
}

void Driver::count_as_getting_on(const DriveTask& task) {
  got_on_ = task.stamp;
  got_on_odom_ = task.T_odom_body.position();
  turned_rad_ = 0;
}

bool Driver::getting_on(const DriveTask& task) {
  if (last_odom_ && std::abs(task.twist_body.v_mps) <= options_.standing_mps) {
    turned_rad_ += std::abs(wrap_angle(task.T_odom_body.theta_rad - last_odom_->theta_rad));
  }
  // looking about is getting on too, but not for ever; at 1 rad/s
  const double turning_s = std::min(turned_rad_, options_.look_about_rad);
  return to_seconds(task.stamp - got_on_) - turning_s < options_.stuck_s;
}

void Driver::touch(const DriveTask& task) {
  const double side = ahead_.twist_body.v_mps < 0 ? -1.0 : 1.0;
  const Vec2 p_body(side * (body_.radius_m + options_.touched_m), 0);
  const Vec2 p_map = task.T_map_odom * task.T_odom_body * p_body;
  const auto again = std::find_if(touched_.begin(), touched_.end(), [&](const Touched& t) {
    return (t.place.p_map() - p_map).norm() <= body_.radius_m;
  });
  const double for_s = again == touched_.end() ? options_.touched_s : 2 * again->for_s;
  if (again != touched_.end()) {
    touched_.erase(again);
  }
  touched_.push_back({AnchoredPose({p_map.x(), p_map.y(), 0}, task.T_map_keyframes),
                      task.stamp + from_seconds(for_s), for_s});
  grid_at_.reset();
}

std::vector<Vec2> Driver::blocked_map(Time now) const {
  std::vector<Vec2> places_map = touched_map(now);
  const std::vector<Vec2> blocked = blocked_.places_map();
  places_map.insert(places_map.end(), blocked.begin(), blocked.end());
  return places_map;
}

std::vector<Vec2> Driver::touched_map(Time now) const {
  std::vector<Vec2> places_map;
  for (const Touched& touched : touched_) {
    if (now < touched.until || !past_touched_) {
      places_map.push_back(touched.place.p_map());
    }
  }
  return places_map;
}

void Driver::drive(const DriveTask& task, std::optional<Time> blocked_since, DriveStep& out) {
  const Pose2 T_map_body = task.T_map_odom * task.T_odom_body;
  const bool due = !planned_ || !path_ || task.relaxed ||
                   to_seconds(task.stamp - *planned_) >= options_.replan_s;
  if (due &&
      (path_ || !planned_ || to_seconds(task.stamp - *planned_) >= options_.replan_failed_s)) {
    plan(task);
    out.replanned = true;
  }
  if (!path_) {
    without_path(task, out);
    return;
  }

  const Vec2 from_map = (task.T_map_odom * ahead_.T_odom_body).position();
  const Lookahead lookahead =
      lookahead_point(*grid_, *path_, from_map, options_.lookahead_m, along_);
  const Vec2 lookahead_odom = task.T_map_odom.inverse() * lookahead.point;
  out.lookahead_odom = lookahead_odom;
  const double end_m = (path_->points.back() - T_map_body.position()).norm();
  if (end_m <= reached_m()) {
    const double turn =
        goal_->heading_matters ? wrap_angle(goal_->pose_map.theta_rad - T_map_body.theta_rad) : 0.0;
    if (std::abs(turn) <= options_.reached_rad) {
      out.goal_reached = true;
      out.reason = "goal reached";
      out.state = PilotState::kDriving;
      out.command_body = brake();
      goal_.reset();
      path_.reset();
      count_as_getting_on(task);
      return;
    }
    out.state = PilotState::kDriving;
    if (std::abs(task.twist_body.v_mps) > options_.standing_mps) {
      out.command_body = brake();
      out.reason = "stopping at the goal";
    } else {
      out.command_body = turn_by(turn, body_.max_turn_radps);
      out.reason = "turning to the goal's heading";
    }
    return;
  }

  const Vec2 lookahead_body = ahead_.T_odom_body.inverse() * lookahead_odom;
  const double aside = std::atan2(lookahead_body.y(), lookahead_body.x());
  turning_ = std::abs(aside) > (turning_ ? options_.turned_rad : options_.turn_first_rad);
  if (turning_) {
    out.state = PilotState::kDriving;
    if (std::abs(task.twist_body.v_mps) > options_.standing_mps) {
      out.command_body = brake();
      out.reason = "stopping to turn to the path";
    } else {
      out.command_body = turn_by(aside, body_.max_turn_radps);
      out.reason = "turning to the path";
    }
    return;
  }

  DwaRequest request;
  request.T_odom_body = ahead_.T_odom_body;
  request.twist_body = ahead_.twist_body;
  request.cycle_s = reaction_.cycle_s();
  request.longest_cycle_s = reaction_.longest_cycle_s();
  request.lookahead_odom = lookahead_odom;
  request.keep_window = task.keep_window;
  const double left = std::max(0.0, lookahead.to_go_m - 0.5 * reached_m());
  const double limit_mps = speed_limit_mps();
  request.speed_limit_mps =
      std::min(limit_mps, std::max(options_.standing_mps, std::sqrt(body_.max_accel_mps2 * left)));
  constexpr double kCap_m = 1.0;
  std::vector<Vec2> touched_odom = touched_map(task.stamp);
  const Pose2 T_odom_map = task.T_map_odom.inverse();
  for (Vec2& p : touched_odom) {
    p = T_odom_map * p;
  }
  const ClearanceMap window = clearance_map(window_map(options_.dwa.cell_m, options_.dwa.window_m,
                                                       task, touched_odom, options_.touched_m),
                                            kCap_m);
  DwaResult result = choose_arc(options_.dwa, body_, window, request);
  out.window = std::move(result.window);
  out.state = PilotState::kDriving;
  if (!result.choice) {
    out.command_body = brake();
    out.reason = "no arc is clear";
  } else {
    out.command_body = result.choice->command_body;
    const bool slowed = result.choice->slowed || (limit_mps < body_.max_speed_mps &&
                                                  out.command_body.v_mps > limit_mps - 1e-6);
    out.reason = slowed ? "following the path, as fast as it can stop in the floor it knows"
                        : "following the path";
  }
  if (!result.choice || out.command_body.v_mps < 1e-3) {
    blocked_since_ = blocked_since.value_or(task.stamp);
    if (to_seconds(task.stamp - *blocked_since_) >= options_.blocked_s) {
      recover(task, "no arc gets on", out);
    }
  }
}

// Where the robot itself stands in no drivable place, backing out may help as well; where the map
// alone knows a way, what is near stands in it: for the moment, or for good. A goal that nothing
// leads to is refused without moving.
void Driver::without_path(const DriveTask& task, DriveStep& out) {
  out.command_body = brake();
  out.state = PilotState::kStopped;
  out.reason = no_path_;
  out.no_path = true;
  if (plans_failed_ < options_.plan_failures) {
    return;
  }
  plans_failed_ = 0;
  const Vec2 here_map = (task.T_map_odom * task.T_odom_body).position();
  const DrivableGrid& grid = drivable(task);
  if (!grid.drivable(grid.clearance.column(here_map), grid.clearance.row(here_map))) {
    recover(task, no_path_, out);
    return;
  }
  out.state = PilotState::kRecovering;
  const std::optional<Path> by_map =
      search_path(search_for_goal(), drivable_by_map(task), here_map, goal_->pose_map.position())
          .path;
  if (by_map && !looked_here(task)) {
    start_look(task, no_path_, out);
  } else if (by_map && block_way_by_map(task, *by_map)) {
    out.way_blocked = true;
    out.reason = no_path_ + ": the way is blocked";
    goal_.reset();
    path_.reset();
  } else {
    give_up(no_path_, out);
  }
}

bool Driver::took_too_long(const DriveTask& task) const {
  return to_seconds(task.stamp - mode_since_) >= options_.recovery_s;
}

void Driver::look(const DriveTask& task, DriveStep& out) {
  out.state = PilotState::kRecovering;
  out.reason = why_ + ": turning on the spot to look";
  if (std::abs(task.twist_body.v_mps) > options_.standing_mps) {
    out.command_body = brake();
    return;
  }
  if (last_odom_) {
    look_left_rad_ -= std::abs(wrap_angle(task.T_odom_body.theta_rad - last_odom_->theta_rad));
  }
  constexpr double kEnd_rad = 0.05;  // a turn stops a little before its end
  if (look_left_rad_ <= kEnd_rad || took_too_long(task)) {
    mode_ = Mode::kDrive;
    path_.reset();
    planned_.reset();
    count_as_getting_on(task);
  }
  out.command_body = turn_by(std::max(look_left_rad_, 0.0), options_.look_radps);
}

// Whether the local map shows that somebody has come to where the robot has been.
bool Driver::something_behind(const DriveTask& task) const {
  constexpr double kAhead_m = 0.15;
  constexpr double kMargin_m = 0.03;
  const OccupancyMap& map = *task.local_odom;
  const Vec2 here = task.T_odom_body.position();
  const Vec2 way = track_odom_.back().position() - here;
  const Vec2 there = here + std::min(1.0, kAhead_m / std::max(way.norm(), 1e-6)) * way;
  const double reach_m = body_.radius_m + kMargin_m;
  const int reach = static_cast<int>(std::ceil(reach_m / map.cell_m));
  const int column = map.column(there);
  const int row = map.row(there);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      if (map.at(column + dx, row + dy) != Cell::kOccupied) {
        continue;
      }
      const Vec2 p = map.centre(column + dx, row + dy);
      if ((p - there).norm() < reach_m && (p - there).norm() < (p - here).norm()) {
        return true;
      }
    }
  }
  return false;
}

void Driver::retreat(const DriveTask& task, DriveStep& out) {
  out.state = PilotState::kRecovering;
  out.reason = why_ + ": retreating along the own track";
  if (task.twist_body.v_mps > options_.standing_mps) {
    out.command_body = brake();
    return;
  }
  const Vec2 here = task.T_odom_body.position();
  if (last_odom_) {
    retreat_left_m_ -= (here - last_odom_->position()).norm();
  }
  constexpr double kBehind_m = 0.10;
  while (!track_odom_.empty() && (track_odom_.back().position() - here).norm() < kBehind_m) {
    track_odom_.pop_back();
  }
  if (retreat_left_m_ <= 0 || track_odom_.empty() || took_too_long(task)) {
    mode_ = Mode::kDrive;
    path_.reset();
    planned_.reset();
    count_as_getting_on(task);
    out.command_body = brake();
    return;
  }
  if (something_behind(task)) {
    mode_ = Mode::kDrive;
    track_odom_.clear();
    path_.reset();
    planned_.reset();
    count_as_getting_on(task);
    out.command_body = brake();
    return;
  }
  const Vec2 target = task.T_odom_body.inverse() * track_odom_.back().position();
  const double back_rad = std::atan2(-target.y(), -target.x());
  if (std::abs(back_rad) > options_.retreat_turn_rad) {
    out.command_body = std::abs(task.twist_body.v_mps) > options_.standing_mps
                           ? brake()
                           : turn_by(back_rad, body_.max_turn_radps);
    return;
  }
  // The circle through the target, backwards (pure pursuit).
  const double curvature = 2 * target.y() / target.squaredNorm();
  const double v = std::max(-options_.retreat_mps,
                            ahead_.twist_body.v_mps - body_.max_accel_mps2 * reaction_.cycle_s());
  out.command_body = {v, v * curvature};
}

// What is remembered goes where relaxation takes the keyframes that hold it.
void Driver::follow(const DriveTask& task) {
  for (Touched& touched : touched_) {
    touched.place.follow(task.T_map_keyframes);
  }
  for (Attempts& tried : attempts_) {
    tried.place.follow(task.T_map_keyframes);
    tried.goal.follow(task.T_map_keyframes);
  }
  if (looked_) {
    looked_->follow(task.T_map_keyframes);
  }
  blocked_.update(
      task.stamp, [&](const Vec2& p_map) { return known(task, p_map); }, task.T_map_keyframes);
}

DriveStep Driver::step(const DriveTask& task) {
  PANOPTES_CHECK(task.local_odom != nullptr && task.map != nullptr, "the driver needs both maps");
  DriveStep out;
  reaction_.decide(task.stamp);
  ahead_ = look_ahead(task);
  remember_track(task);
  const bool hit = task.bumper_pressed && !bumper_was_;
  bumper_was_ = task.bumper_pressed;
  follow(task);
  if (hit) {
    touch(task);
  }
  // a wait goes on only where this step is blocked as well, by the same goal
  std::optional<Time> blocked_since = std::exchange(blocked_since_, std::nullopt);
  if (!task.goal) {
    goal_.reset();
    path_.reset();
    mode_ = Mode::kDrive;
    turning_ = false;
    count_as_getting_on(task);
    out.command_body = brake();
    out.reason = "no goal";
  } else {
    const bool moved = !goal_ || !(goal_->pose_map == task.goal->pose_map);
    if (moved) {
      blocked_since.reset();
      plans_failed_ = 0;
      path_.reset();
      planned_.reset();
      if (!goal_) {
        count_as_getting_on(task);
      }
    }
    goal_ = task.goal;
    if ((task.T_odom_body.position() - got_on_odom_).norm() >= body_.radius_m) {
      count_as_getting_on(task);
    }
    if (hit && mode_ == Mode::kRetreat) {
      mode_ = Mode::kDrive;  // something is behind: no farther back
      track_odom_.clear();
      path_.reset();
    } else if (hit) {
      start_retreat(task, "touched something");
    }
    if (hit) {
      out.state = PilotState::kRecovering;
      out.reason = "touched something: stopping";
    } else if (mode_ == Mode::kLook) {
      look(task, out);
    } else if (mode_ == Mode::kRetreat) {
      retreat(task, out);
    } else if (!getting_on(task)) {
      recover(task, "not getting on", out);
    } else {
      drive(task, blocked_since, out);
    }
  }
  if (path_) {
    out.path_map = path_->points;
  }
  last_odom_ = task.T_odom_body;
  remember_command(task.stamp, out.command_body);
  return out;
}

}  // namespace panoptes

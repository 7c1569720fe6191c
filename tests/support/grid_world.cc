// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/grid_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace panoptes::test {
namespace {

constexpr double kSide_m = 10.0;
constexpr double kCell_m = 0.02;
constexpr double kFrame_s = 1.0 / 15;
constexpr int kSubsteps = 8;
constexpr int kMaxVotes = 12;

void block(OccupancyMap& map, double x0, double y0, double x1, double y1) {
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = map.centre(column, row);
      if (p.x() >= x0 && p.x() < x1 && p.y() >= y0 && p.y() < y1) {
        map(column, row) = Cell::kOccupied;
      }
    }
  }
}

}  // namespace

double GridWorld::gap_m(const Vec2& p, double radius_m) const {
  const int column = truth.column(p);
  const int row = truth.row(p);
  if (!truth.map.contains(column, row)) {
    return -radius_m;
  }
  return truth.to_occupied_m[truth.index(column, row)] - 0.5 * kCell_m - radius_m;
}

GridWorld make_two_rooms(double gap_m, Rng rng) {
  OccupancyMap map;
  map.cell_m = kCell_m;
  map.assign(static_cast<int>(std::lround(7.4 / kCell_m)),
             static_cast<int>(std::lround(4.2 / kCell_m)), Cell::kFree);
  block(map, 0, 0, 7.4, 0.1);
  block(map, 0, 4.1, 7.4, 4.2);
  block(map, 0, 0, 0.1, 4.2);
  block(map, 7.3, 0, 7.4, 4.2);
  const double thick = rng.uniform(0.1, 0.3);
  const double low = rng.uniform(0.6, 4.2 - 0.6 - gap_m);
  // as wide as cells of the truth can make it, and no wider
  const int first = static_cast<int>(std::lround(low / kCell_m));
  const int end = first + static_cast<int>(std::floor(gap_m / kCell_m + 1e-9));
  block(map, 3.7 - 0.5 * thick, 0, 3.7 + 0.5 * thick, first * kCell_m);
  block(map, 3.7 - 0.5 * thick, end * kCell_m, 3.7 + 0.5 * thick, 4.2);
  return {clearance_map(std::move(map), 2)};
}

GridWorld make_office(Rng rng) {
  OccupancyMap map;
  map.cell_m = kCell_m;
  constexpr int kCells = static_cast<int>(kSide_m / kCell_m);
  map.assign(kCells, kCells, Cell::kFree);
  constexpr double kWall_m = 0.1;
  block(map, 0, 0, kSide_m, kWall_m);
  block(map, 0, kSide_m - kWall_m, kSide_m, kSide_m);
  block(map, 0, 0, kWall_m, kSide_m);
  block(map, kSide_m - kWall_m, 0, kSide_m, kSide_m);
  // Cupboards along two walls.
  block(map, kWall_m, kWall_m, rng.uniform(3, 6), 0.55);
  block(map, rng.uniform(4, 7), kSide_m - 0.55, kSide_m - kWall_m, kSide_m - kWall_m);
  // Blocks of desks in two columns, a corridor between them, aisles along both outer walls.
  const double corridor_m = rng.uniform(1.2, 1.6);
  const double middle = rng.uniform(4.6, 5.4);
  for (const int side : {-1, 1}) {
    const double inner = middle + side * 0.5 * corridor_m;
    const double outer = side < 0 ? kWall_m : kSide_m - kWall_m;
    const bool to_wall = rng.uniform() < 0.5;  // or an aisle along the wall
    const double end = to_wall ? outer : outer - side * rng.uniform(0.88, 1.2);
    double y = 0.55 + rng.uniform(0.88, 1.3);
    while (true) {
      const double depth = rng.uniform(1.3, 1.6);
      if (y + depth > kSide_m - 0.55 - 0.88) {
        break;
      }
      block(map, std::min(inner, end), y, std::max(inner, end), y + depth);
      const double aisle = rng.uniform(0.88, 1.6);
      // Chairs pushed in, as far as the gap stays 88 cm.
      const double sticks_out = std::min(0.35, aisle - 0.88);
      if (sticks_out > 0.1) {
        for (int chair = 0; chair < 2; ++chair) {
          const double x = rng.uniform(std::min(inner, end) + 0.3, std::max(inner, end) - 0.8);
          block(map, x, y + depth, x + 0.5, y + depth + sticks_out);
        }
      }
      y += depth + aisle;
    }
  }
  constexpr double kCap_m = 1.0;
  return {clearance_map(std::move(map), kCap_m)};
}

Pose2 draw_start(const GridWorld& world, double radius_m, double gap_m, Rng rng) {
  while (true) {
    const Pose2 T{rng.uniform(0, kSide_m), rng.uniform(0, kSide_m),
                  rng.uniform(-std::numbers::pi, std::numbers::pi)};
    if (world.gap_m(T.position(), radius_m) >= gap_m) {
      return T;
    }
  }
}

GridRobot::GridRobot(const GridWorld& world, const Body& body, const FloorWedge& wedge,
                     const GridRobotNoise& noise, const Pose2& T_world_body, Rng rng)
    : world_(world),
      body_(body),
      wedge_(wedge),
      noise_(noise),
      rng_(rng),
      T_world_body_(T_world_body),
      T_world_map_(T_world_body) {
  // Large enough for the room from any start in any direction.
  constexpr double kHalf_m = 15;
  for (Grid* grid : {&local_odom_, &map_}) {
    grid->map.cell_m = kCell_m;
    grid->map.origin = Vec2::Constant(-kHalf_m);
    const int side = static_cast<int>(2 * kHalf_m / kCell_m);
    grid->map.assign(side, side);
    grid->votes.assign(grid->map.size(), 0);
    grid->keyframe.assign(grid->map.size(), 0);
  }
  assume_free(local_odom_, T_odom_body_);
  assume_free(map_, T_odom_body_);
  // What the disc can reach.
  const OccupancyMap& truth = world.truth.map;
  std::vector<std::uint8_t> seen(truth.cells.size(), 0);
  std::vector<std::pair<int, int>> open{
      {world.truth.column(T_world_body.position()), world.truth.row(T_world_body.position())}};
  while (!open.empty()) {
    const auto [column, row] = open.back();
    open.pop_back();
    if (!truth.contains(column, row)) {
      continue;
    }
    const std::size_t i = world.truth.index(column, row);
    if (seen[i] != 0 || world.truth.to_occupied_m[i] - 0.5 * kCell_m < body.radius_m) {
      continue;
    }
    seen[i] = 1;
    reachable_.emplace_back(column, row);
    open.emplace_back(column + 1, row);
    open.emplace_back(column - 1, row);
    open.emplace_back(column, row + 1);
    open.emplace_back(column, row - 1);
  }
  look();
}

void GridRobot::assume_free(Grid& grid, const Pose2& T) {
  const double radius = wedge_.near_m + 0.1;
  for (double y = -radius; y <= radius; y += 0.5 * kCell_m) {
    for (double x = -radius; x <= radius; x += 0.5 * kCell_m) {
      if (std::hypot(x, y) <= radius) {
        vote(grid, T * Vec2(x, y), 1);
      }
    }
  }
}

void GridRobot::vote(Grid& grid, const Vec2& p, int votes) const {
  const int column = grid.map.column(p);
  const int row = grid.map.row(p);
  if (!grid.map.contains(column, row)) {
    return;
  }
  const std::size_t i = grid.map.index(column, row);
  grid.votes[i] = std::clamp(grid.votes[i] + votes, -kMaxVotes, kMaxVotes);
  grid.keyframe[i] = keyframe_;
  grid.map.cells[i] = grid.votes[i] > 0   ? Cell::kFree
                      : grid.votes[i] < 0 ? Cell::kOccupied
                                          : Cell::kUnknown;
}

void GridRobot::forget() {
  // Only cells within sight can be young: a square around the robot holds all that may go.
  constexpr int kKept = 5;
  const double reach = 2 * wedge_.far_m;
  const auto at = [&](double v) {
    return static_cast<int>(std::floor((v - local_odom_.map.origin.x()) / kCell_m));
  };
  for (int row = std::max(0, at(T_odom_body_.y_m - reach));
       row < std::min(local_odom_.map.rows, at(T_odom_body_.y_m + reach)); ++row) {
    for (int column = std::max(0, at(T_odom_body_.x_m - reach));
         column < std::min(local_odom_.map.columns, at(T_odom_body_.x_m + reach)); ++column) {
      const std::size_t i = local_odom_.map.index(column, row);
      if (local_odom_.keyframe[i] < keyframe_ - kKept) {
        local_odom_.votes[i] = 0;
        local_odom_.map.cells[i] = Cell::kUnknown;
      }
    }
  }
}

void GridRobot::look() {
  constexpr double kRay_rad = 0.012;
  const Pose2 T_map_body = T_map_odom_ * T_odom_body_;
  for (double a = -0.5 * wedge_.width_rad; a <= 0.5 * wedge_.width_rad; a += kRay_rad) {
    const Vec2 ray(std::cos(a), std::sin(a));
    const Vec2 ray_world = T_world_body_.rotation() * ray;
    const Vec2 ray_odom = T_odom_body_.rotation() * ray;
    const Vec2 ray_map = T_map_body.rotation() * ray;
    double foot = wedge_.far_m;
    bool hit = false;
    for (double r = body_.radius_m; r < wedge_.far_m; r += 0.5 * kCell_m) {
      const Vec2 p = T_world_body_.position() + r * ray_world;
      if (world_.truth.map.at(world_.truth.column(p), world_.truth.row(p)) != Cell::kFree) {
        foot = r;
        hit = true;
        break;
      }
    }
    const double believed =
        hit && noise_.range_share > 0 ? foot * (1 + rng_.normal(0, noise_.range_share)) : foot;
    for (double r = wedge_.near_m; r < believed; r += kCell_m) {
      vote(local_odom_, T_odom_body_.position() + r * ray_odom, 1);
      vote(map_, T_map_body.position() + r * ray_map, 1);
    }
    if (hit && believed >= wedge_.near_m) {
      vote(local_odom_, T_odom_body_.position() + believed * ray_odom, -4);
      vote(map_, T_map_body.position() + believed * ray_map, -4);
    }
  }
}

void GridRobot::step(const Twist2& command_body) {
  const double dt = kFrame_s / kSubsteps;
  const Twist2 command = pending_;
  pending_ = command_body;
  const bool was_touching = bumper_;
  bumper_ = false;
  for (int i = 0; i < kSubsteps; ++i) {
    const auto towards = [](double from, double to, double most) {
      return from + std::clamp(to - from, -most, most);
    };
    twist_.v_mps =
        towards(twist_.v_mps, std::clamp(command.v_mps, -body_.max_speed_mps, body_.max_speed_mps),
                body_.max_accel_mps2 * dt);
    twist_.w_radps = towards(
        twist_.w_radps, std::clamp(command.w_radps, -body_.max_turn_radps, body_.max_turn_radps),
        body_.max_turn_accel_radps2 * dt);
    const Pose2 next = T_world_body_ * exp_twist(twist_, dt);
    const double gap = world_.gap_m(next.position(), body_.radius_m);
    if (gap < 0 && gap < world_.gap_m(T_world_body_.position(), body_.radius_m)) {
      bumper_ = true;
      twist_.v_mps = 0;
      continue;
    }
    least_gap_m_ = std::min(least_gap_m_, gap);
    path_m_ += std::abs(twist_.v_mps) * dt;
    Twist2 felt = twist_;
    felt.v_mps *= 1 + noise_.drift;
    felt.w_radps *= 1 + noise_.drift;
    T_world_body_ = next;
    T_odom_body_ = T_odom_body_ * exp_twist(felt, dt);
  }
  contacts_ += bumper_ && !was_touching ? 1 : 0;
  ++frame_;
  now_ = time_at(static_cast<double>(frame_) * kFrame_s);
  // The pose in the map is right but for an error that wanders, and mends itself over 10 s.
  const double pull = std::exp(-kFrame_s / 10);
  const double kick = std::sqrt(1 - pull * pull);
  map_error_.x_m = pull * map_error_.x_m + kick * rng_.normal(0, noise_.map_pose_m);
  map_error_.y_m = pull * map_error_.y_m + kick * rng_.normal(0, noise_.map_pose_m);
  const Pose2 T_map_body = T_world_map_.inverse() * T_world_body_;
  const Pose2 believed{T_map_body.x_m + map_error_.x_m, T_map_body.y_m + map_error_.y_m,
                       T_map_body.theta_rad};
  T_map_odom_ = believed * T_odom_body_.inverse();

  const Pose2 since = keyframe_odom_.inverse() * T_odom_body_;
  if (since.position().norm() > 0.25 || std::abs(since.theta_rad) > deg_to_rad(15)) {
    ++keyframe_;
    keyframe_odom_ = T_odom_body_;
    forget();
  }
  constexpr int kLookEvery = 3;  // a third of the pictures do here, for the tests' time
  if (frame_ % kLookEvery == 0) {
    look();
  }
}

double GridRobot::coverage() const {
  if (reachable_.empty()) {
    return 0;
  }
  const Pose2 T_map_world = T_world_map_.inverse();
  std::size_t mapped = 0;
  for (const auto& [column, row] : reachable_) {
    const Vec2 p = T_map_world * world_.truth.map.centre(column, row);
    mapped += map_.map.at(p) == Cell::kFree ? 1 : 0;
  }
  return static_cast<double>(mapped) / static_cast<double>(reachable_.size());
}

double GridRun::coverage_at(double s) const {
  double share = 0;
  for (const auto& [t, c] : coverage) {
    if (t <= s) {
      share = c;
    }
  }
  return share;
}

std::optional<double> GridRun::when(double share) const {
  for (const auto& [t, c] : coverage) {
    if (c >= share) {
      return t;
    }
  }
  return std::nullopt;
}

GridRun explore_world(const GridWorld& world, const Pose2& start, const ExploreOptions& explore,
                      const DriverOptions& drive, const GridRobotNoise& noise, double duration_s,
                      Rng rng) {
  const Body body;
  const FloorWedge wedge;
  GridRobot robot(world, body, wedge, noise, start, rng.fork("robot"));
  Explorer explorer(explore, body, wedge, rng.fork("explorer"));
  constexpr std::chrono::milliseconds kFrame(67);
  Driver driver(drive, body, {kFrame, kFrame});
  GridRun run;
  std::optional<DriveGoal> goal;
  std::string said;
  Time next_choice;
  Time next_note;
  int fruitless = 0;
  while (to_seconds(robot.now()) < duration_s) {
    DriveTask task;
    task.stamp = robot.now();
    task.local_odom = &robot.local_odom();
    task.map = &robot.map();
    task.T_map_odom = robot.T_map_odom();
    task.T_odom_body = robot.T_odom_body();
    task.twist_body = robot.twist();
    task.bumper_pressed = robot.bumper();
    task.border_m = explorer.border_m();
    if (robot.now() >= next_choice) {
      next_choice = robot.now() + from_seconds(1.5);
      const Pose2 T_map_body = robot.T_map_odom() * robot.T_odom_body();
      ExploreChoice choice = explorer.choose(robot.now(), driver.drivable(task), T_map_body);
      if (!choice.goal) {
        choice = explorer.choose(robot.now(), driver.drivable_by_map(task), T_map_body);
      }
      goal.reset();
      if (choice.goal) {
        goal = DriveGoal{choice.goal->pose_map, choice.goal->heading_matters};
      }
      // Given-up places come back into question, and holes close: done only when it stays so.
      fruitless = choice.frontier_reachable ? 0 : fruitless + 1;
      if (fruitless >= 3) {
        run.done_s = to_seconds(robot.now());
        break;
      }
    }
    task.goal = goal;
    const DriveStep step = driver.step(task);
    if (step.reason != said) {
      said = step.reason;
      std::array<char, 256> line{};
      const Pose2 T = robot.T_world_body();
      std::snprintf(line.data(), line.size(), "%7.2f s at %.2f %.2f %4.0f deg, gap %.3f: %s",
                    to_seconds(robot.now()), T.x_m, T.y_m, rad_to_deg(T.theta_rad),
                    world.gap_m(T.position(), body.radius_m), said.c_str());
      run.said.emplace_back(line.data());
      run.recoveries += step.state == PilotState::kRecovering ? 1 : 0;
    }
    if (step.way_blocked) {
      next_choice = robot.now();
    }
    if (step.goal_reached) {
      explorer.reached();
      next_choice = robot.now();
    }
    if (step.goal_given_up) {
      ++run.given_up;
      explorer.abandon(robot.now(), driver.drivable(task).clearance.map);
      next_choice = robot.now();
    }
    robot.step(step.command_body);
    if (robot.now() >= next_note) {
      run.coverage.emplace_back(to_seconds(robot.now()), robot.coverage());
      next_note = next_note + from_seconds(1);
    }
  }
  run.coverage.emplace_back(to_seconds(robot.now()), robot.coverage());
  run.contacts = robot.contacts();
  run.least_gap_m = robot.least_gap_m();
  run.path_m = robot.path_m();
  return run;
}

}  // namespace panoptes::test

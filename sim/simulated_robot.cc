// SPDX-License-Identifier: BSD-3-Clause
#include "sim/simulated_robot.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/config/geometry_fields.h"
#include "sim/world/layers.h"

namespace panoptes::sim {
namespace {

constexpr double kTruthCell_m = 0.01;
constexpr double kSeenCell_m = 0.05;
// Around a start so much must be clear: more than what the robot has to take for free without
// seeing it, its radius, the blind gap before it (up to 0.25 m) and 10 cm.
constexpr double kStartClear_m = 0.7;
constexpr double kTouching_m = 0.001;  // the bumper's own give
constexpr int kStartDraws = 100'000;   // finds a place that is one part in ten thousand of the room

void refuse_bad_start(const Pose2& start, const std::string& mention, const Obstacles& obstacles,
                      const Body& body) {
  const Vec2 at = start.position();
  const std::string where = fmt::format("{}{}platform.start: x_m: {:.3f}, y_m: {:.3f} ", mention,
                                        mention.empty() ? "" : ": ", at.x(), at.y());
  const char* const what_to_do = "move the start, or leave it out to have one drawn from the seed";
  const Vec2 low = obstacles.low_scene();
  const Vec2 high = obstacles.high_scene();
  if ((at.array() < low.array()).any() || (at.array() > high.array()).any()) {
    throw ConfigError(where + fmt::format("is outside of the world, which reaches from "
                                          "({:.2f}, {:.2f}) to ({:.2f}, {:.2f}); {}",
                                          low.x(), low.y(), high.x(), high.y(), what_to_do));
  }
  const double clear_m = std::max(kStartClear_m, body.radius_m + kTouching_m);
  const std::optional<Nearest> nearest = obstacles.nearest(at, clear_m);
  if (!nearest) {
    return;
  }
  if (nearest->distance_m == 0) {
    throw ConfigError(where +
                      fmt::format("is inside {}; {}", nearest->outline->object, what_to_do));
  }
  throw ConfigError(
      where + fmt::format("is {:.3f} m from {}, but {:.2f} m about the start must be clear, for "
                          "the robot cannot see the floor at its feet and takes it for free; {}",
                          nearest->distance_m, nearest->outline->object, clear_m, what_to_do));
}

Pose2 drawn_start(const Obstacles& obstacles, const Body& body, Rng rng) {
  const FreeRegion region(obstacles, body.radius_m);
  const Vec2 low = obstacles.low_scene();
  const Vec2 high = obstacles.high_scene();
  const double clear_m = std::max(kStartClear_m, body.radius_m + kTouching_m);
  for (int i = 0; i < kStartDraws; ++i) {
    const double x = rng.uniform(low.x(), high.x());
    const double y = rng.uniform(low.y(), high.y());
    const double theta = rng.uniform(-std::numbers::pi, std::numbers::pi);
    if (region.contains({x, y}) && !obstacles.nearest({x, y}, clear_m)) {
      return {x, y, theta};
    }
  }
  throw ConfigError(
      fmt::format("platform.start: no place in the world has {:.2f} m clear all around "
                  "where the robot could start; give a start",
                  clear_m));
}

Pose2 start_pose(const SimulatedOptions& options, const Obstacles& obstacles, const Body& body,
                 const Rng& rng) {
  if (!options.start) {
    return drawn_start(obstacles, body, rng.fork("start"));
  }
  refuse_bad_start(*options.start, options.start_mention, obstacles, body);
  return *options.start;
}

double frame_rate_hz(const Rig& rig) {
  constexpr double kDefault_hz = 15;  // of a robot without cameras
  return rig.cameras.empty() ? kDefault_hz : rig.cameras.begin()->second.rate_hz;
}

std::int64_t steps_per_frame(const Rig& rig) {
  const std::string fault = rate_fault(rig);
  if (!fault.empty()) {
    throw ConfigError("rig." + fault);
  }
  return static_cast<std::int64_t>(DriveWorld::kStepsPerSecond / frame_rate_hz(rig));
}

Rig surveyed(Rig believed, const Rig& true_rig, const Body& body, const Rng& rng) {
  for (auto& [name, camera] : believed.cameras) {
    if (camera.floor && !camera.floor->H_body_px && camera.floor->marks.empty()) {
      camera.floor->marks = survey_floor(name, true_rig.cameras.at(name), body, SurveyError{}, rng);
    }
  }
  return believed;
}

TruthLayer nothing_seen(const TruthLayer& like) {
  TruthLayer seen;
  seen.cell_m = kSeenCell_m;
  seen.origin_scene = like.origin_scene;
  seen.columns = static_cast<int>(std::ceil(like.columns * like.cell_m / kSeenCell_m));
  seen.rows = static_cast<int>(std::ceil(like.rows * like.cell_m / kSeenCell_m));
  seen.cells.resize(static_cast<std::size_t>(seen.columns) * static_cast<std::size_t>(seen.rows));
  return seen;
}

}  // namespace

std::string rate_fault(const Rig& rig) {
  const double rate_hz = frame_rate_hz(rig);
  for (const auto& [name, camera] : rig.cameras) {
    if (camera.rate_hz != rate_hz) {
      return fmt::format(
          "cameras.{}.rate_hz: is {}, but {} has {}; the simulated cameras are synchronous and "
          "must "
          "have one rate",
          name, camera.rate_hz, rig.cameras.begin()->first, rate_hz);
    }
  }
  const double steps = static_cast<double>(DriveWorld::kStepsPerSecond) / rate_hz;
  if (!(steps >= 1) || steps != std::floor(steps)) {
    return fmt::format(
        "cameras.{}.rate_hz: is {}; the simulated cameras' must go into {} Hz without remainder "
        "(10, 12, 15, 20, 24, 30, 60, ...)",
        rig.cameras.begin()->first, rate_hz, DriveWorld::kStepsPerSecond);
  }
  return {};
}

void bind(Fields& f, SimulatedOptions& o) {
  f.require(f.writing() || f.present("world"), "world", "missing; it must name the world's file");
  f.file_or_inline("world", o.world, o.world_file);
  f("start", o.start);
  o.start_mention = f.where("start");
  f("mounting_error", o.mounting_error);
  f("wheel_error", o.wheel_error);
  f("image_noise", o.image_noise);
}

Surroundings surroundings(const World& world, const Body& body, const RendererOptions& options) {
  Surroundings around;
  around.outlines = outlines(world, kFloorLayerTop_m, body.height_m);
  around.floor = occupancy(world, 0, kFloorLayerTop_m, kTruthCell_m);
  around.body = occupancy(world, kFloorLayerTop_m, body.height_m, kTruthCell_m);
  const auto renderer = std::make_shared<Renderer>(world, options);
  around.draw = [renderer](const View& view, const Ask& ask, const Moment& moment) {
    return renderer->draw(view, ask, moment);
  };
  return around;
}

SimulatedRobot::SimulatedRobot(const SimulatedOptions& options, Surroundings surroundings,
                               const Body& body, const Rig& believed, const Rng& rng)
    : surroundings_(std::move(surroundings)),
      body_(body),
      true_rig_(mounted(options.mounting_error, believed, rng.fork("mounting"))),
      obstacles_(std::move(surroundings_.outlines)),
      drive_world_(body, obstacles_, start_pose(options, obstacles_, body, rng)),
      encoders_(options.wheel_error, body, rng.fork("wheels")),
      dead_reckoning_(body),
      pixel_noise_(options.image_noise, rng.fork("pixels")),
      steps_per_frame_(steps_per_frame(believed)),
      seen_(nothing_seen(surroundings_.floor)) {
  rig_ = surveyed(believed, true_rig_, body, rng.fork("survey"));
  for (const auto& [name, camera] : true_rig_.cameras) {
    if (camera.floor) {
      floor_cameras_.emplace(name, SeenFloor(camera, body));
    }
  }
}

void SimulatedRobot::follow(const Route& route) { follower_.emplace(route, body_); }

void SimulatedRobot::drive(const Twist2& command_body, Duration valid_for) {
  if (!follower_) {
    drive_world_.drive(command_body, now_ + valid_for);
  }
}

void SimulatedRobot::stop() {
  follower_.reset();
  drive_world_.drive({}, now_);
}

void SimulatedRobot::step() {
  if (follower_) {
    drive_world_.drive(follower_->command(drive_world_.T_scene_body()), Time::max());
  }
  const Time before = drive_world_.now();
  drive_world_.step();
  const Motion rolled = drive_world_.last_motion();
  encoders_.roll(rolled.forward_m, rolled.turn_rad);
  dead_reckoning_.add(encoders_.ticks(), drive_world_.now() - before);
}

void SimulatedRobot::look(std::int64_t frame, Observation& seen) {
  const Pose2 T_scene_body = drive_world_.T_scene_body();
  for (const auto& [name, camera] : true_rig_.cameras) {
    const auto floor_camera = floor_cameras_.find(name);
    const bool with_label = floor_camera != floor_cameras_.end();
    const View view{camera.intrinsics, on_floor(T_scene_body) * camera.T_body_camera};
    Drawn drawn = surroundings_.draw(view, {.floor_label = with_label}, {});
    if (with_label) {
      floor_camera->second.mark(drawn.floor_label, T_scene_body, seen_);
    }
    pixel_noise_.add(drawn.bgr, name, frame);
    seen.pictures.emplace(name, Picture{seen.stamp, drawn.bgr});
  }
  poses_.push_back(
      {seen.stamp, T_scene_body, drive_world_.twist_body(), drive_world_.clearance_m()});
}

Observation SimulatedRobot::observe(Time deadline) {
  const std::int64_t frame_step = next_frame_ * steps_per_frame_;
  const bool frame_in_time = time_of_step(frame_step) <= std::max(deadline, now_);
  while (drive_world_.steps() < frame_step &&
         time_of_step(drive_world_.steps() + 1) <= std::max(deadline, now_)) {
    step();
  }
  Observation seen;
  seen.stamp = frame_in_time ? time_of_step(frame_step) : std::max(deadline, now_);
  now_ = seen.stamp;
  if (frame_in_time) {
    look(next_frame_, seen);
    ++next_frame_;
  }
  seen.odometry = dead_reckoning_.odometry();
  seen.health.bumper_pressed = drive_world_.touching();
  return seen;
}

std::optional<Truth> SimulatedRobot::truth() const {
  Truth truth;
  truth.poses = poses_;
  truth.contacts = drive_world_.contacts();
  truth.floor = surroundings_.floor;
  truth.body = surroundings_.body;
  truth.seen = seen_;
  truth.path_m = drive_world_.path_m();
  return truth;
}

std::unique_ptr<SimulatedRobot> open_simulated(const SimulatedOptions& options, const Body& body,
                                               const Rig& believed, const Rng& rng) {
  return std::make_unique<SimulatedRobot>(options, surroundings(make_world(options.world), body),
                                          body, believed, rng);
}

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/eval/truth.h"
#include "core/geometry/body.h"
#include "hw/robot.h"
#include "sim/physics/drive_world.h"
#include "sim/physics/obstacles.h"
#include "sim/render/renderer.h"
#include "sim/route.h"
#include "sim/sensors/camera.h"
#include "sim/sensors/encoders.h"
#include "sim/sensors/seen.h"
#include "sim/world/load.h"
#include "sim/world/world.h"

namespace panoptes::sim {

struct SimulatedOptions {
  static constexpr std::string_view kName = "simulated";

  WorldSettings world;
  std::string world_file;      ///< where it came from; empty when written inline
  std::optional<Pose2> start;  ///< in scene; drawn from the seed when absent
  std::string start_mention;   ///< file:line:column of what the user wrote
  MountingError mounting_error;
  WheelError wheel_error;
  ImageNoise image_noise;
};
void bind(Fields& f, SimulatedOptions& o);

/// Why the simulated cameras cannot run at the rates of the rig; empty when they can.
std::string rate_fault(const Rig& rig);

/// What stands around the robot, as its body, its cameras and the truth meet it.
struct Surroundings {
  std::vector<Outline> outlines;  ///< of the body layer
  TruthLayer floor;               ///< see Truth
  TruthLayer body;
  /// Every picture is a new one.
  std::function<Drawn(const View&, const Ask&, const Moment&)> draw;
};

Surroundings surroundings(const World& world, const Body& body,
                          const RendererOptions& options = {});

/// A robot that exists in numbers alone. Its time moves in observe(), by steps of 1/120 s; the
/// frame sets come at the rate of the rig's cameras, the first at time 0. Everything it draws by
/// chance comes from `rng`.
class SimulatedRobot final : public hw::Robot {
 public:
  /// Throws ConfigError for a start inside or touching something, for a world with no room for a
  /// start, and for a rig whose cameras differ in rate.
  SimulatedRobot(const SimulatedOptions& options, Surroundings surroundings, const Body& body,
                 const Rig& believed, const Rng& rng);

  /// The believed rig, with four marks surveyed on the floor for each camera that maps the floor
  /// and has neither marks nor a homography.
  const Rig& rig() const { return rig_; }

  /// From now on the robot follows this route on its true pose, whatever it is told to do.
  void follow(const Route& route);
  bool route_done() const { return follower_ && follower_->done(); }

  Observation observe(Time deadline) override;
  void drive(const Twist2& command_body, Duration valid_for) override;
  void stop() override;
  Time now() const override { return now_; }
  std::optional<Truth> truth() const override;

 private:
  void step();
  void look(std::int64_t frame, Observation& seen);

  Surroundings surroundings_;
  Body body_;
  Rig rig_;
  Rig true_rig_;
  Obstacles obstacles_;
  DriveWorld drive_world_;
  WheelEncoders encoders_;
  DeadReckoning dead_reckoning_;
  PixelNoise pixel_noise_;
  std::map<std::string, SeenFloor> floor_cameras_;
  std::optional<RouteFollower> follower_;
  std::int64_t steps_per_frame_;
  std::int64_t next_frame_ = 0;
  Time now_{};
  std::vector<TruePose> poses_;
  TruthLayer seen_;
};

/// The simulated robot that a mission's `platform:` describes, its world loaded and its renderer
/// made.
std::unique_ptr<SimulatedRobot> open_simulated(const SimulatedOptions& options, const Body& body,
                                               const Rig& believed, const Rng& rng);

}  // namespace panoptes::sim

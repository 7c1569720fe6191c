// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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
#include "sim/physics/dynamic_objects.h"
#include "sim/physics/obstacles.h"
#include "sim/render/renderer.h"
#include "sim/route.h"
#include "sim/sensors/attitude.h"
#include "sim/sensors/camera_sensor.h"
#include "sim/sensors/encoders.h"
#include "sim/sensors/injected_fault.h"
#include "sim/sensors/rig_errors.h"
#include "sim/sensors/seen.h"
#include "sim/sensors/trigger.h"
#include "sim/world/floor_surfaces.h"
#include "sim/world/load.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// What is kept of every picture for those who evaluate.
struct TruthOptions {
  bool depth = false;
  bool labels = false;  ///< instance, floor, and how many pixels show each object
};
void bind(Fields& f, TruthOptions& o);

/// Floor that must be clear where the robot starts, besides what every start has.
struct StartRoom {
  std::vector<Pose2> T_start_body;  ///< it is going to pass there, a few centimetres apart
  double margin_m = 0;              ///< kept from its outline on the way
  std::string needs;                ///< who needs it and how much that is, in words
};

struct SimulatedOptions {
  static constexpr std::string_view kName = "simulated";

  WorldSettings world;
  std::string world_file;      ///< where it came from; empty when written inline
  std::optional<Pose2> start;  ///< in scene; drawn from the seed when absent
  std::string start_mention;   ///< file:line:column of what the user wrote
  StartRoom start_room;        ///< of who drives: no setting of the platform
  /// What the true rig hangs on, whatever the robot believes; the believed rig when absent.
  std::optional<Rig> nominal_rig;
  MountingError mounting_error;
  LensError lens_error;
  ClockError clock_error;
  WheelError wheel_error;
  std::vector<Surface> surfaces;  ///< of the floor, the first that lies under a wheel counts
  AttitudeOptions attitude;
  SensorOptions sensor;                          ///< of every camera
  std::map<std::string, SensorOptions> sensors;  ///< of one camera, what it has besides `sensor`
  TriggerOptions trigger;
  std::vector<InjectedFault> faults;  ///< of cameras, on the way
  TruthOptions truth;
  PainterKind renderer = PainterKind::kSoftware;
};
/// The errors as above, or `errors: none` for as_believed(); what is given besides counts.
void bind(Fields& f, SimulatedOptions& o);

/// The same of a robot that is as it believes to be: no error of mountings, lenses, clocks and the
/// sizes of wheels. Wheels roll unevenly and slip all the same.
SimulatedOptions as_believed(SimulatedOptions options);

/// All that does not go together in the options, the believed rig and the body, by the keys of a
/// mission: settings of cameras that the nominal rig has not, pictures that take longer than the
/// time between two, cameras that could see nothing where they are mounted, cameras that are
/// believed in and not there or of another size.
std::vector<KeyFault> rig_faults(const SimulatedOptions& options, const Rig& believed,
                                 const Body& body);

/// What stands around the robot, as its body, its cameras and the truth meet it.
struct Surroundings {
  std::vector<Outline> outlines;  ///< of the body layer, without dynamic objects
  DynamicObjects dynamic_objects;
  FloorSurfaces floor_surfaces;
  std::vector<std::string> object_names;  ///< in the world's order
  TruthLayer floor;                       ///< see Truth
  TruthLayer body;
  /// Every picture is a new one.
  std::function<RenderedImage(const View&, const RenderOutputs&, const SceneState&)> draw;
};

Surroundings surroundings(const World& world, const Body& body,
                          const RendererOptions& options = {});

/// The same where nothing is drawn and no truth is asked for: enough to say whether a robot can
/// start.
Surroundings bare_surroundings(const World& world, const Body& body);

/// The corners of the world: of the box around what stands in it and its floor.
struct WorldBox {
  Vec2 low_scene = Vec2::Zero();
  Vec2 high_scene = Vec2::Zero();

  /// That a place is outside, in words; empty when it is not.
  std::string outside_fault(const Vec2& at_scene) const;
};
WorldBox world_box(const Obstacles& obstacles, const FloorSurfaces& floor);

/// A robot that exists in numbers alone. Its time moves in observe(), by steps of 1/120 s, between
/// which it drives exact arcs; the frame sets come as its trigger says. Everything that a set holds
/// is of the instants of its pictures, its odometry of the set's stamp; now() is when it is
/// delivered. What a set's exposures last beyond that is driven before it can be answered, less
/// than a step as a rule. Everything it draws by chance comes from `rng`.
class SimulatedRobot final : public hw::Robot {
 public:
  /// Throws ConfigError for a start inside or touching something, for a world with no room for a
  /// start, for options that speak of cameras the rig has not, and for a camera inside the robot.
  SimulatedRobot(const SimulatedOptions& options, Surroundings surroundings, const Body& body,
                 const Rig& believed, const Rng& rng);

  /// The believed rig, with four marks surveyed on the floor for each camera that maps the floor
  /// and has neither marks nor a homography.
  const Rig& rig() const { return rig_; }

  /// The rig that its pictures are taken with, before any knock: the nominal one with its errors.
  const Rig& true_rig() const { return true_rig_; }

  /// From now on the robot follows this route on its true pose, whatever it is told to do.
  void follow(const Route& route);
  bool route_done() const { return follower_ && follower_->done(); }

  Observation observe(Time deadline) override;
  void drive(const Twist2& command_body, Duration valid_for) override;
  void brake_hard() override;
  void stop() override;
  Time now() const override { return now_; }
  Timing timing() const override;
  std::optional<Truth> truth() const override;
  std::optional<Truth> truth_since(std::size_t poses, std::size_t contacts) const override;

  /// What the pictures of the last set truly show, by the cameras' names; empty unless the options
  /// ask for truth.
  const std::map<std::string, TruePicture>& true_pictures() const { return true_pictures_; }

  /// What a camera that takes pictures only when it is asked to (`rate_hz: 0`) sees at the instant
  /// of the last frame set. Asked once a set.
  Picture capture(const std::string& camera);

  /// Of the world's objects, in its order: what TruePicture::instance counts.
  const std::vector<std::string>& object_names() const { return surroundings_.object_names; }

 private:
  /// The end of one step, and how the body came to it.
  struct Record {
    Time end;
    Pose2 T_scene_body;
    Twist2 twist_body;
    Motion motion;  // in this step
    bool touched = false;
    Odometry odometry;
    double lean_rad = 0;
    std::vector<Pose2> places;  // of the dynamic objects
  };
  /// A camera as it truly is.
  struct Camera {
    std::string name;
    RigCamera rig;
    CameraSensor sensor;
    Duration reach{};                // its pictures see so long before and after their stamps
    std::optional<SeenFloor> floor;  // of a floor camera, on a body that stays level
    cv::Mat last_bgr;                // as it was delivered
  };

  void step();
  void record(const Motion& motion);
  Record at(Time t) const;
  Pose3 T_level_body(Time t, const Record& then) const;
  Duration reach(const FrameSet& set) const;
  void capture(const FrameSet& set, Observation& seen);
  Picture take(Camera& camera, const DuePicture& due);
  Time told(const Camera& camera, Time stamp) const;
  std::optional<Picture> deliver(Camera& camera, const DuePicture& due);
  void keep_truth(const Camera& camera, Time stamp, const Pose3& T_scene_camera,
                  const SensorImage& image);
  void forget(Time before);

  Surroundings surroundings_;
  Body body_;
  Rig rig_;
  Rig true_rig_;
  TruthOptions truth_options_;
  Obstacles obstacles_;
  DriveWorld drive_world_;
  WheelEncoders encoders_;
  DeadReckoning dead_reckoning_;
  std::vector<Surface> surfaces_;
  Attitude attitude_;
  Trigger trigger_;
  Duration latency_;
  std::vector<InjectedFault> faults_;
  std::map<std::string, Camera> cameras_;  // by name
  std::optional<RouteFollower> follower_;
  Time now_{};
  std::deque<Record> records_;  // what the next sets may still need
  std::vector<TruePose> poses_;
  TruthLayer seen_;
  std::map<std::string, TruePicture> true_pictures_;
};

/// The simulated robot that a mission's `platform:` describes, its world loaded and its renderer
/// made; what is wrong with it is said before light and shadow are computed.
std::unique_ptr<SimulatedRobot> open_simulated(const SimulatedOptions& options, const Body& body,
                                               const Rig& believed, const Rng& rng,
                                               RendererOptions renderer = {});

/// The same without its cameras: it perceives 15 frame sets without pictures a second, and nothing
/// is drawn or lit.
std::unique_ptr<SimulatedRobot> open_without_cameras(const SimulatedOptions& options,
                                                     const Body& body, const Rng& rng);

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/simulated_robot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/camera/mounting_fault.h"
#include "core/config/geometry_fields.h"
#include "sim/sensors/camera.h"
#include "sim/tour.h"
#include "sim/world/layers.h"
#include "sim/world/truth_layers.h"

namespace panoptes::sim {
namespace {

constexpr double kSeenCell_m = 0.05;
// Around a start so much must be clear: more than what the robot has to take for free without
// seeing it, its radius, the blind zone before it (up to 0.25 m) and 10 cm.
constexpr double kStartClear_m = 0.7;
constexpr double kTouching_m = 0.001;  // the bumper's own give
constexpr int kStartDraws = 100'000;   // finds a place that is one part in ten thousand of the room
// A robot that knows the floor by its colour begins on one floor, or on two where they meet: nobody
// would put it where paving, kerb and road are all at its feet.
constexpr int kStartFloors = 2;
constexpr int kClearStarts = 200;  // of which one will do, but in a world of patchwork floors

/// What is first in the way of a robot that drives from this start as it is told to; empty when
/// nothing is.
std::string in_the_way(const StartRoom& room, const Pose2& start, const Obstacles& obstacles,
                       const FloorSurfaces& floor, const Body& body) {
  const double clear_m = body.radius_m + room.margin_m;
  const WorldBox box = world_box(obstacles, floor);
  for (const Pose2& T_start_body : room.T_start_body) {
    const Vec2 at = (start * T_start_body).position();
    const std::string outside = box.outside_fault(at);
    if (!outside.empty()) {
      return fmt::format("({:.2f}, {:.2f}) {}", at.x(), at.y(), outside);
    }
    if (const std::optional<Nearest> near = obstacles.nearest(at, clear_m)) {
      return fmt::format(
          "{} is at ({:.2f}, {:.2f}), {:.2f} m from the start and {:.2f} m from its "
          "way",
          near->outline->object, near->p_scene.x(), near->p_scene.y(),
          (near->p_scene - start.position()).norm(), near->distance_m);
    }
  }
  return {};
}

void refuse_bad_start(const Pose2& start, const std::string& mention, const Obstacles& obstacles,
                      const FloorSurfaces& floor, const Body& body, bool maps_floor) {
  const Vec2 at = start.position();
  const std::string where = fmt::format("{}{}platform.start: x_m: {:.3f}, y_m: {:.3f} ", mention,
                                        mention.empty() ? "" : ": ", at.x(), at.y());
  const char* const what_to_do = "move the start, or leave it out to have one drawn from the seed";
  if (const std::string fault = world_box(obstacles, floor).outside_fault(at); !fault.empty()) {
    throw ConfigError(where + fault + "; " + what_to_do);
  }
  const double touching_m = body.radius_m + kTouching_m;
  const double clear_m = maps_floor ? std::max(kStartClear_m, touching_m) : touching_m;
  const std::optional<Nearest> nearest = obstacles.nearest(at, clear_m);
  if (!nearest) {
    return;
  }
  if (nearest->distance_m == 0) {
    throw ConfigError(where +
                      fmt::format("is inside {}; {}", nearest->outline->object, what_to_do));
  }
  throw ConfigError(
      where + fmt::format("is {:.3f} m from {}, but {:.2f} m about the start must be clear{}; {}",
                          nearest->distance_m, nearest->outline->object, clear_m,
                          maps_floor ? ", for the robot cannot see the floor at its feet and "
                                       "takes it for free"
                                     : "",
                          what_to_do));
}

/// What a drawn start has around it.
struct StartSearch {
  const Obstacles& obstacles;
  const FloorSurfaces& floor;
  const Body& body;
  const StartRoom& room;
  std::string first_in_the_way = {};  ///< of the way from the first place that would do without it
};

/// A place in a box with room all around; empty where none is found.
std::optional<Pose2> drawn_within(const WorldBox& box, StartSearch& search, Rng& rng) {
  const Obstacles& obstacles = search.obstacles;
  const FreeRegion region(obstacles, search.body.radius_m, box.low_scene, box.high_scene);
  const double clear_m = std::max(kStartClear_m, search.body.radius_m + kTouching_m);
  std::optional<Pose2> first_clear;
  int clear = 0;
  for (int i = 0; i < kStartDraws && clear < kClearStarts; ++i) {
    const double x = rng.uniform(box.low_scene.x(), box.high_scene.x());
    const double y = rng.uniform(box.low_scene.y(), box.high_scene.y());
    const double theta = rng.uniform(-std::numbers::pi, std::numbers::pi);
    if (!region.contains({x, y}) || obstacles.nearest({x, y}, clear_m)) {
      continue;
    }
    const Pose2 start{x, y, theta};
    std::string thing = in_the_way(search.room, start, obstacles, search.floor, search.body);
    if (!thing.empty()) {
      if (search.first_in_the_way.empty()) {
        search.first_in_the_way =
            fmt::format("from ({:.2f}, {:.2f}) at {:.0f} degrees ", x, y, rad_to_deg(theta)) +
            thing;
      }
      continue;
    }
    if (search.floor.looks_within(clear_m, start.position()) <= kStartFloors) {
      return start;
    }
    first_clear = first_clear.value_or(start);
    ++clear;
  }
  return first_clear;
}

/// Among what stands, and where that leaves no room anywhere on the floor: floor that goes on
/// outside of a room's walls is no place to begin.
Pose2 drawn_start(StartSearch search, Rng rng) {
  std::optional<Pose2> start;
  if (!search.obstacles.outlines().empty()) {
    start =
        drawn_within({search.obstacles.low_scene(), search.obstacles.high_scene()}, search, rng);
  }
  if (!start) {
    start = drawn_within(world_box(search.obstacles, search.floor), search, rng);
  }
  if (!start && !search.first_in_the_way.empty()) {
    throw ConfigError(fmt::format(
        "platform.start: no place in the world has room for {}: {}; shorten its ways, or take a "
        "larger world or another seed",
        search.room.needs, search.first_in_the_way));
  }
  if (!start) {
    throw ConfigError(
        fmt::format("platform.start: no place in the world has {:.2f} m clear all around "
                    "where the robot could start; give a start",
                    std::max(kStartClear_m, search.body.radius_m + kTouching_m)));
  }
  return *start;
}

// A start that is good enough for a robot that does not move.
void refuse_cramped_start(const SimulatedOptions& options, const Obstacles& obstacles,
                          const FloorSurfaces& floor, const Body& body) {
  const std::string thing = in_the_way(options.start_room, *options.start, obstacles, floor, body);
  if (!thing.empty()) {
    throw ConfigError(
        fmt::format("{}{}platform.start: x_m: {:.3f}, y_m: {:.3f} has no room for {}: {}; move the "
                    "start, or leave it out to have one drawn from the seed",
                    options.start_mention, options.start_mention.empty() ? "" : ": ",
                    options.start->x_m, options.start->y_m, options.start_room.needs, thing));
  }
}

Pose2 start_pose(const SimulatedOptions& options, std::vector<Outline> all,
                 const Surroundings& around, const Body& body, const Rig& rig, const Rng& rng) {
  for (Outline& outline : around.dynamic_objects.outlines_now()) {
    all.push_back(std::move(outline));
  }
  const Obstacles at_start(std::move(all));
  const FloorSurfaces& floor = around.floor_surfaces;
  if (!options.start) {
    return drawn_start({at_start, floor, body, options.start_room}, rng.fork("start"));
  }
  refuse_bad_start(*options.start, options.start_mention, at_start, floor, body,
                   !rig.with_role("floor").empty());
  refuse_cramped_start(options, at_start, floor, body);
  return *options.start;
}

TriggerOptions fitting_trigger(const SimulatedOptions& options, const Rig& rig, const Body& body) {
  std::vector<std::string> lines;
  for (const KeyFault& fault : rig_faults(options, rig, body)) {
    lines.push_back(fault.key + ": " + fault.what);
  }
  if (!lines.empty()) {
    throw ConfigError(lines);
  }
  return options.trigger;
}

double longest_exposure_ms(const SensorOptions& options) {
  const auto* automatic = std::get_if<AutoExposure>(&options.exposure);
  return automatic != nullptr ? automatic->most_ms
                              : std::get<FixedExposure>(options.exposure).exposure_ms;
}

double readout_ms(const SensorOptions& options, const Intrinsics& lens) {
  return 1e-3 * options.row_us * (lens.height_px - 1);
}

/// How long before and after its stamp a picture sees.
Duration reach_of(const SensorOptions& options, const Intrinsics& lens) {
  const double exposed_ms = options.motion_blur ? longest_exposure_ms(options) : 0;
  return from_seconds(1e-3 * (exposed_ms + readout_ms(options, lens)) / 2);
}

Before before_lens(const std::optional<CameraFaultKind>& fault) {
  return fault == CameraFaultKind::kCover   ? Before::kHand
         : fault == CameraFaultKind::kBlack ? Before::kDarkness
                                            : Before::kNothing;
}

World without_dynamic_objects(World world) {
  std::erase_if(world.objects,
                [](const Object& object) { return object.kind != Object::Kind::kFixed; });
  return world;
}

// What is mapped of a picture the robot is told, as it is told what a camera is for; all else of a
// camera is as it is.
Rig with_mapped_parts(Rig rig, const Rig& believed) {
  for (auto& [name, camera] : rig.cameras) {
    const auto in_belief = believed.cameras.find(name);
    camera.floor.reset();
    if (in_belief != believed.cameras.end()) {
      camera.floor = in_belief->second.floor;
    }
  }
  return rig;
}

RigErrors rig_errors(const SimulatedOptions& options) {
  return {options.mounting_error, options.lens_error, options.clock_error};
}

Rig make_true_rig(const SimulatedOptions& options, const Rig& believed, const Rng& rng) {
  return with_mapped_parts(
      true_rig(rig_errors(options), options.nominal_rig.value_or(believed), rng), believed);
}

// The key of a camera of the nominal rig.
std::string nominal_key(const SimulatedOptions& options, const std::string& camera) {
  return (options.nominal_rig ? "platform.nominal_rig.cameras." : "rig.cameras.") + camera;
}

// What is wrong with how the cameras truly sit, as far as it is not drawn.
void add_mounting_faults(const SimulatedOptions& options, const Rig& nominal, const Body& body,
                         std::vector<KeyFault>& faults) {
  for (const auto& [name, camera] : nominal.cameras) {
    const auto add = [&](const std::string& key, const Pose3& T_body_camera) {
      const std::string fault = mounting_fault(T_body_camera.translation, body);
      if (!fault.empty()) {
        faults.push_back({key, fault});
      }
      return fault.empty();
    };
    if (!add(nominal_key(options, name), camera.T_body_camera)) {
      continue;
    }
    Pose3 T_body_camera = camera.T_body_camera;
    const auto exactly = options.mounting_error.exactly.find(name);
    if (exactly != options.mounting_error.exactly.end()) {
      T_body_camera = displaced(T_body_camera, exactly->second);
      if (!add("platform.mounting_error.exactly." + name, T_body_camera)) {
        continue;
      }
    }
    if (is_knocked(options.faults, name, Time::max())) {
      add("platform.faults", knocked(options.faults, name, Time::max(), T_body_camera));
    }
  }
}

// What the robot believes must be of the cameras that are there, and of pictures of their size.
void add_belief_faults(const SimulatedOptions& options, const Rig& nominal, const Rig& believed,
                       const Body& body, std::vector<KeyFault>& faults) {
  std::vector<std::string> known;
  for (const auto& [name, camera] : nominal.cameras) {
    known.push_back(name);
  }
  for (const auto& [name, camera] : believed.cameras) {
    const auto there = nominal.cameras.find(name);
    if (there == nominal.cameras.end()) {
      const std::string near = nearest_word(name, known);
      faults.push_back({"rig.cameras." + name,
                        "the simulated robot has no camera " + name +
                            (near.empty() ? "; name one of its nominal rig's, or give the platform "
                                            "another nominal_rig"
                                          : "; did you mean " + near + "?")});
      continue;
    }
    const Intrinsics& own = there->second.intrinsics;
    if (camera.intrinsics.width_px != own.width_px ||
        camera.intrinsics.height_px != own.height_px) {
      faults.push_back({"rig.cameras." + name + ".size_px",
                        fmt::format("must be [{}, {}], the size of the pictures that the simulated "
                                    "robot's camera takes (platform.nominal_rig)",
                                    own.width_px, own.height_px)});
    }
    if (camera.rate_hz > 0 && there->second.rate_hz == 0) {
      faults.push_back({"rig.cameras." + name + ".rate_hz",
                        "must be 0: the simulated robot's camera takes pictures only when it is "
                        "asked to (platform.nominal_rig)"});
    }
    const std::string fault = mounting_fault(camera.T_body_camera.translation, body);
    if (options.nominal_rig && !fault.empty()) {
      faults.push_back({"rig.cameras." + name, fault});
    }
  }
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
  seen.origin = like.origin;
  seen.assign(static_cast<int>(std::ceil(like.columns * like.cell_m / kSeenCell_m)),
              static_cast<int>(std::ceil(like.rows * like.cell_m / kSeenCell_m)));
  return seen;
}

}  // namespace

std::string WorldBox::outside_fault(const Vec2& at_scene) const {
  if ((at_scene.array() >= low_scene.array()).all() &&
      (at_scene.array() <= high_scene.array()).all()) {
    return {};
  }
  return fmt::format(
      "is outside of the world, which reaches from ({:.2f}, {:.2f}) to ({:.2f}, {:.2f})",
      low_scene.x(), low_scene.y(), high_scene.x(), high_scene.y());
}

WorldBox world_box(const Obstacles& obstacles, const FloorSurfaces& floor) {
  WorldBox box{floor.low_scene(), floor.high_scene()};
  if (!obstacles.outlines().empty()) {
    box = {box.low_scene.cwiseMin(obstacles.low_scene()),
           box.high_scene.cwiseMax(obstacles.high_scene())};
  }
  return box.low_scene.x() <= box.high_scene.x() ? box : WorldBox{};
}

std::vector<KeyFault> rig_faults(const SimulatedOptions& options, const Rig& believed,
                                 const Body& body) {
  const Rig& rig = options.nominal_rig ? *options.nominal_rig : believed;
  std::vector<std::string> known;
  for (const auto& [name, camera] : rig.cameras) {
    known.push_back(name);
  }
  std::vector<KeyFault> faults;
  for (const auto& [name, sensor] : options.sensors) {
    if (!rig.cameras.contains(name)) {
      const std::string near = nearest_word(name, known);
      faults.push_back(
          {"platform.sensors." + name,
           "the rig has no camera " + name +
               (near.empty() ? "; name one of the rig's" : "; did you mean " + near + "?")});
    }
  }
  for (const KeyFault& fault : rig_error_faults(rig_errors(options), rig)) {
    faults.push_back({"platform." + fault.key, fault.what});
  }
  for (const KeyFault& fault : trigger_faults(options.trigger, rig)) {
    faults.push_back({"platform.trigger." + fault.key, fault.what});
  }
  for (const KeyFault& fault : injection_faults(options.faults, rig)) {
    faults.push_back({"platform." + fault.key, fault.what});
  }
  for (const auto& [name, camera] : rig.cameras) {
    const auto own = options.sensors.find(name);
    const SensorOptions& sensor = own == options.sensors.end() ? options.sensor : own->second;
    const double period_ms = 1e3 / camera.rate_hz;
    const double exposure_ms = longest_exposure_ms(sensor);
    const double rows_ms = readout_ms(sensor, camera.intrinsics);
    // While some rows are read out others are exposed already, so each has the period to itself.
    const double longest_ms = std::max(exposure_ms, rows_ms);
    if (longest_ms > period_ms) {
      faults.push_back(
          {own == options.sensors.end() ? "platform.sensor" : "platform.sensors." + name,
           fmt::format(
               "a picture of the camera {} takes up to {:.4g} ms of exposure or {:.4g} ms of "
               "readout ({} rows of {:.4g} us), but the next begins after {:.4g} ms; "
               "shorten exposure_ms (most_ms) or row_us, or lower rate_hz to {:.4g}",
               name, exposure_ms, rows_ms, camera.intrinsics.height_px, sensor.row_us, period_ms,
               std::floor(1e4 / longest_ms) / 10)});
    }
  }
  add_mounting_faults(options, rig, body, faults);
  add_belief_faults(options, rig, believed, body, faults);
  return faults;
}

void bind(Fields& f, TruthOptions& o) {
  f("depth", o.depth);
  f("labels", o.labels);
}

void bind(Fields& f, SimulatedOptions& o) {
  f.require(f.writing() || f.present("world"), "world", "missing; it must name the world's file");
  f.file_or_inline("world", o.world, o.world_file);
  f("start", o.start);
  f.require(!o.start || o.start->position().cwiseAbs().maxCoeff() <= kFarthest_m, "start",
            "must be within 1000 m of the origin, where every world is");
  o.start_mention = f.where("start");
  f.file_or_inline("nominal_rig", o.nominal_rig);
  bool exact = false;
  if (!f.writing()) {  // what it stands for is written
    f.word("errors", exact, {{"calibrated", false}, {"none", true}});
  }
  if (exact) {
    o = as_believed(std::move(o));
  }
  f("mounting_error", o.mounting_error);
  f("lens_error", o.lens_error);
  f("clock_error", o.clock_error);
  f("wheel_error", o.wheel_error);
  f("surfaces", o.surfaces);
  f.choice("attitude", o.attitude);
  f("sensor", o.sensor);
  f.over("sensors", o.sensors, o.sensor);
  f("trigger", o.trigger);
  f("faults", o.faults);
  f("truth", o.truth);
  f.word("renderer", o.renderer,
         {{"software", PainterKind::kSoftware},
          {"osmesa", PainterKind::kOsMesa},
          {"egl", PainterKind::kEgl}});
}

SimulatedOptions as_believed(SimulatedOptions options) {
  options.mounting_error = {.sigma_deg = 0, .sigma_m = 0};
  options.lens_error = {.sigma_focal_percent = 0, .sigma_centre_px = 0, .sigma_distortion = 0};
  options.clock_error = {.sigma_s = 0};
  WheelError& wheels = options.wheel_error;
  wheels.diameter_difference = wheels.base_error = 0;
  wheels.sigma_radius_percent = wheels.sigma_radius_ratio_percent = wheels.sigma_base_percent = 0;
  wheels.exactly.reset();
  return options;
}

Surroundings bare_surroundings(const World& world, const Body& body) {
  Surroundings around;
  around.outlines = outlines(without_dynamic_objects(world), kFloorLayerTop_m, body.height_m);
  around.dynamic_objects = DynamicObjects(world, kFloorLayerTop_m, body.height_m);
  around.floor_surfaces = FloorSurfaces(world);
  for (const Object& object : world.objects) {
    around.object_names.push_back(object.name);
  }
  around.draw = [](const View&, const RenderOutputs&, const SceneState&) {
    return RenderedImage();
  };
  return around;
}

namespace {

void add_layers(Surroundings& around, const World& world, const Body& body) {
  TruthLayers layers = truth_layers(world, body.height_m);
  around.floor = std::move(layers.floor);
  around.body = std::move(layers.body);
}

void furnish(Surroundings& around, const World& world, const Body& body,
             const RendererOptions& options) {
  add_layers(around, world, body);
  const auto renderer = std::make_shared<Renderer>(world, options);
  around.draw = [renderer](const View& view, const RenderOutputs& outputs,
                           const SceneState& scene_state) {
    return renderer->draw(view, outputs, scene_state);
  };
}

}  // namespace

Surroundings surroundings(const World& world, const Body& body, const RendererOptions& options) {
  Surroundings around = bare_surroundings(world, body);
  furnish(around, world, body, options);
  return around;
}

SimulatedRobot::SimulatedRobot(const SimulatedOptions& options, Surroundings surroundings,
                               const Body& body, const Rig& believed, const Rng& rng)
    : surroundings_(std::move(surroundings)),
      body_(body),
      true_rig_(make_true_rig(options, believed, rng)),
      truth_options_(options.truth),
      obstacles_(std::move(surroundings_.outlines)),
      drive_world_(body, obstacles_,
                   start_pose(options, obstacles_.outlines(), surroundings_, body, believed, rng),
                   surroundings_.dynamic_objects),
      encoders_(options.wheel_error, body, rng.fork("wheels")),
      dead_reckoning_(body),
      surfaces_(options.surfaces),
      attitude_(options.attitude, body),
      trigger_(fitting_trigger(options, believed, body),
               options.nominal_rig ? *options.nominal_rig : believed, rng.fork("trigger")),
      latency_(from_seconds(options.trigger.latency_s)),
      faults_(options.faults),
      seen_(nothing_seen(surroundings_.floor)) {
  rig_ = surveyed(believed, true_rig_, body, rng.fork("survey"));
  for (const auto& [name, camera] : true_rig_.cameras) {
    const auto own = options.sensors.find(name);
    const SensorOptions& sensor = own == options.sensors.end() ? options.sensor : own->second;
    Camera made{name,
                camera,
                CameraSensor(name, camera.intrinsics, sensor, rng.fork("pixels")),
                reach_of(sensor, camera.intrinsics),
                std::nullopt,
                {}};
    if (camera.floor && attitude_.level()) {
      made.floor.emplace(camera, body);
    }
    cameras_.emplace(name, std::move(made));
  }
  record({});
}

namespace {

// Why a body could not drive along this route; empty when it can, as far as what does not move
// goes.
std::string route_fault(const Route& route, const Vec2& start_scene, const Body& body,
                        const Obstacles& obstacles, const WorldBox& box) {
  constexpr double kStep_m = 1e-3;  // along what is all but touched
  // Of the body it is what is between the wheels that surely comes by.
  const double core_m = body.wheel_base_m / 2;
  Vec2 from = start_scene;
  for (std::size_t i = 0; i < route.waypoints.size(); ++i) {
    const Vec2 to(route.waypoints[i].x_m, route.waypoints[i].y_m);
    const std::string place =
        fmt::format("drive.route.waypoints[{}]: x_m: {:.3f}, y_m: {:.3f} ", i, to.x(), to.y());
    const std::string outside = box.outside_fault(to);
    if (!outside.empty()) {
      return place + outside + "; move it inside";
    }
    const double distance_m = (to - from).norm();
    for (double gone_m = 0; gone_m <= distance_m;) {
      const Vec2 p_scene = distance_m > 0 ? Vec2(from + (to - from) * (gone_m / distance_m)) : from;
      const std::optional<Nearest> near = obstacles.nearest(p_scene);
      const double gap_m = near ? near->distance_m - core_m : distance_m + kStep_m;
      if (gap_m <= 0) {
        return fmt::format(
            "{}cannot be reached: on the straight way there the robot would run into {} at "
            "({:.2f}, {:.2f}); go round it by other way points",
            place, near->outline->object, near->p_scene.x(), near->p_scene.y());
      }
      gone_m += std::max(gap_m, kStep_m);
    }
    from = to;
  }
  return {};
}

}  // namespace

void SimulatedRobot::follow(const Route& route) {
  Route driven = route;
  if (route.tour) {
    driven.waypoints =
        tour(*route.tour, surroundings_.body, body_, drive_world_.T_scene_body().position());
  }
  const Vec2 start_scene = drive_world_.T_scene_body().position();
  const std::string fault = route_fault(driven, start_scene, body_, obstacles_,
                                        world_box(obstacles_, surroundings_.floor_surfaces));
  if (!fault.empty()) {
    throw ConfigError(fault);
  }
  follower_.emplace(driven, body_);
}

void SimulatedRobot::drive(const Twist2& command_body, Duration valid_for) {
  if (!follower_) {
    // What the last exposures lasted is driven already.
    drive_world_.drive(command_body, std::max(now_, drive_world_.now()) + valid_for);
  }
}

void SimulatedRobot::brake_hard() {
  if (!follower_) {
    drive_world_.brake_hard();
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
  const double before_mps = drive_world_.twist_body().v_mps;
  const std::array<TractionFactors, 2> traction =
      traction_under_wheels(surfaces_, body_, drive_world_.T_scene_body());
  drive_world_.step();
  const Motion rolled = drive_world_.last_motion();
  encoders_.roll(rolled.forward_m, rolled.turn_rad, traction);
  dead_reckoning_.add(encoders_.ticks(), drive_world_.now() - before);
  constexpr double kStep_s = 1.0 / DriveWorld::kStepsPerSecond;
  attitude_.step((drive_world_.twist_body().v_mps - before_mps) / kStep_s, kStep_s);
  record(rolled);
}

void SimulatedRobot::record(const Motion& motion) {
  records_.push_back({drive_world_.now(), drive_world_.T_scene_body(), drive_world_.twist_body(),
                      motion, drive_world_.touching(), dead_reckoning_.odometry(),
                      attitude_.lean_rad(), drive_world_.dynamic_objects().places()});
}

// Of an instant before or after all that is recorded, the first or the last of it.
SimulatedRobot::Record SimulatedRobot::at(Time t) const {
  const auto after = std::lower_bound(records_.begin(), records_.end(), t,
                                      [](const Record& one, Time when) { return one.end < when; });
  if (after == records_.end()) {
    return records_.back();
  }
  if (after->end == t || after == records_.begin()) {
    return *after;
  }
  const Record& before = *(after - 1);
  const double share = to_seconds(t - before.end) / to_seconds(after->end - before.end);
  Record then = *after;
  then.end = t;
  then.T_scene_body = after->touched
                          ? between(before.T_scene_body, after->T_scene_body, share)
                          : before.T_scene_body *
                                exp_twist({after->motion.forward_m, after->motion.turn_rad}, share);
  then.odometry.T_odom_body =
      between(before.odometry.T_odom_body, after->odometry.T_odom_body, share);
  then.lean_rad = before.lean_rad + share * (after->lean_rad - before.lean_rad);
  for (std::size_t i = 0; i < then.places.size(); ++i) {
    then.places[i] = between(before.places[i], after->places[i], share);
  }
  return then;
}

Pose3 SimulatedRobot::T_level_body(Time t, const Record& then) const {
  return attitude_.T_level_body(attitude_.tilt(t, then.lean_rad));
}

void SimulatedRobot::keep_truth(const Camera& camera, Time stamp, const Pose3& T_scene_camera,
                                const SensorImage& image) {
  TruePicture truth{stamp, T_scene_camera, image.depth_m, image.instance, image.floor_label, {}};
  std::vector<int> count(surroundings_.object_names.size() + 1);
  for (int v = 0; v < image.instance.rows; ++v) {
    const auto* row = image.instance.ptr<std::uint16_t>(v);
    for (int u = 0; u < image.instance.cols; ++u) {
      ++count[row[u]];
    }
  }
  for (std::size_t i = 1; i < count.size(); ++i) {
    if (count[i] > 0) {
      truth.object_px[surroundings_.object_names[i - 1]] += count[i];
    }
  }
  true_pictures_[camera.name] = std::move(truth);
}

Picture SimulatedRobot::take(Camera& camera, const DuePicture& due) {
  const Record then = at(due.stamp);
  const Pose3 T_level = T_level_body(due.stamp, then);
  const auto instant_at = [&](Duration dt) {
    const Time t = due.stamp + dt;
    const Record state = at(t);
    const Pose3 T_scene_level = on_floor(state.T_scene_body);
    // Lamps as in the middle: of a light that changes evenly that is the mean.
    const Pose3 T_body_camera = knocked(faults_, camera.name, t, camera.rig.T_body_camera);
    return Instant{attitude_.level() ? T_scene_level * T_body_camera
                                     : T_scene_level * T_level_body(t, state) * T_body_camera,
                   drive_world_.dynamic_objects().scene_state(due.stamp, state.places)};
  };
  const bool maps_floor = camera.rig.floor.has_value();
  const Before before = before_lens(fault_at(faults_, camera.name, due.stamp));
  const SensorImage image = camera.sensor.take(surroundings_.draw, instant_at, due.number,
                                               {.floor_label = maps_floor || truth_options_.labels,
                                                .depth = truth_options_.depth,
                                                .instance = truth_options_.labels},
                                               before);
  if (before != Before::kNothing) {
    // it has seen no floor
  } else if (camera.floor && !is_knocked(faults_, camera.name, due.stamp)) {
    camera.floor->mark(image.floor_label, then.T_scene_body, surroundings_.floor, seen_);
  } else if (maps_floor) {
    RigCamera tilted = camera.rig;
    tilted.T_body_camera =
        T_level * knocked(faults_, camera.name, due.stamp, camera.rig.T_body_camera);
    SeenFloor(tilted, body_).mark(image.floor_label, then.T_scene_body, surroundings_.floor, seen_);
  }
  if (truth_options_.depth || truth_options_.labels) {
    keep_truth(camera, due.stamp, instant_at(Duration{}).T_scene_camera, image);
  }
  return {told(camera, due.stamp), image.bgr};
}

// The stamp that comes with a picture of this instant.
Time SimulatedRobot::told(const Camera& camera, Time stamp) const {
  return stamp + from_seconds(camera.rig.clock_offset_s);
}

// What a camera hands over of a picture that is due; empty when nothing comes.
std::optional<Picture> SimulatedRobot::deliver(Camera& camera, const DuePicture& due) {
  const std::optional<CameraFaultKind> fault = fault_at(faults_, camera.name, due.stamp);
  if (fault == CameraFaultKind::kUnplug) {
    return std::nullopt;
  }
  if (fault == CameraFaultKind::kFreeze && !camera.last_bgr.empty()) {
    return Picture{told(camera, due.stamp), camera.last_bgr};
  }
  Picture picture = take(camera, due);
  camera.last_bgr = picture.bgr;
  return picture;
}

Picture SimulatedRobot::capture(const std::string& camera) {
  PANOPTES_CHECK(!poses_.empty(), "there has been a frame set");
  return take(cameras_.at(camera),
              {poses_.back().stamp, static_cast<std::int64_t>(poses_.size()) - 1});
}

// What a set's exposures last beyond its delivery is driven before it can be answered, and a
// command acts from the next step on.
Timing SimulatedRobot::timing() const {
  Duration latency = latency_;
  for (const auto& [name, camera] : cameras_) {
    latency = std::max(latency, camera.reach);
  }
  return {trigger_.period(), latency + (time_of_step(1) - time_of_step(0))};
}

Duration SimulatedRobot::reach(const FrameSet& set) const {
  Duration longest{};
  for (const auto& [name, camera] : cameras_) {
    if (camera.rig.rate_hz == 0) {  // it may be asked
      longest = std::max(longest, camera.reach);
    }
  }
  for (const auto& [name, due] : set.pictures) {
    longest = std::max(longest, due.stamp + cameras_.at(name).reach - set.stamp);
  }
  return longest;
}

void SimulatedRobot::capture(const FrameSet& set, Observation& seen) {
  true_pictures_.clear();
  for (const auto& [name, due] : set.pictures) {
    if (!rig_.cameras.contains(name)) {
      continue;  // nobody asks
    }
    if (std::optional<Picture> picture = deliver(cameras_.at(name), due)) {
      seen.pictures.emplace(name, std::move(*picture));
    }
  }
  const Record then = at(set.stamp);
  const Tilt tilt = attitude_.tilt(set.stamp, then.lean_rad);
  poses_.push_back({set.stamp, then.T_scene_body, then.twist_body,
                    clearance_m(obstacles_, drive_world_.dynamic_objects(), then.places, body_,
                                then.T_scene_body.position()),
                    tilt.pitch_rad, tilt.roll_rad, tilt.heave_m});
  seen.odometry = then.odometry;
}

void SimulatedRobot::forget(Time before) {
  while (records_.size() > 1 && records_[1].end <= before) {
    records_.pop_front();
  }
}

Observation SimulatedRobot::observe(Time deadline) {
  const Time until = std::max(deadline, now_);
  const FrameSet& set = trigger_.next();
  Observation seen;
  if (const Time due = set.stamp + latency_; due <= until) {
    const Time needed = std::max(due, set.stamp + reach(set));
    while (drive_world_.now() < needed) {
      step();
    }
    now_ = due;
    seen.stamp = set.stamp;
    capture(set, seen);
    Duration longest_reach{};
    for (const auto& [name, camera] : cameras_) {
      longest_reach = std::max(longest_reach, camera.reach);
    }
    forget(set.stamp - longest_reach);
    trigger_.advance();
  } else {
    while (time_of_step(drive_world_.steps() + 1) <= until) {
      step();
    }
    now_ = until;
    seen.stamp = now_;
    seen.odometry = at(now_).odometry;
  }
  seen.health.bumper_pressed = drive_world_.touching();
  seen.health.bumper_bearings_rad = drive_world_.touch_bearings_rad();
  return seen;
}

std::optional<Truth> SimulatedRobot::truth_since(std::size_t poses, std::size_t contacts) const {
  Truth news;
  const std::vector<TrueContact>& all = drive_world_.contacts();
  news.poses.assign(poses_.begin() + static_cast<std::ptrdiff_t>(poses), poses_.end());
  news.contacts.assign(all.begin() + static_cast<std::ptrdiff_t>(contacts), all.end());
  news.seen = seen_;
  news.path_m = drive_world_.path_m();
  return news;
}

std::optional<Truth> SimulatedRobot::truth() const {
  Truth truth;
  truth.poses = poses_;
  truth.contacts = drive_world_.contacts();
  truth.floor = surroundings_.floor;
  truth.body = surroundings_.body;
  truth.seen = seen_;
  truth.path_m = drive_world_.path_m();
  if (!true_rig_.cameras.empty()) {
    truth.rig = true_rig_;
    for (auto& [name, camera] : truth.rig->cameras) {
      camera.T_body_camera = knocked(faults_, name, now_, camera.T_body_camera);
    }
  }
  truth.wheels = encoders_.wheels();
  return truth;
}

std::unique_ptr<SimulatedRobot> open_simulated(const SimulatedOptions& options, const Body& body,
                                               const Rig& believed, const Rng& rng,
                                               RendererOptions renderer) {
  renderer.painter = options.renderer;
  const World world = make_world(options.world);
  Surroundings around = bare_surroundings(world, body);
  // What would be refused is refused now: light and shadow may take minutes.
  SimulatedOptions ready = options;
  ready.trigger = fitting_trigger(options, believed, body);
  ready.start = start_pose(options, around.outlines, around, body, believed, rng);
  surveyed(believed, make_true_rig(options, believed, rng), body, rng.fork("survey"));
  furnish(around, world, body, renderer);
  return std::make_unique<SimulatedRobot>(ready, std::move(around), body, believed, rng);
}

std::unique_ptr<SimulatedRobot> open_without_cameras(const SimulatedOptions& options,
                                                     const Body& body, const Rng& rng) {
  const World world = make_world(options.world);
  Surroundings around = bare_surroundings(world, body);
  add_layers(around, world, body);
  SimulatedOptions without_cameras = options;  // without what speaks of cameras
  without_cameras.nominal_rig.reset();
  without_cameras.mounting_error = {};
  without_cameras.lens_error = {};
  without_cameras.clock_error = {};
  without_cameras.sensors.clear();
  without_cameras.trigger = {};
  without_cameras.faults.clear();
  return std::make_unique<SimulatedRobot>(without_cameras, std::move(around), body, Rig{}, rng);
}

}  // namespace panoptes::sim

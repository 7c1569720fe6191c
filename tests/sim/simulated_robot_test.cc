// SPDX-License-Identifier: BSD-3-Clause
#include "sim/simulated_robot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "tests/sim/physics/rooms.h"
#include "tests/sim/world/boxes.h"

namespace panoptes::sim {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

TruthLayer layer_of(double size_m) {
  TruthLayer layer;
  layer.cell_m = 0.01;
  layer.origin = {-0.2, -0.2};
  layer.columns = layer.rows = static_cast<int>(std::lround((size_m + 0.4) / layer.cell_m));
  layer.cells.resize(static_cast<std::size_t>(layer.columns) *
                     static_cast<std::size_t>(layer.rows));
  return layer;
}

// A room of 6 x 6 m with a desk; the pictures are grey, all floor below the middle.
Surroundings room() {
  Surroundings around;
  around.outlines = walls(6);
  around.outlines.push_back(box("desk", 2, 2, 4, 3));
  around.floor = layer_of(6);
  around.body = layer_of(6);
  around.draw = [](const View& view, const RenderOutputs& outputs, const SceneState&) {
    RenderedImage rendered;
    const int rows = view.intrinsics.height_px;
    const int columns = view.intrinsics.width_px;
    rendered.bgr = cv::Mat(rows, columns, CV_8UC3, cv::Scalar::all(120));
    if (outputs.floor_label) {
      rendered.floor_label = cv::Mat(rows, columns, CV_8UC1, cv::Scalar(0));
      rendered.floor_label.rowRange(rows / 2, rows).setTo(255);
    }
    return rendered;
  };
  return around;
}

Rig two_cameras() {
  Rig rig;
  rig.cameras["front"].roles = {"loop_front"};
  rig.cameras["front"].intrinsics = pinhole(64, 48, deg_to_rad(80));
  rig.cameras["front"].T_body_camera = mounted_camera({0.02, 0, 0.78}, 0, 0);
  rig.cameras["floor"] = rig.cameras["front"];
  rig.cameras["floor"].roles = {"floor"};
  rig.cameras["floor"].T_body_camera = mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28));
  rig.cameras["floor"].floor = FloorView{};
  return rig;
}

// What is wrong with it, and how it exposes, a test says itself.
SimulatedOptions exact_robot() {
  SimulatedOptions options = as_believed({});
  options.sensor.exposure = FixedExposure{};
  return options;
}

SimulatedOptions starting_at(double x_m, double y_m, double theta_rad = 0) {
  SimulatedOptions options = exact_robot();
  options.start = Pose2{x_m, y_m, theta_rad};
  return options;
}

SimulatedRobot robot_with(const SimulatedOptions& options, std::uint64_t seed = 1) {
  return SimulatedRobot(options, room(), Body{}, two_cameras(), Rng(seed));
}

Rig front_camera_alone() {
  Rig rig = two_cameras();
  rig.cameras.erase("floor");
  return rig;
}

Observation next_set(SimulatedRobot& robot) {
  return robot.observe(robot.now() + std::chrono::seconds(1));
}

Observation last_until(double at_s, SimulatedRobot& robot) {
  Observation seen;
  while (robot.now() < time_at(at_s)) {
    seen = robot.observe(time_at(at_s));
  }
  return seen;
}

// Where a picture was drawn from, and when.
struct DrawCall {
  Pose3 T_scene_camera;
  SceneState scene_state;
};

/// The same, all that is drawn in it kept in `draw_calls` in its order.
Surroundings recording(std::vector<DrawCall>& draw_calls, Surroundings around) {
  around.draw = [&draw_calls, inner = around.draw](const View& view, const RenderOutputs& outputs,
                                                   const SceneState& scene_state) {
    draw_calls.push_back({view.T_scene_camera, scene_state});
    return inner(view, outputs, scene_state);
  };
  return around;
}

World with_walker(const std::vector<Vec2>& path_scene) {
  World world;
  world.objects.resize(1);
  world.objects[0].name = "walker";
  world.objects[0].kind = Object::Kind::kPerson;
  Person person;
  person.path_scene = path_scene;
  world.people = {person};
  return world;
}

/// The room with what moves in a world.
Surroundings room_of(const World& world) {
  Surroundings around = room();
  around.dynamic_objects = DynamicObjects(world, 0.02, 0.8);
  return around;
}

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "nothing refused";
}

TEST(SimulatedOptions, AreReadWithAllTheirErrors) {
  const std::string name = PANOPTES_SOURCE_DIR "/scenes/missions/some.yaml";
  const auto read = [&](const std::string& text) {
    return read_settings_text<SimulatedOptions>(text, name);
  };
  const SimulatedOptions options = read(
      "world: ../worlds/office.yaml\n"
      "start: {x_m: 2, y_m: 3, theta_deg: 90}\n"
      "mounting_error: {sigma_deg: 1, sigma_m: 0.005}\n"
      "wheel_error: {noise_m_per_sqrt_m: 0.01, diameter_difference: 0, base_error: 0, turn_slip: "
      "0}\n"
      "surfaces: [{at: {x_m: 1, y_m: 2}, size_m: [2, 1], slip: 0.02}]\n"
      "attitude: balancing\n"
      "sensor: {vignetting: 0.1, noise: none}\n"
      "sensors: {front: {bayer: true}}\n"
      "trigger: {latency_s: 0.03, groups: {usb: {cameras: [front], offset_s: 0.01}}}\n"
      "faults: [{camera: floor, fault: freeze, at_s: 20, for_s: 5}, {fault: black, at_s: 30}]\n"
      "truth: {depth: true}\n");
  ASSERT_THAT(options.faults, SizeIs(2));
  EXPECT_EQ(options.faults[0].camera, "floor");
  EXPECT_EQ(options.faults[0].fault, CameraFaultKind::kFreeze);
  EXPECT_EQ(options.faults[0].for_s, 5);
  EXPECT_EQ(options.faults[1].camera, "");
  EXPECT_EQ(options.faults[1].fault, CameraFaultKind::kBlack);
  EXPECT_FALSE(options.faults[1].for_s);
  EXPECT_FALSE(options.world.objects.empty());
  EXPECT_EQ(options.start->theta_rad, deg_to_rad(90));
  EXPECT_EQ(options.mounting_error.sigma_deg, 1);
  EXPECT_EQ(options.wheel_error.noise_m_per_sqrt_m, 0.01);
  ASSERT_THAT(options.surfaces, SizeIs(1));
  EXPECT_EQ(options.surfaces[0].slip, 0.02);
  EXPECT_TRUE(std::holds_alternative<BalancingAttitude>(options.attitude));
  EXPECT_EQ(options.sensor.vignetting, 0.1);
  EXPECT_FALSE(options.sensor.bayer);
  EXPECT_EQ(options.sensors.at("front").vignetting, 0.1) << "over the common ones";
  EXPECT_TRUE(std::holds_alternative<NoNoise>(options.sensors.at("front").noise));
  EXPECT_TRUE(options.sensors.at("front").bayer);
  EXPECT_EQ(options.trigger.latency_s, 0.03);
  EXPECT_EQ(options.trigger.groups.at("usb").offset_s, 0.01);
  EXPECT_TRUE(options.truth.depth);
  EXPECT_FALSE(options.truth.labels);
  EXPECT_EQ(
      refusal([&] { read("sensors: {front: {vignettin: 1}}\nwheel_error: {turn_slip: -1}\n"); }),
      name + ":1:1: world: missing; it must name the world's file\n" + name +
          ":1:19: sensors.front.vignettin: unknown key; did you mean vignetting?\n" + name +
          ":2:26: wheel_error.turn_slip: must be from 0 to 0.2, got -1");
}

TEST(SimulatedOptions, WithoutErrorsHaveThoseThatAreGivenAndNoOthers) {
  const auto read = [](const std::string& text) {
    return read_settings_text<SimulatedOptions>(
        "world: " PANOPTES_SOURCE_DIR "/scenes/worlds/bare.yaml\n" + text, "m.yaml");
  };
  const std::string as_it_is = write_settings(read(""));
  EXPECT_EQ(write_settings(read("errors: calibrated\n")), as_it_is);
  const SimulatedOptions none = read("errors: none\n");
  EXPECT_NE(write_settings(none), as_it_is);
  EXPECT_EQ(write_settings(none), write_settings(as_believed(read(""))));
  EXPECT_EQ(none.wheel_error.turn_slip, WheelError().turn_slip) << "no error of a belief";
  const SimulatedOptions given = read(
      "errors: none\nmounting_error: {sigma_deg: 1}\nclock_error: {exactly: {front: 0.01}}\n"
      "wheel_error: {base_error: 0.01}\n");
  EXPECT_EQ(given.mounting_error.sigma_deg, 1);
  EXPECT_EQ(given.mounting_error.sigma_m, 0);
  EXPECT_EQ(given.lens_error.sigma_centre_px, 0);
  EXPECT_EQ(given.clock_error.sigma_s, 0);
  EXPECT_EQ(given.clock_error.exactly.at("front"), 0.01);
  EXPECT_EQ(given.wheel_error.base_error, 0.01);
  EXPECT_EQ(given.wheel_error.sigma_radius_percent, 0);
  const std::string written = write_settings(given);
  EXPECT_EQ(write_settings(read_settings_text<SimulatedOptions>(written, "m.yaml")), written);
  EXPECT_EQ(refusal([&] { read("errors: nome\n"); }),
            "m.yaml:2:9: errors: must be one of calibrated, none, got nome; did you mean none?");
}

TEST(SimulatedOptions, FaultsSayWhatAndWhenAndOfACameraThatIsThere) {
  const std::string name = PANOPTES_SOURCE_DIR "/scenes/missions/some.yaml";
  EXPECT_EQ(
      refusal([&] {
        read_settings_text<SimulatedOptions>(
            "world: ../worlds/office.yaml\n"
            "faults: [{camera: floor, fault: melt, at_s: 1},"
            " {camera: floor, at_s: -1}]\n",
            name);
      }),
      name +
          ":2:33: faults[0].fault: must be one of freeze, cover, black, unplug, knock, got melt\n" +
          name +
          ":2:49: faults[1].fault: missing; it must be freeze, cover, black, unplug or knock\n" +
          name + ":2:71: faults[1].at_s: must be >= 0, got -1");
  SimulatedOptions options = starting_at(1, 1);
  options.faults = {{"flor", CameraFaultKind::kFreeze, 1, std::nullopt}};
  EXPECT_EQ(refusal([&] { robot_with(options); }),
            "platform.faults[0].camera: the rig has no camera flor; did you mean floor?");
}

double mean_grey(const Observation& seen, const std::string& camera) {
  const cv::Scalar mean = cv::mean(seen.pictures.at(camera).bgr);
  return (mean[0] + mean[1] + mean[2]) / 3;
}

double sigma_grey(const Observation& seen, const std::string& camera) {
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(seen.pictures.at(camera).bgr, mean, sigma);
  return sigma[0];
}

bool same(const Observation& a, const Observation& b, const std::string& camera) {
  return cv::norm(a.pictures.at(camera).bgr, b.pictures.at(camera).bgr, cv::NORM_INF) == 0;
}

TEST(SimulatedRobot, StatesItsTimingAsItIs) {
  for (const double latency_s : {0.0, 0.02, 0.1}) {
    for (const double exposure_s : {0.001, 0.03}) {
      SCOPED_TRACE(testing::Message() << latency_s << " s, exposed " << exposure_s << " s");
      SimulatedOptions options = starting_at(1, 1);
      options.trigger.latency_s = latency_s;
      options.sensor.exposure = FixedExposure{.exposure_ms = 1e3 * exposure_s};
      SimulatedRobot robot = robot_with(options);
      const Timing timing = robot.timing();
      const Time first = robot.observe(robot.now() + std::chrono::seconds(1)).stamp;
      const Time second = robot.observe(robot.now() + std::chrono::seconds(1)).stamp;
      EXPECT_LE(std::abs(to_seconds(second - first - timing.period)), 2e-9);
      robot.drive({0.5, 0}, std::chrono::seconds(1));
      double way_m = 0;  // gathering speed evenly
      while (way_m == 0 && to_seconds(robot.now()) < 2) {
        robot.observe(robot.now() + std::chrono::seconds(1));
        way_m = robot.truth()->poses.back().T_scene_body.x_m - 1;
      }
      const double acts_s = to_seconds(robot.truth()->poses.back().stamp - second) -
                            std::sqrt(2 * way_m / Body{}.max_accel_mps2);
      EXPECT_LE(acts_s, to_seconds(timing.worst_latency) + 1e-3);
      EXPECT_GE(acts_s, to_seconds(timing.worst_latency) - 3.0 / 120);
    }
  }
}

TEST(SimulatedRobot, CamerasFailAsTheyAreTold) {
  SimulatedOptions options = starting_at(1, 1);
  SimulatedRobot sound = robot_with(options);
  options.faults = {{"floor", CameraFaultKind::kFreeze, 0.2, 0.2},
                    {"floor", CameraFaultKind::kCover, 0.6, 0.2},
                    {"floor", CameraFaultKind::kUnplug, 1.0, 0.2},
                    {"", CameraFaultKind::kBlack, 1.4, 0.2}};
  SimulatedRobot faulty = robot_with(options);
  Observation before;
  for (int i = 0; i < 30; ++i) {
    const Observation whole = next_set(sound);
    const Observation seen = next_set(faulty);
    ASSERT_EQ(seen.stamp, whole.stamp);
    const double at_s = to_seconds(seen.stamp.time_since_epoch());
    const auto within = [&](double from_s) { return at_s >= from_s && at_s < from_s + 0.2; };
    if (within(0.2)) {
      EXPECT_TRUE(same(seen, before, "floor"));
      EXPECT_EQ(seen.pictures.at("floor").stamp, seen.stamp);
    } else if (within(0.6)) {
      EXPECT_LT(mean_grey(seen, "floor"), 60);
      EXPECT_GT(mean_grey(seen, "floor"), 8);
      EXPECT_GT(sigma_grey(seen, "floor"), 0.5);
      EXPECT_FALSE(same(seen, before, "floor"));
    } else if (within(1.0)) {
      EXPECT_FALSE(seen.pictures.contains("floor"));
    } else if (within(1.4)) {
      EXPECT_LT(mean_grey(seen, "floor"), 8);
      EXPECT_LT(mean_grey(seen, "front"), 8);
      EXPECT_GT(sigma_grey(seen, "floor"), 0.5) << "its noise is left";
    } else {
      EXPECT_TRUE(same(seen, whole, "floor")) << at_s;
    }
    if (!within(1.4)) {
      EXPECT_TRUE(same(seen, whole, "front")) << at_s;
    }
    before = seen;
  }
}

TEST(SimulatedRobot, BrakesHardOnTheArcThatItIsOn) {
  for (const bool hard : {false, true}) {
    SimulatedRobot robot = robot_with(starting_at(1, 1));
    while (robot.now() < time_at(1.5)) {
      next_set(robot);
      robot.drive({0.6, 0.4}, std::chrono::seconds(1));
    }
    const Time told = robot.now();
    Observation seen;
    do {
      robot.drive({}, std::chrono::seconds(1));
      if (hard) {
        robot.brake_hard();
      }
      seen = next_set(robot);
      const Twist2 twist = robot.truth()->poses.back().twist_body;
      if (hard && twist.v_mps > 0) {
        constexpr double kRoundoff = 1e-9;
        EXPECT_NEAR(twist.w_radps / twist.v_mps, 0.4 / 0.6, kRoundoff);
      }
    } while (robot.truth()->poses.back().twist_body.v_mps > 0);
    const double took_s = to_seconds(seen.stamp - told);
    EXPECT_LT(took_s, hard ? 0.4 : 1.2);
    EXPECT_GT(took_s, hard ? 0.2 : 0.9);
    robot.drive({0.3, 0}, std::chrono::seconds(1));
    last_until(to_seconds(robot.now().time_since_epoch()) + 1, robot);
    EXPECT_GT(robot.truth()->poses.back().twist_body.v_mps, 0.2) << "it may be driven again";
  }
}

TEST(SimulatedRobot, DeliversFrameSetsOnTheRigsGridFromTimeZero) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  for (std::int64_t k = 0; k < 31; ++k) {
    const Observation seen = next_set(robot);
    const std::int64_t expected_ns = (k * 1'000'000'000 + 7) / 15;
    EXPECT_EQ(seen.stamp.time_since_epoch().count(), expected_ns);
    EXPECT_EQ(robot.now(), seen.stamp);
    ASSERT_THAT(seen.pictures, SizeIs(2));
    EXPECT_EQ(seen.pictures.at("front").stamp, seen.stamp);
    EXPECT_EQ(seen.pictures.at("front").bgr.cols, 64);
  }
  EXPECT_THAT(robot.truth()->poses, SizeIs(31));
}

TEST(SimulatedRobot, ReturnsWithoutPicturesAtADeadlineAndLosesNoFrame) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  robot.observe(time_at(1));
  robot.drive({0.4, 0}, std::chrono::seconds(1));
  const Observation early = robot.observe(time_at(0.05));
  EXPECT_THAT(early.pictures, IsEmpty());
  EXPECT_EQ(early.stamp, time_at(0.05));
  EXPECT_EQ(robot.now(), time_at(0.05));
  const Observation past = robot.observe(time_at(0.01));
  EXPECT_THAT(past.pictures, IsEmpty());
  EXPECT_EQ(past.stamp, time_at(0.05)) << "time does not go back";
  const Observation frame = robot.observe(time_at(1));
  EXPECT_THAT(frame.pictures, SizeIs(2));
  EXPECT_EQ(frame.stamp.time_since_epoch().count(), 66'666'667);
  EXPECT_THAT(robot.truth()->poses, SizeIs(2));
}

TEST(SimulatedRobot, DrivesTheSameWhateverDeadlinesCutItsTime) {
  const auto drive = [](double deadline_s) {
    SimulatedRobot robot = robot_with(starting_at(1, 1));
    robot.observe(Time());
    robot.drive({0.4, 0.2}, std::chrono::seconds(10));
    while (robot.now() < time_at(2)) {
      robot.observe(std::min(time_at(2), robot.now() + from_seconds(deadline_s)));
    }
    return robot.truth()->poses.back().T_scene_body;
  };
  EXPECT_TRUE(drive(1) == drive(0.013));
}

TEST(SimulatedRobot, StopsWhenNotTold) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  robot.observe(Time());
  robot.drive({0.5, 0}, std::chrono::milliseconds(500));
  last_until(3, robot);
  const Truth truth = *robot.truth();
  EXPECT_EQ(truth.poses.back().twist_body.v_mps, 0);
  // 0.5 s up at 0.6 m/s2 and the same down
  const double distance_m = 0.6 * 0.5 * 0.5;
  const double step_m = 0.3 / DriveWorld::kStepsPerSecond;
  EXPECT_NEAR(truth.path_m, distance_m, step_m);
  EXPECT_NEAR(truth.poses.back().T_scene_body.x_m, 1 + distance_m, step_m);
}

TEST(SimulatedRobot, OdometryStartsAtTheOriginOfOdom) {
  SimulatedRobot robot = robot_with(starting_at(1, 1, 2));
  EXPECT_TRUE(robot.observe(Time()).odometry.T_odom_body == Pose2());
}

TEST(SimulatedRobot, NeverWritesDeliveredPixelsAgain) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  const Observation first = robot.observe(time_at(1));
  const cv::Mat copy = first.pictures.at("front").bgr.clone();
  const Observation second = robot.observe(time_at(1));
  EXPECT_EQ(cv::norm(copy, first.pictures.at("front").bgr, cv::NORM_INF), 0);
  EXPECT_NE(first.pictures.at("front").bgr.data, second.pictures.at("front").bgr.data);
}

TEST(SimulatedRobot, TellsContactsClearanceAndBumper) {
  SimulatedRobot robot = robot_with(starting_at(1, 1, std::numbers::pi));
  EXPECT_NEAR(robot.truth()->path_m, 0, 0);
  Observation seen = robot.observe(Time());
  EXPECT_NEAR(robot.truth()->poses.front().clearance_m, 0.75, 1e-9);
  EXPECT_FALSE(seen.health.bumper_pressed);
  robot.drive({0.5, 0}, std::chrono::seconds(10));
  seen = last_until(5, robot);
  EXPECT_TRUE(seen.health.bumper_pressed);
  const Truth truth = *robot.truth();
  ASSERT_THAT(truth.contacts, SizeIs(1));
  EXPECT_EQ(truth.contacts.front().object, "west wall");
  EXPECT_TRUE(truth.contacts.front().while_moving);
}

TEST(SimulatedRobot, MarksWhatTheFloorCameraSaw) {
  SimulatedRobot robot = robot_with(starting_at(1, 1, 0));
  robot.observe(Time());
  const TruthLayer seen = robot.truth()->seen;
  EXPECT_EQ(seen.cell_m, 0.05);
  EXPECT_TRUE(seen.at({1 + 0.25 + 0.6, 1}));
  EXPECT_FALSE(seen.at({1 + 0.25 + 0.1, 1})) << "the blind zone";
  EXPECT_FALSE(seen.at({0.5, 1})) << "behind";
}

TEST(SimulatedRobot, SurveysTheFloorOfTheTrueRig) {
  const SimulatedRobot robot = robot_with(starting_at(1, 1));
  EXPECT_THAT(robot.rig().cameras.at("floor").floor->marks, SizeIs(4));
  EXPECT_FALSE(robot.rig().cameras.at("front").floor.has_value());
  Rig known = two_cameras();
  known.cameras["floor"].floor->H_body_px = Mat3::Identity();
  const SimulatedRobot told(starting_at(1, 1), room(), Body{}, known, Rng(1));
  EXPECT_THAT(told.rig().cameras.at("floor").floor->marks, IsEmpty()) << "nothing to survey";
}

TEST(SimulatedRobot, DrawsAStartWithRoomAroundItFromTheSeed) {
  const Obstacles obstacles(room().outlines);
  std::vector<double> xs;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SimulatedRobot robot = robot_with({}, seed);
    robot.observe(Time());
    const Pose2 start = robot.truth()->poses.front().T_scene_body;
    EXPECT_FALSE(obstacles.nearest(start.position(), 0.7));
    EXPECT_TRUE(start.x_m > 0 && start.x_m < 6 && start.y_m > 0 && start.y_m < 6);
    xs.push_back(start.x_m);
    SimulatedRobot again = robot_with({}, seed);
    again.observe(Time());
    EXPECT_TRUE(again.truth()->poses.front().T_scene_body == start);
  }
  EXPECT_GT(*std::max_element(xs.begin(), xs.end()) - *std::min_element(xs.begin(), xs.end()), 2);
}

/// A floor from one of these to the next, each of its own picture.
FloorSurfaces strips(const std::vector<double>& ends_m) {
  World world;
  world.objects.resize(1);
  for (std::size_t i = 0; i + 1 < ends_m.size(); ++i) {
    const std::vector<Triangle> strip =
        box(Vec3(ends_m[i], 0, -0.1), Vec3(ends_m[i + 1], 6, 0), static_cast<int>(i));
    world.objects[0].triangles.insert(world.objects[0].triangles.end(), strip.begin(), strip.end());
  }
  return FloorSurfaces(world);
}

Pose2 drawn_start(const Surroundings& around, const Rng& rng) {
  SimulatedRobot robot({}, around, Body{}, two_cameras(), rng);
  robot.observe(Time());
  return robot.truth()->poses.front().T_scene_body;
}

TEST(SimulatedRobot, DrawsAStartWhereNoThreeFloorsMeet) {
  Surroundings kerb = room();
  kerb.floor_surfaces = strips({0, 2.9, 3.05, 6});
  Surroundings seam = room();
  seam.floor_surfaces = strips({0, 3, 6});
  Surroundings patchwork = room();
  std::vector<double> ends_m;
  for (int k = 0; k <= 60; ++k) {
    ends_m.push_back(0.1 * k);
  }
  patchwork.floor_surfaces = strips(ends_m);
  constexpr double kSample_m = 0.05;  // as finely as the floor is looked at
  int on_the_seam = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Pose2 anywhere = drawn_start(room(), Rng(seed));
    const double x_m = drawn_start(kerb, Rng(seed)).x_m;
    EXPECT_TRUE(x_m + 0.7 < 3.05 + kSample_m || x_m - 0.7 > 2.9 - kSample_m) << x_m;
    EXPECT_TRUE(drawn_start(seam, Rng(seed)) == anywhere);
    on_the_seam += std::abs(anywhere.x_m - 3) < 0.5 ? 1 : 0;
  }
  EXPECT_GT(on_the_seam, 0);
  EXPECT_TRUE(drawn_start(patchwork, Rng(1)) == drawn_start(room(), Rng(1))) << "better than none";
}

TEST(SimulatedRobot, DrawsAStartOnOneFloorOfTheStreet) {
  const World world = load_world(PANOPTES_SOURCE_DIR "/scenes/worlds/street.yaml");
  Surroundings around = bare_surroundings(world, Body{});
  around.draw = room().draw;
  // A mission's first draws with these lie on kerbs (3 and 6) and on paint in shadow (39).
  for (const std::uint64_t seed : {3, 6, 39}) {
    const Pose2 start = drawn_start(around, Rng(seed).fork("robot"));
    EXPECT_EQ(around.floor_surfaces.looks_within(0.7, start.position()), 2) << seed;
  }
}

TEST(SimulatedRobot, RefusesAStartInsideOrTouchingSomething) {
  EXPECT_EQ(
      refusal([] { robot_with(starting_at(3, 2.5)); }),
      "platform.start: x_m: 3.000, y_m: 2.500 is inside desk; move the start, or leave it out "
      "to have one drawn from the seed");
  EXPECT_EQ(
      refusal([] { robot_with(starting_at(3, 1.85)); }),
      "platform.start: x_m: 3.000, y_m: 1.850 is 0.150 m from desk, but 0.70 m about the start "
      "must be clear, for the robot cannot see the floor at its feet and takes it for free; move "
      "the start, or leave it out to "
      "have one drawn from the seed");
  EXPECT_EQ(
      refusal([] { robot_with(starting_at(9, 1)); }),
      "platform.start: x_m: 9.000, y_m: 1.000 is outside of the world, which reaches from "
      "(-0.10, -0.10) to (6.10, 6.10); move the start, or leave it out to have one drawn from "
      "the seed");
}

/// A leg of 1 m ahead.
StartRoom leg_ahead() {
  StartRoom room;
  for (int i = 0; i <= 20; ++i) {
    room.T_start_body.push_back({0.05 * i, 0, 0});
  }
  room.margin_m = 0.1;
  room.needs = "a leg of 1 m";
  return room;
}

TEST(SimulatedRobot, RefusesAStartWithoutRoomForWhatItIsToDrive) {
  const auto start = [](double theta_deg) {
    SimulatedOptions options = starting_at(1.2, 2.5, deg_to_rad(theta_deg));
    options.start_room = leg_ahead();
    return refusal([&] { robot_with(options); });
  };
  EXPECT_EQ(start(90), "nothing refused");
  EXPECT_EQ(start(0),
            "platform.start: x_m: 1.200, y_m: 2.500 has no room for a leg of 1 m: desk is at "
            "(2.00, 2.50), 0.80 m from the start and 0.30 m from its way; move the start, or leave "
            "it out to have one drawn from the seed");
  EXPECT_THAT(start(180), testing::HasSubstr(" m from its way"));
}

TEST(SimulatedRobot, DrawsAStartWithRoomForWhatItIsToDrive) {
  const Obstacles obstacles(room().outlines);
  SimulatedOptions options = exact_robot();
  options.start_room = leg_ahead();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimulatedRobot robot = robot_with(options, seed);
    next_set(robot);
    const Pose2 drawn = robot.truth()->poses.front().T_scene_body;
    for (const Pose2& pose : options.start_room.T_start_body) {
      EXPECT_FALSE(obstacles.nearest((drawn * pose).position(), Body().radius_m + 0.1)) << seed;
    }
  }
  options.start_room.T_start_body.push_back({7, 0, 0});  // through the wall
  EXPECT_THAT(refusal([&] { robot_with(options); }),
              testing::AllOf(testing::StartsWith("platform.start: no place in the world has room "
                                                 "for a leg of 1 m: from ("),
                             testing::HasSubstr("is outside of the world"),
                             testing::HasSubstr("larger world or another seed")));
}

// Nobody takes the floor at its feet for free: whatever it touches not is far enough.
TEST(SimulatedRobot, StartsNearAThingWhereNoCameraMapsTheFloor) {
  EXPECT_EQ(refusal([] {
              SimulatedRobot(starting_at(3, 1.6), room(), Body{}, Rig{}, Rng(1));
              SimulatedRobot(starting_at(3, 1.6), room(), Body{}, front_camera_alone(), Rng(1));
            }),
            "nothing refused");
  EXPECT_EQ(
      refusal([] { SimulatedRobot(starting_at(3, 1.85), room(), Body{}, Rig{}, Rng(1)); }),
      "platform.start: x_m: 3.000, y_m: 1.850 is 0.150 m from desk, but 0.25 m about the start "
      "must be clear; move the start, or leave it out to have one drawn from the seed");
}

TEST(SimulatedRobot, TheWorldReachesAsFarAsItsFloor) {
  Surroundings plain = room();
  plain.outlines = {box("crate", 0.1, 0.1, 0.5, 0.5)};
  plain.floor_surfaces = strips({0, 6});
  const auto start_at = [&](double x_m, double y_m) {
    return refusal(
        [&] { SimulatedRobot(starting_at(x_m, y_m), plain, Body{}, two_cameras(), Rng(1)); });
  };
  EXPECT_EQ(start_at(5.5, 5.5), "nothing refused");
  EXPECT_EQ(start_at(6.5, 1),
            "platform.start: x_m: 6.500, y_m: 1.000 is outside of the world, which reaches from "
            "(0.00, 0.00) to (6.00, 6.00); move the start, or leave it out to have one drawn from "
            "the seed");
  double farthest_m = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Pose2 start = drawn_start(plain, Rng(seed));
    EXPECT_EQ(start_at(start.x_m, start.y_m), "nothing refused");
    farthest_m = std::max(farthest_m, start.position().norm());
  }
  EXPECT_GT(farthest_m, 3);
}

TEST(SimulatedRobot, TellsABadStartBeforeAnythingIsDrawn) {
  SimulatedOptions options = starting_at(0, 0);
  BoxSettings floor;
  floor.name = "floor";
  floor.size_m = Vec3(4, 4, 0.1);
  floor.z_m = -0.1;
  BoxSettings crate;
  crate.name = "crate";
  options.world.boxes = {floor, crate};
  RendererOptions undrawable;
  undrawable.near_m = 0;
  EXPECT_EQ(refusal([&] { open_simulated(options, Body{}, two_cameras(), Rng(1), undrawable); }),
            "platform.start: x_m: 0.000, y_m: 0.000 is inside crate; move the start, or leave it "
            "out to have one drawn from the seed");
}

TEST(SimulatedRobot, WithoutItsCamerasIsTheSame) {
  SimulatedOptions options;
  BoxSettings floor;
  floor.name = "floor";
  floor.size_m = Vec3(4, 4, 0.1);
  floor.z_m = -0.1;
  options.world.boxes = {floor};
  options.sensors["front"] = {};
  options.trigger.latency_s = 0.02;
  const auto seeing = open_simulated(options, Body{}, two_cameras(), Rng(1));
  const auto without_cameras = open_without_cameras(options, Body{}, Rng(1));
  for (const auto& robot : {seeing.get(), without_cameras.get()}) {
    robot->drive({0.3, 0.2}, std::chrono::seconds(5));
  }
  last_until(1, *seeing);
  last_until(1, *without_cameras);
  EXPECT_TRUE(seeing->observe(seeing->now()).odometry.T_odom_body ==
              without_cameras->observe(without_cameras->now()).odometry.T_odom_body);
  const Truth known = *without_cameras->truth();
  EXPECT_THAT(known.poses, SizeIs(16));  // 15 a second, and the first
  EXPECT_TRUE(known.poses[3].T_scene_body == seeing->truth()->poses[3].T_scene_body);
  EXPECT_TRUE(known.body.cells == seeing->truth()->body.cells);
}

TEST(SimulatedRobot, RefusesAWorldWithoutRoomForAStart) {
  Surroundings cell = room();
  cell.outlines = walls(1.2);
  EXPECT_EQ(
      refusal([&] { SimulatedRobot({}, cell, Body{}, two_cameras(), Rng(1)); }),
      "platform.start: no place in the world has 0.70 m clear all around where the robot could "
      "start; give a start");
}

TEST(SimulatedRobot, RefusesSettingsOfCamerasThatTheRigHasNot) {
  SimulatedOptions options = starting_at(1, 1);
  options.sensors["flor"] = {};
  EXPECT_EQ(refusal([&] { robot_with(options); }),
            "platform.sensors.flor: the rig has no camera flor; did you mean floor?");
  options = starting_at(1, 1);
  options.trigger.groups["usb"].cameras = {"left"};
  EXPECT_EQ(refusal([&] { robot_with(options); }),
            "platform.trigger.groups.usb.cameras: the rig has no camera left; name one of the "
            "rig's");
}

TEST(SimulatedRobot, RefusesPicturesThatTakeLongerThanTheirPeriod) {
  SimulatedOptions options = starting_at(1, 1);
  options.sensors["front"].exposure = FixedExposure{40, 1};
  options.sensors["front"].row_us = 2000;
  EXPECT_EQ(refusal([&] { robot_with(options); }),
            "platform.sensors.front: a picture of the camera front takes up to 40 ms of exposure "
            "or 94 ms of readout (48 rows of 2000 us), but the next begins after 66.67 ms; shorten "
            "exposure_ms (most_ms) or row_us, or lower rate_hz to 10.6");
  options.sensors["front"].row_us = 1400;
  EXPECT_EQ(refusal([&] { robot_with(options); }), "nothing refused");
}

TEST(SimulatedRobot, TellsTheFaultsOfAllCamerasAtOnce) {
  Rig rig = two_cameras();
  rig.cameras["front"].T_body_camera = mounted_camera({0.1, 0.1, 0.2}, 0, 0);
  rig.cameras["floor"].T_body_camera = mounted_camera({0.3, 0, -0.1}, 0, 0);
  SimulatedOptions options = starting_at(1, 1);
  options.sensors["flor"] = {};
  EXPECT_EQ(refusal([&] { SimulatedRobot(options, room(), Body{}, rig, Rng(1)); }),
            "platform.sensors.flor: the rig has no camera flor; did you mean floor?\n"
            "rig.cameras.floor: is mounted 0.100 m below the floor; mount it above\n"
            "rig.cameras.front: is mounted inside the robot, whose hull is 0.240 m high and "
            "reaches 0.250 m from its middle; mount it above or farther out");
}

TEST(SimulatedRobot, RefusesCamerasInsideTheRobotOrUnderTheFloor) {
  const auto mounted_at = [](const Vec3& eye_body) {
    Rig rig = two_cameras();
    rig.cameras["front"].T_body_camera = mounted_camera(eye_body, 0, 0);
    return refusal([&] { SimulatedRobot(starting_at(1, 1), room(), Body{}, rig, Rng(1)); });
  };
  EXPECT_EQ(mounted_at({0.1, 0.1, 0.2}),
            "rig.cameras.front: is mounted inside the robot, whose hull is 0.240 m high and "
            "reaches 0.250 m from its middle; mount it above or farther out");
  EXPECT_EQ(mounted_at({0.3, 0, -0.1}),
            "rig.cameras.front: is mounted 0.100 m below the floor; mount it above");
  EXPECT_EQ(mounted_at({0, 0, 5}),
            "rig.cameras.front: is mounted 5.000 m high, but the robot ends at 0.800 m, and what "
            "hangs higher would pass through the camera; mount it lower, or correct the robot's "
            "height_m");
  EXPECT_EQ(mounted_at({0.26, 0, 0.2}), "nothing refused");
}

TEST(SimulatedRobot, PicturesBetweenItsStepsLieOnTheExactArc) {
  std::vector<DrawCall> draw_calls;
  const Surroundings around = recording(draw_calls, room());
  Body quick;  // reaches any speed at once
  quick.max_accel_mps2 = quick.max_turn_accel_radps2 = 1e6;
  Rig rig = front_camera_alone();
  rig.cameras["front"].rate_hz = 29.97;
  SimulatedOptions options = starting_at(1, 4);
  options.sensor.motion_blur = false;
  SimulatedRobot robot(options, around, quick, rig, Rng(1));
  robot.observe(time_at(1));
  const Twist2 twist{0.4, 0.5};
  std::vector<Time> stamps{Time()};
  while (robot.now() < time_at(3)) {
    robot.drive(twist, std::chrono::seconds(1));
    stamps.push_back(robot.observe(time_at(3)).stamp);
  }
  constexpr double kRoundoff = 1e-9;  // of stamps, cut to nanoseconds
  ASSERT_GE(draw_calls.size(), 80U);
  for (std::size_t k = 2; k + 1 < draw_calls.size(); ++k) {
    const Pose3 T_before_camera =
        draw_calls[k - 1].T_scene_camera.inverse() * draw_calls[k].T_scene_camera;
    const Pose3& T_body_camera = rig.cameras["front"].T_body_camera;
    const Pose3 expected = T_body_camera.inverse() *
                           on_floor(exp_twist(twist, to_seconds(stamps[k] - stamps[k - 1]))) *
                           T_body_camera;
    EXPECT_NEAR((T_before_camera.translation - expected.translation).norm(), 0, kRoundoff);
    EXPECT_NEAR(T_before_camera.rotation.angularDistance(expected.rotation), 0, kRoundoff);
  }
}

TEST(SimulatedRobot, AsksACameraOnlyForThePicturesThatSomebodyWants) {
  std::vector<DrawCall> draw_calls;
  Rig rig = front_camera_alone();
  rig.cameras["corner"] = rig.cameras["front"];
  rig.cameras["corner"].rate_hz = 0;
  rig.cameras["corner"].T_body_camera = mounted_camera({0.17, 0.17, 0.75}, deg_to_rad(45), 0);
  SimulatedOptions options = starting_at(1, 4);
  options.sensor.motion_blur = false;
  SimulatedRobot robot(options, recording(draw_calls, room()), Body{}, rig, Rng(1));
  robot.drive({0.4, 0.5}, std::chrono::seconds(5));
  for (int k = 0; k < 20; ++k) {
    EXPECT_FALSE(next_set(robot).pictures.contains("corner"));
  }
  ASSERT_THAT(draw_calls, SizeIs(20));
  EXPECT_EQ(robot.capture("corner").bgr.cols, 64);
  ASSERT_THAT(draw_calls, SizeIs(21));
  const Pose3 T_body_front = rig.cameras["front"].T_body_camera;
  const Pose3 expected =
      draw_calls[19].T_scene_camera * T_body_front.inverse() * rig.cameras["corner"].T_body_camera;
  constexpr double kRoundoff = 1e-9;
  EXPECT_NEAR((draw_calls[20].T_scene_camera.translation - expected.translation).norm(), 0,
              kRoundoff);
  EXPECT_NEAR(draw_calls[20].T_scene_camera.rotation.angularDistance(expected.rotation), 0,
              kRoundoff);
}

TEST(SimulatedRobot, KeepsCamerasOfDifferentRatesAndSizesInOneRig) {
  Rig rig = two_cameras();
  rig.cameras["front"].rate_hz = 25;
  rig.cameras["floor"].rate_hz = 10;
  rig.cameras["floor"].intrinsics = pinhole(48, 32, deg_to_rad(80));
  SimulatedRobot robot(starting_at(1, 1), room(), Body{}, rig, Rng(1));
  std::vector<std::size_t> with_floor;
  for (std::size_t k = 0; k < 50; ++k) {
    const Observation seen = next_set(robot);
    EXPECT_EQ(seen.stamp, time_at(0.04 * static_cast<double>(k)));
    ASSERT_EQ(seen.pictures.count("front"), 1U);
    if (const auto floor = seen.pictures.find("floor"); floor != seen.pictures.end()) {
      with_floor.push_back(k);
      EXPECT_EQ(floor->second.bgr.cols, 48);
      EXPECT_LE(floor->second.stamp, seen.stamp);
      EXPECT_GT(floor->second.stamp, seen.stamp - from_seconds(0.04));
    }
  }
  EXPECT_THAT(with_floor, SizeIs(20));
}

TEST(SimulatedRobot, DeliversSetsLaterThanTheyAreTaken) {
  SimulatedOptions options = starting_at(1, 1);
  options.trigger.latency_s = 0.1;  // more than a period
  SimulatedRobot late = robot_with(options);
  SimulatedRobot prompt = robot_with(starting_at(1, 1));
  for (int k = 0; k < 30; ++k) {
    const Observation seen = next_set(late);
    const Observation same = next_set(prompt);
    EXPECT_EQ(seen.stamp, same.stamp);
    EXPECT_EQ(late.now(), seen.stamp + std::chrono::milliseconds(100));
    EXPECT_THAT(seen.pictures, SizeIs(2));
    EXPECT_EQ(seen.pictures.at("front").stamp, seen.stamp);
    if (k == 10) {
      late.drive({0.5, 0}, std::chrono::seconds(9));
      prompt.drive({0.5, 0}, std::chrono::seconds(9));
    }
  }
  // The same command came 0.1 s later to the one: its stamps show it less far.
  const double behind_m =
      prompt.truth()->poses.back().T_scene_body.x_m - late.truth()->poses.back().T_scene_body.x_m;
  const double step_m = 0.5 / DriveWorld::kStepsPerSecond;  // either may begin a step later
  EXPECT_NEAR(behind_m, 0.05, 1.01 * step_m);
}

TEST(SimulatedRobot, OdometryIsOfTheStampNotOfTheDelivery) {
  SimulatedOptions options = starting_at(1, 1);
  options.trigger.latency_s = 0.1;
  options.wheel_error = {0, 0, 0, 0, 0};
  SimulatedRobot robot = robot_with(options);
  robot.observe(time_at(1));
  robot.drive({0.5, 0}, std::chrono::seconds(9));
  Observation seen;
  for (int k = 0; k < 30; ++k) {
    seen = next_set(robot);
  }
  const double distance_m = robot.truth()->poses.back().T_scene_body.x_m - 1;
  constexpr double kTick_m = 0.00123;
  EXPECT_NEAR(seen.odometry.T_odom_body.x_m, distance_m, kTick_m);
  EXPECT_GT(distance_m, 0.4);
}

TEST(SimulatedRobot, SaysByNameWhichCamerasAreMissing) {
  SimulatedOptions options = starting_at(1, 1);
  options.trigger.groups["loose"] = {{"floor"}, 0, 0, 0, 0.3};
  SimulatedRobot robot = robot_with(options);
  int with_floor = 0;
  for (int k = 0; k < 60; ++k) {
    const Observation seen = next_set(robot);
    EXPECT_EQ(seen.pictures.count("front"), 1U);
    with_floor += seen.pictures.count("floor") > 0 ? 1 : 0;
  }
  EXPECT_NEAR(with_floor, 42, 3 * std::sqrt(60 * 0.3 * 0.7));
}

TEST(SimulatedRobot, AnotherCameraChangesNothingForTheRest) {
  const auto last = [](const Rig& rig) {
    SimulatedRobot robot(starting_at(1, 1), room(), Body{}, rig, Rng(3));
    robot.follow({{{5, 1}}, 0.5});
    return last_until(2, robot);
  };
  Rig more = two_cameras();
  more.cameras["extra"] = more.cameras["front"];
  const Observation without = last(two_cameras());
  const Observation with = last(more);
  EXPECT_EQ(cv::norm(without.pictures.at("front").bgr, with.pictures.at("front").bgr, cv::NORM_INF),
            0);
  EXPECT_TRUE(without.odometry.T_odom_body == with.odometry.T_odom_body);
  EXPECT_NE(cv::norm(with.pictures.at("extra").bgr, with.pictures.at("front").bgr, cv::NORM_INF), 0)
      << "each has its own noise";
}

TEST(SimulatedRobot, TiltsItsCamerasAndNotItsWay) {
  std::vector<DrawCall> draw_calls;
  const Surroundings around = recording(draw_calls, room());
  WavesAttitude waves;
  waves.pitch = {{0.1, 1, 0}};
  SimulatedOptions options = starting_at(1, 1);
  options.attitude = waves;
  options.sensor.motion_blur = false;
  SimulatedRobot robot(options, around, Body{}, front_camera_alone(), Rng(1));
  for (int k = 0; k < 15; ++k) {
    next_set(robot);
  }
  const Truth truth = *robot.truth();
  for (std::size_t k = 0; k < truth.poses.size(); ++k) {
    const double pitch_rad = 0.1 * std::sin(2 * std::numbers::pi * static_cast<double>(k) / 15);
    EXPECT_NEAR(truth.poses[k].pitch_rad, pitch_rad, 1e-8);  // of stamps, cut to nanoseconds
    EXPECT_TRUE((truth.poses[k].T_scene_body == Pose2{1, 1, 0}));
    const Vec3 axis_scene = draw_calls[k].T_scene_camera.rotation * Vec3::UnitZ();
    EXPECT_NEAR(std::asin(-axis_scene.z()), pitch_rad, 1e-8);
  }
}

TEST(SimulatedRobot, ATiltedFloorCameraMarksTheFloorItSees) {
  SimulatedOptions options = starting_at(1, 1);
  WavesAttitude waves;
  waves.pitch = {{deg_to_rad(-8), 0, std::numbers::pi / 2}};  // nose up, for ever
  options.attitude = waves;
  SimulatedRobot robot = robot_with(options);
  robot.observe(Time());
  EXPECT_FALSE(robot.truth()->seen.at({1 + 0.25 + 0.22, 1})) << "below the picture now";
  EXPECT_TRUE(robot.truth()->seen.at({1 + 0.25 + 0.6, 1}));
  SimulatedRobot level = robot_with(starting_at(1, 1));
  level.observe(Time());
  EXPECT_TRUE(level.truth()->seen.at({1 + 0.25 + 0.22, 1}));
}

TEST(SimulatedRobot, KeepsTheTruthOfEveryPictureWhereItIsAsked) {
  Surroundings around = room();
  around.object_names = {"floor", "desk"};
  around.draw = [inner = around.draw](const View& view, const RenderOutputs& outputs,
                                      const SceneState& scene_state) {
    RenderedImage rendered = inner(view, outputs, scene_state);
    if (outputs.instance) {
      rendered.instance = cv::Mat(rendered.bgr.size(), CV_16UC1, cv::Scalar(1));
      rendered.instance.rowRange(0, 10).setTo(2);
      rendered.instance.row(0).setTo(0);
    }
    if (outputs.depth) {
      rendered.depth_m = cv::Mat(rendered.bgr.size(), CV_32FC1, cv::Scalar(2.5));
    }
    return rendered;
  };
  SimulatedOptions options = starting_at(1, 1);
  SimulatedRobot unasked(options, around, Body{}, two_cameras(), Rng(1));
  const Observation plain = unasked.observe(Time());
  EXPECT_THAT(unasked.true_pictures(), IsEmpty());
  options.truth = {true, true};
  SimulatedRobot robot(options, around, Body{}, two_cameras(), Rng(1));
  const Observation seen = robot.observe(Time());
  ASSERT_THAT(robot.true_pictures(), SizeIs(2));
  const TruePicture& truth = robot.true_pictures().at("front");
  EXPECT_EQ(truth.stamp, seen.pictures.at("front").stamp);
  EXPECT_EQ(truth.depth_m.at<float>(5, 5), 2.5F);
  EXPECT_EQ(truth.floor_label.at<std::uint8_t>(47, 5), 255);
  EXPECT_EQ(truth.object_px.at("desk"), 9 * 64);
  EXPECT_EQ(truth.object_px.at("floor"), 38 * 64);
  EXPECT_NEAR((truth.T_scene_camera.translation - Vec3(1.02, 1, 0.78)).norm(), 0, 1e-12);
  EXPECT_EQ(cv::norm(plain.pictures.at("front").bgr, seen.pictures.at("front").bgr, cv::NORM_INF),
            0);
  robot.observe(Time());
  EXPECT_THAT(robot.true_pictures(), SizeIs(2)) << "of the last set, until the next";
}

TEST(SimulatedRobot, MeetsAndSeesPeopleWhereTheyAre) {
  World world = with_walker({{5, 1}, {1, 1}});
  world.people[0].waits_m = 0;
  world.light_events = {{time_at(1), from_seconds(1), "lamps", 0.5}};
  std::vector<DrawCall> draw_calls;
  const Surroundings around = recording(draw_calls, room_of(world));
  SimulatedOptions options = starting_at(1, 1);
  options.sensor.motion_blur = false;
  SimulatedRobot robot(options, around, Body{}, two_cameras(), Rng(1));
  const Observation seen = last_until(5, robot);
  EXPECT_TRUE(seen.health.bumper_pressed);
  const Truth truth = *robot.truth();
  EXPECT_NEAR(truth.poses.back().clearance_m, 0, 1e-6);
  EXPECT_NEAR(truth.poses.front().clearance_m, 0.75, 1e-9) << "the wall is nearer at first";
  ASSERT_THAT(truth.contacts, SizeIs(1));
  EXPECT_FALSE(truth.contacts[0].while_moving);
  // Two pictures a set, at 15 sets a second, the walker 1 m/s.
  EXPECT_NEAR(draw_calls[30].scene_state.T_scene_object.at(0).translation.x(), 4, 1e-6);
  EXPECT_TRUE(draw_calls[29].scene_state.power.empty());
  EXPECT_NEAR(draw_calls[60].scene_state.power.at("lamps"), 0.5, 1e-9);
}

TEST(SimulatedRobot, SeesPeopleAtEveryMomentOfAnExposure) {
  std::vector<DrawCall> draw_calls;
  Surroundings around = room_of(with_walker({{5, 0.5}, {5, 5.5}}));
  around.draw = [inner = around.draw](const View& view, const RenderOutputs& outputs,
                                      const SceneState& scene_state) {
    RenderedImage rendered = inner(view, outputs, scene_state);
    if (outputs.depth) {
      rendered.depth_m = cv::Mat(rendered.bgr.size(), CV_32FC1, cv::Scalar(4));
    }
    if (outputs.instance) {
      rendered.instance = cv::Mat(rendered.bgr.size(), CV_16UC1, cv::Scalar(1));
    }
    return rendered;
  };
  around = recording(draw_calls, around);
  SimulatedOptions options = starting_at(1, 3);
  options.sensor.exposure = FixedExposure{160, 0.01};
  Rig slow = front_camera_alone();
  slow.cameras["front"].rate_hz = 5;
  SimulatedRobot robot(options, around, Body{}, slow, Rng(1));
  for (int k = 0; k < 8; ++k) {
    draw_calls.clear();
    next_set(robot);
  }
  // 1 m/s for 0.16 s, 4 m before a lens of 38 px: 1.5 px. A look at how far it is, then three.
  ASSERT_THAT(draw_calls, SizeIs(4));
  const auto walked_m = [&](std::size_t from, std::size_t to) {
    return draw_calls[to].scene_state.T_scene_object.at(0).translation.y() -
           draw_calls[from].scene_state.T_scene_object.at(0).translation.y();
  };
  constexpr double kRoundoff_m = 1e-8;  // of stamps, cut to nanoseconds
  EXPECT_NEAR(walked_m(1, 2), 0.16 / 3, kRoundoff_m);
  EXPECT_NEAR(walked_m(2, 3), 0.16 / 3, kRoundoff_m);
  EXPECT_EQ(walked_m(0, 2), 0);
}

TEST(SimulatedRobot, DrawsNoStartBesideThingsThatMove) {
  const Surroundings around = room_of(with_walker({{1, 1}, {1, 2}}));
  EXPECT_EQ(refusal([&] {
              SimulatedRobot(starting_at(1.5, 1), around, Body{}, two_cameras(), Rng(1));
            }).substr(0, 67),
            "platform.start: x_m: 1.500, y_m: 1.000 is 0.248 m from walker, but ");
}

TEST(SimulatedRobot, FollowsARouteWhateverItIsTold) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  robot.follow({{{3, 1}, {5, 1}, {5, 4}}, 0.5});
  while (!robot.route_done() && robot.now() < time_at(40)) {
    robot.observe(time_at(40));
    robot.drive({-0.5, 1}, std::chrono::seconds(1));
  }
  EXPECT_TRUE(robot.route_done());
  const Truth truth = *robot.truth();
  EXPECT_THAT(truth.contacts, IsEmpty());
  EXPECT_NEAR((truth.poses.back().T_scene_body.position() - Vec2(5, 4)).norm(), 0, 0.1);
}

TEST(SimulatedRobot, RepeatsItselfBitForBit) {
  const auto drive = [](std::uint64_t seed) {
    SimulatedRobot robot = robot_with({}, seed);
    Rng rng(9);
    Observation last;
    while (robot.now() < time_at(20)) {
      last = robot.observe(time_at(20));
      robot.drive({rng.uniform(-0.6, 0.6), rng.uniform(-1.5, 1.5)}, std::chrono::seconds(1));
    }
    return last;
  };
  const Observation a = drive(3);
  const Observation b = drive(3);
  EXPECT_TRUE(a.odometry.T_odom_body == b.odometry.T_odom_body);
  EXPECT_EQ(cv::norm(a.pictures.at("front").bgr, b.pictures.at("front").bgr, cv::NORM_INF), 0);
  EXPECT_FALSE(a.odometry.T_odom_body == drive(4).odometry.T_odom_body);
}

// The room whose picture is white in the one pixel that shows a landmark.
Surroundings with_landmark(const Vec3& p_scene) {
  Surroundings around = room();
  around.draw = [p_scene, inner = around.draw](const View& view, const RenderOutputs& outputs,
                                               const SceneState& scene_state) {
    RenderedImage rendered = inner(view, outputs, scene_state);
    const Vec3 p_camera = view.T_scene_camera.inverse() * p_scene;
    if (p_camera.z() > 0) {
      const Vec2 px = view.intrinsics.project(p_camera);
      cv::circle(rendered.bgr,
                 {static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y()))}, 2,
                 cv::Scalar::all(255), -1);
    }
    return rendered;
  };
  return around;
}

// Where the landmark is in a picture: the middle of what is brighter than all else.
Vec2 brightest_px(const cv::Mat& bgr) {
  cv::Mat grey;
  cv::extractChannel(bgr, grey, 1);
  double most = 0;
  cv::minMaxLoc(grey, nullptr, &most);
  Vec2 sum = Vec2::Zero();
  int count = 0;
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      if (grey.at<std::uint8_t>(v, u) > most - 40) {
        sum += Vec2(u, v);
        ++count;
      }
    }
  }
  return sum / count;
}

SimulatedOptions noiseless(double x_m, double y_m) {
  SimulatedOptions options = starting_at(x_m, y_m);
  options.sensor.noise = NoNoise{};
  options.sensor.vignetting = 0;
  options.sensor.motion_blur = false;
  return options;
}

Rig sharp_front_camera() {
  Rig rig = front_camera_alone();
  rig.cameras["front"].intrinsics = pinhole(640, 480, deg_to_rad(80));
  return rig;
}

std::vector<cv::Mat> pictures_of(SimulatedRobot& robot, const std::string& camera, int count) {
  std::vector<cv::Mat> all;
  robot.drive({0.2, 0.3}, std::chrono::seconds(60));
  for (int i = 0; i < count; ++i) {
    all.push_back(next_set(robot).pictures.at(camera).bgr);
  }
  return all;
}

bool same_pixels(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(),
                    [](const cv::Mat& x, const cv::Mat& y) { return cv::norm(x, y) == 0; });
}

constexpr double kPixel_px = 1;  // the landmark's middle, each way and both times

TEST(TruthAndBelief, ACameraYawedByADegreeShowsALandmarkShifted) {
  const Rig rig = sharp_front_camera();
  const Intrinsics& lens = rig.cameras.at("front").intrinsics;
  const Vec3 ahead_scene(4, 1, 0.78);
  SimulatedOptions options = noiseless(1, 1);
  SimulatedRobot straight(options, with_landmark(ahead_scene), Body{}, rig, Rng(1));
  options.mounting_error.exactly["front"].rotation_rad.z() = deg_to_rad(1);
  SimulatedRobot yawed(options, with_landmark(ahead_scene), Body{}, rig, Rng(1));
  const Vec2 before = brightest_px(next_set(straight).pictures.at("front").bgr);
  const Vec2 after = brightest_px(next_set(yawed).pictures.at("front").bgr);
  EXPECT_NEAR(before.x(), lens.cx_px, kPixel_px);
  EXPECT_NEAR(after.x() - before.x(), lens.fx_px * std::tan(deg_to_rad(1)), kPixel_px);
  EXPECT_NEAR(after.y() - before.y(), 0, kPixel_px);
  EXPECT_EQ(yawed.rig().cameras.at("front").T_body_camera.rotation.coeffs(),
            rig.cameras.at("front").T_body_camera.rotation.coeffs());
}

TEST(TruthAndBelief, AnotherLensShowsALandmarkElsewhere) {
  const Rig rig = sharp_front_camera();
  const Vec3 beside_scene(3, 2, 1.2);
  const Vec3 p_camera =
      (on_floor({1, 1, 0}) * rig.cameras.at("front").T_body_camera).inverse() * beside_scene;
  for (const LensOffset& offset :
       {LensOffset{5, {0, 0}, 0}, LensOffset{0, {8, -12}, 0}, LensOffset{0, {0, 0}, 0.1}}) {
    SimulatedOptions options = noiseless(1, 1);
    options.lens_error.exactly["front"] = offset;
    SimulatedRobot robot(options, with_landmark(beside_scene), Body{}, rig, Rng(1));
    const Vec2 px = brightest_px(next_set(robot).pictures.at("front").bgr);
    const Vec2 told = rig.cameras.at("front").intrinsics.project(p_camera);
    const Vec2 real = robot.true_rig().cameras.at("front").intrinsics.project(p_camera);
    EXPECT_GT((real - told).norm(), 4 * kPixel_px);
    EXPECT_LT((px - real).norm(), 2 * kPixel_px);
  }
}

TEST(TruthAndBelief, AClockErrorMovesStampsAlone) {
  SimulatedOptions options = starting_at(1, 1);
  SimulatedRobot right = robot_with(options);
  options.clock_error.exactly["front"] = 0.004;
  options.truth.labels = true;
  SimulatedRobot wrong = robot_with(options);
  right.drive({0.2, 0.3}, std::chrono::seconds(60));
  wrong.drive({0.2, 0.3}, std::chrono::seconds(60));
  for (int i = 0; i < 10; ++i) {
    const Observation a = next_set(right);
    const Observation b = next_set(wrong);
    EXPECT_EQ(b.stamp, a.stamp);
    EXPECT_EQ(b.odometry.T_odom_body.x_m, a.odometry.T_odom_body.x_m);
    EXPECT_EQ(b.pictures.at("front").stamp - a.pictures.at("front").stamp,
              std::chrono::milliseconds(4));
    EXPECT_EQ(b.pictures.at("floor").stamp, a.pictures.at("floor").stamp);
    EXPECT_EQ(cv::norm(a.pictures.at("front").bgr, b.pictures.at("front").bgr), 0);
    EXPECT_EQ(wrong.true_pictures().at("front").stamp, a.pictures.at("front").stamp);
  }
  EXPECT_EQ(wrong.truth()->rig->cameras.at("front").clock_offset_s, 0.004);
  EXPECT_EQ(wrong.truth()->poses.back().stamp, right.truth()->poses.back().stamp);
}

TEST(TruthAndBelief, ABeliefChangesNoPicture) {
  SimulatedOptions options = starting_at(1, 1);
  options.mounting_error.sigma_deg = 1;
  options.lens_error.sigma_focal_percent = 1;
  options.clock_error.sigma_s = 0.001;
  SimulatedRobot as_nominal(options, room(), Body{}, two_cameras(), Rng(3));
  options.nominal_rig = two_cameras();
  Rig other = two_cameras();
  other.cameras["front"].T_body_camera = mounted_camera({0.1, 0.05, 0.7}, 0.2, 0.1);
  other.cameras["front"].intrinsics.fx_px *= 1.1;
  other.cameras["front"].rate_hz = 5;
  other.cameras["front"].clock_offset_s = 0.02;
  SimulatedRobot as_believed(options, room(), Body{}, other, Rng(3));
  Rig alone = other;
  alone.cameras.erase("floor");
  SimulatedRobot of_one(options, room(), Body{}, alone, Rng(3));
  for (int i = 0; i < 5; ++i) {
    const Observation a = next_set(as_nominal);
    const Observation b = next_set(as_believed);
    const Observation c = next_set(of_one);
    EXPECT_EQ(a.pictures.at("front").stamp, b.pictures.at("front").stamp);
    EXPECT_EQ(cv::norm(a.pictures.at("front").bgr, b.pictures.at("front").bgr), 0);
    EXPECT_EQ(cv::norm(a.pictures.at("front").bgr, c.pictures.at("front").bgr), 0);
    EXPECT_EQ(cv::norm(a.pictures.at("floor").bgr, b.pictures.at("floor").bgr), 0);
    EXPECT_THAT(c.pictures, SizeIs(1));
  }
  for (const SimulatedRobot* robot : {&as_believed, &of_one}) {
    EXPECT_EQ(robot->true_rig().cameras.at("front").T_body_camera.rotation.coeffs(),
              as_nominal.true_rig().cameras.at("front").T_body_camera.rotation.coeffs());
    EXPECT_EQ(robot->true_rig().cameras.at("front").intrinsics.fx_px,
              as_nominal.true_rig().cameras.at("front").intrinsics.fx_px);
  }
  EXPECT_EQ(as_believed.rig().cameras.at("front").intrinsics.fx_px,
            other.cameras.at("front").intrinsics.fx_px);
}

TEST(TruthAndBelief, WhoBelievesInOtherCamerasOrSizesIsRefused) {
  SimulatedOptions options = starting_at(1, 1);
  options.nominal_rig = two_cameras();
  options.clock_error.exactly["frnt"] = 0.1;
  Rig rig = two_cameras();
  rig.cameras["frontal"] = rig.cameras["front"];
  rig.cameras["floor"].intrinsics = pinhole(32, 24, deg_to_rad(80));
  EXPECT_EQ(refusal([&] { SimulatedRobot(options, room(), Body{}, rig, Rng(1)); }),
            "platform.clock_error.exactly.frnt: the rig has no camera frnt; did you mean front?\n"
            "rig.cameras.floor.size_px: must be [64, 48], the size of the pictures that the "
            "simulated robot's camera takes (platform.nominal_rig)\n"
            "rig.cameras.frontal: the simulated robot has no camera frontal; did you mean front?");
}

TEST(TruthAndBelief, TheTruthTellsItsRigAndWheels) {
  SimulatedOptions options = starting_at(1, 1);
  options.mounting_error.exactly["front"].shift_m.x() = 0.01;
  options.wheel_error.exactly = WheelOffset{2, 0, 1};
  const Truth truth = *robot_with(options).truth();
  ASSERT_TRUE(truth.rig.has_value());
  constexpr double kRoundoff_m = 1e-12;
  EXPECT_NEAR(truth.rig->cameras.at("front").T_body_camera.translation.x(), 0.03, kRoundoff_m);
  EXPECT_NEAR(truth.wheels->left_radius_m, 1.02 * Body().wheel_radius_m, kRoundoff_m);
  EXPECT_NEAR(truth.wheels->base_m, 1.01 * Body().wheel_base_m, kRoundoff_m);
}

bool same_rig(const Rig& a, const Rig& b) {
  return std::all_of(a.cameras.begin(), a.cameras.end(), [&](const auto& named) {
    const RigCamera& camera = named.second;
    const RigCamera& other = b.cameras.at(named.first);
    return camera.T_body_camera.translation == other.T_body_camera.translation &&
           camera.T_body_camera.rotation.coeffs() == other.T_body_camera.rotation.coeffs() &&
           camera.intrinsics.fx_px == other.intrinsics.fx_px &&
           camera.intrinsics.cx_px == other.intrinsics.cx_px &&
           camera.intrinsics.distortion.index() == other.intrinsics.distortion.index() &&
           camera.clock_offset_s == other.clock_offset_s;
  });
}

TEST(TruthAndBelief, DifferUnlessTheOptionsSayOtherwise) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SimulatedOptions options;
    options.start = Pose2{1, 1, 0};
    const SimulatedRobot usual = robot_with(options, seed);
    for (const auto& [name, camera] : usual.true_rig().cameras) {
      const RigCamera& told = usual.rig().cameras.at(name);
      EXPECT_NE(camera.T_body_camera.translation, told.T_body_camera.translation);
      EXPECT_NE(camera.T_body_camera.rotation.coeffs(), told.T_body_camera.rotation.coeffs());
      EXPECT_NE(camera.intrinsics.fx_px, told.intrinsics.fx_px);
      EXPECT_NE(camera.intrinsics.cx_px, told.intrinsics.cx_px);
      EXPECT_FALSE(camera.intrinsics.is_pinhole());
      EXPECT_NE(camera.clock_offset_s, told.clock_offset_s);
    }
    const TrueWheels wheels = *usual.truth()->wheels;
    EXPECT_NE(wheels.left_radius_m + wheels.right_radius_m, 2 * Body().wheel_radius_m);
    EXPECT_NE(wheels.left_radius_m, wheels.right_radius_m);
    EXPECT_NE(wheels.base_m, Body().wheel_base_m);

    const SimulatedRobot exact = robot_with(as_believed(options), seed);
    EXPECT_TRUE(same_rig(exact.true_rig(), exact.rig()));
    EXPECT_EQ(exact.truth()->wheels->left_radius_m, Body().wheel_radius_m);
    EXPECT_EQ(exact.truth()->wheels->right_radius_m, Body().wheel_radius_m);
    EXPECT_EQ(exact.truth()->wheels->base_m, Body().wheel_base_m);
  }
}

TEST(TruthAndBelief, AKnockTurnsACameraFromItsInstantOn) {
  const Rig rig = sharp_front_camera();
  const Vec3 ahead_scene(4, 1, 0.78);
  SimulatedOptions options = noiseless(1, 1);
  InjectedFault knock;
  knock.camera = "front";
  knock.fault = CameraFaultKind::kKnock;
  knock.at_s = 0.5;
  knock.knock.rotation_rad.z() = deg_to_rad(1.5);
  options.faults = {knock};
  SimulatedRobot robot(options, with_landmark(ahead_scene), Body{}, rig, Rng(1));
  const Vec2 before = brightest_px(next_set(robot).pictures.at("front").bgr);
  last_until(0.99, robot);
  const Observation seen = next_set(robot);
  const Vec2 after = brightest_px(seen.pictures.at("front").bgr);
  EXPECT_NEAR(after.x() - before.x(),
              rig.cameras.at("front").intrinsics.fx_px * std::tan(deg_to_rad(1.5)), kPixel_px);
  const Pose3 T_body_camera = robot.truth()->rig->cameras.at("front").T_body_camera;
  EXPECT_EQ(T_body_camera.translation, rig.cameras.at("front").T_body_camera.translation);
  EXPECT_NEAR(
      T_body_camera.rotation.angularDistance(rig.cameras.at("front").T_body_camera.rotation),
      deg_to_rad(1.5), 1e-9);
}

TEST(TruthAndBelief, ErrorsOfNothingLeaveTheBits) {
  SimulatedOptions options = starting_at(1, 1);
  SimulatedRobot plain = robot_with(options, 5);
  options.nominal_rig = two_cameras();
  options.lens_error.exactly["front"] = {};
  options.clock_error.exactly["floor"] = 0;
  options.mounting_error.exactly["front"] = {};
  SimulatedRobot named = robot_with(options, 5);
  EXPECT_TRUE(same_pixels(pictures_of(plain, "front", 5), pictures_of(named, "front", 5)));
  EXPECT_EQ(plain.rig().cameras.at("floor").floor->marks.at(2).px,
            named.rig().cameras.at("floor").floor->marks.at(2).px);
  EXPECT_EQ(plain.truth()->wheels->left_radius_m, named.truth()->wheels->left_radius_m);
}

}  // namespace
}  // namespace panoptes::sim

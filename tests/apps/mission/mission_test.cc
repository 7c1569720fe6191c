// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/mission.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/mission/open_robot.h"
#include "core/base/error.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

const std::string kScenes = PANOPTES_SOURCE_DIR "/scenes/";
const std::string kOffice = kScenes + "missions/explore-office.yaml";

std::vector<std::string> faults(const std::vector<std::string>& overrides,
                                CameraRequirement needs = CameraRequirement::kDriver) {
  try {
    load_mission<ExploreMission>(kOffice, overrides, needs);
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

TEST(Mission, TheOfficeReadsAsWritten) {
  const auto mission = load_mission<ExploreMission>(kOffice, {"seed=7", "until.duration_s=60"});
  EXPECT_EQ(mission.name, "explore-office");
  EXPECT_EQ(mission.rig.cameras.size(), 3U);
  EXPECT_EQ(mission.seed, 7U);
  EXPECT_EQ(mission.until.duration_s, 60);
  EXPECT_TRUE(std::holds_alternative<Drive<"navigator">>(mission.drive));
  EXPECT_EQ(requirements(mission).size(), 3U);
  EXPECT_EQ(default_out_dir(mission), "runs/explore-office-7");
  const auto& simulated = std::get<sim::SimulatedOptions>(mission.platform);
  EXPECT_EQ(simulated.world.name, "office");
  EXPECT_FALSE(simulated.start.has_value());
}

TEST(Mission, WhatARunKeepsRepeatsItWhereverItLies) {
  const auto mission = load_mission<ExploreMission>(kOffice, {"platform.start={x_m: 2, y_m: 3}"});
  const std::string text = write_settings(mission);
  EXPECT_THAT(text, testing::HasSubstr("world: \"data:worlds/office.yaml\""));
  const auto again = read_settings_text<ExploreMission>(text, "/elsewhere/mission.yaml");
  EXPECT_EQ(write_settings(again), text);
  EXPECT_EQ(again.name, "explore-office");
}

TEST(Mission, TellsTheNamesOfTodayOfSettingsThatWereCalledOtherwise) {
  const std::string verified = "navigator.localiser.loops.method.";
  for (const auto& [before, today] : std::vector<std::pair<std::string, std::string>>{
           {"navigator.driver.carrot_m", "lookahead_m"},
           {"navigator.driver.search.comfort_m", "inflation_distance_m"},
           {"navigator.driver.search.crowding", "clearance_weight"},
           {"navigator.explore.method.settle_s", "fixed_cost_s"},
           {"navigator.explore.method.loyalty", "hysteresis"},
           {"navigator.explore.least_gain", "min_information_gain"},
           {"navigator.revisit.settle_s", "fixed_cost_s"},
           {"navigator.localiser.loops.min_way_m", "min_path_m"},
           {verified + "reach_m", "tolerance_m"},
           {verified + "reach_deg", "tolerance_deg"},
           {verified + "reach_rad", "tolerance_rad"},
           {verified + "contours.reach_m", "cutoff_m"},
           {"navigator.mapper.floor.parallax_check.reach_m", "range_m"},
           {"navigator.mapper.contour_way_m", "contour_path_m"},
           {"navigator.mapper.floor.learn_every", "learn_every_s"},
           {"navigator.mapper.floor.colour.mass_decay", "mass_half_life_s"}}) {
    const std::string key = before.substr(before.rfind('.') + 1);
    EXPECT_THAT(faults({before + "=0.5"}),
                testing::ElementsAre("--set " + before + ": " + key + " is now " + today));
  }
}

TEST(Mission, TellsOnceOfSettingsThatAreGone) {
  for (const std::string key : {"cycle_s", "reaction_s"}) {
    const std::string path = "navigator.driver.dwa." + key;
    EXPECT_THAT(faults({path + "=0.1"}),
                testing::ElementsAre("--set " + path +
                                     ": is not set any more: the platform states its timing, and "
                                     "the cycle is measured"));
  }
}

TEST(Mission, RefusesARigWithoutTheCameraARoleNeeds) {
  const std::string rig = kScenes + "rigs/front-back-edges.yaml";
  const std::vector<std::string> lines =
      faults({"rig.cameras.front.roles=[]", "rig.cameras.back.roles=[]"});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_THAT(lines[0], testing::StartsWith(rig + ":"));
  EXPECT_THAT(lines[0],
              testing::EndsWith(": rig: has no camera with the role loop_front; SLAM in "
                                "'explore-office' needs a camera for loops, whose role begins with "
                                "loop_, and one for the floor"));
  EXPECT_TRUE(faults({"rig.cameras.front.roles=[]"}).empty());  // one is enough
}

// A mission is refused by what the line of its pilot in apps/CMakeLists.txt says, not by its name.
TEST(Mission, EveryPilotSaysWhatItCannotDriveWithout) {
  EXPECT_TRUE(needs_of(Drive<"navigator">()).slam);
  EXPECT_TRUE(needs_of(Drive<"goals">()).slam);
  EXPECT_TRUE(needs_of(Drive<"route">()).truth);
  EXPECT_TRUE(needs_of(Drive<"teleop">()).terminal);
  const DriveNeeds none = needs_of(Drive<"none">());
  EXPECT_FALSE(none.slam || none.truth || none.terminal);
  constexpr DriveNeeds kTwo = all_of(DriveNeed::kTerminal, DriveNeed::kSlam);
  EXPECT_TRUE(kTwo.slam && kTwo.terminal && !kTwo.truth);
  EXPECT_EQ(drives_on_any_robot(true), "navigator or goals or program or teleop or none");
  EXPECT_EQ(drives_on_any_robot(false), "program or teleop or none");
}

TEST(Mission, WhoDoesNotNavigateNeedsNoSuchCamera) {
  const std::vector<std::string> without_cameras{"rig.cameras.front.roles=[]",
                                                 "rig.cameras.back.roles=[]"};
  std::vector<std::string> parked = without_cameras;
  parked.emplace_back("drive=none");
  EXPECT_THAT(faults(parked), testing::IsEmpty());
  EXPECT_THAT(faults(without_cameras, CameraRequirement::kNothing), testing::IsEmpty());
  EXPECT_EQ(faults(without_cameras).size(), 1U);
  EXPECT_EQ(faults(parked, CameraRequirement::kNavigator).size(), 1U);
}

TEST(Mission, ARigMayBeWithoutCamerasWhereNobodyNavigates) {
  EXPECT_THAT(faults({"rig={cameras: {}}", "drive=teleop"}), testing::IsEmpty());
  EXPECT_THAT(faults({"rig={cameras: {}}"}),
              testing::ElementsAre(
                  testing::HasSubstr("rig: has no camera with the role loop_front or floor; ")));
  EXPECT_THAT(faults({"rig={}"}),
              testing::ElementsAre(testing::HasSubstr("rig.cameras: missing; it must be given")));
}

TEST(Mission, RefusesSettingsOfCamerasThatTheRigHasNot) {
  EXPECT_THAT(faults({"platform.trigger.groups.usb.cameras=[front, flor]"}),
              testing::ElementsAre(testing::EndsWith(
                  " platform.trigger.groups.usb.cameras: the rig has no camera flor; did you "
                  "mean floor?")));
  EXPECT_THAT(faults({"platform.sensors.sideways.bayer=true"}),
              testing::ElementsAre(testing::EndsWith(
                  ": platform.sensors.sideways: the rig has no camera sideways; name one of the "
                  "rig's")));
}

TEST(Mission, RefusesACameraInsideTheRobot) {
  EXPECT_THAT(faults({"rig.cameras.front.at_m=[0, 0, 0.2]"}),
              testing::ElementsAre(testing::EndsWith(
                  ": rig.cameras.front: is mounted inside the robot, whose hull is 0.240 m high "
                  "and reaches 0.250 m from its middle; mount it above or farther out")));
}

TEST(Mission, NoneThatIsHereBelievesARobotThatIsExactlyAsItBelieves) {
  int simulated = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kScenes + "missions")) {
    SCOPED_TRACE(entry.path().filename().string());
    const auto mission = load_mission<ExploreMission>(entry.path().string());
    const auto* robot = std::get_if<sim::SimulatedOptions>(&mission.platform);
    if (robot == nullptr) {
      continue;
    }
    ++simulated;
    EXPECT_GT(robot->mounting_error.sigma_deg, 0);
    EXPECT_GT(robot->mounting_error.sigma_m, 0);
    EXPECT_GT(robot->lens_error.sigma_focal_percent, 0);
    EXPECT_GT(robot->lens_error.sigma_centre_px, 0);
    EXPECT_GT(robot->lens_error.sigma_distortion, 0);
    EXPECT_GT(robot->clock_error.sigma_s, 0);
    EXPECT_GT(robot->wheel_error.sigma_radius_percent, 0);
    EXPECT_GT(robot->wheel_error.diameter_difference, 0);
    EXPECT_GT(robot->wheel_error.base_error, 0);
    EXPECT_TRUE(std::holds_alternative<sim::AutoExposure>(robot->sensor.exposure));
    EXPECT_TRUE(std::holds_alternative<sim::PhotonNoise>(robot->sensor.noise));
    EXPECT_TRUE(robot->sensor.motion_blur);
    for (const auto& [name, camera] : mission.rig.cameras) {
      const double off_axis_m = camera.T_body_camera.translation.head<2>().norm();
      EXPECT_TRUE(!camera.is_loop() || off_axis_m > 0.1) << name << " stands on the axis";
    }
  }
  EXPECT_GE(simulated, 14);
  const auto exact = load_mission<ExploreMission>(kOffice, {"platform.errors=none"});
  const auto& robot = std::get<sim::SimulatedOptions>(exact.platform);
  EXPECT_EQ(write_settings(robot), write_settings(sim::as_believed(robot)));
}

TEST(Mission, WhatIsSetOfTheRigIsBelievedAndNoMore) {
  const auto as_written = load_mission<ExploreMission>(kOffice);
  const auto nominal_of = [](const ExploreMission& mission) {
    return std::get<sim::SimulatedOptions>(mission.platform).nominal_rig;
  };
  EXPECT_FALSE(nominal_of(as_written).has_value());
  const std::string other = kScenes + "rigs/front-back-floor.yaml";
  for (const std::string& set :
       std::vector<std::string>{"rig.cameras.front.yaw_deg=2", "rig=" + other}) {
    const auto mission = load_mission<ExploreMission>(kOffice, {set});
    ASSERT_TRUE(nominal_of(mission).has_value()) << set;
    EXPECT_EQ(write_settings(*nominal_of(mission)), write_settings(as_written.rig)) << set;
    EXPECT_NE(write_settings(mission.rig), write_settings(as_written.rig)) << set;
    // What a run leaves is run again under the same truth, whatever is set then.
    const auto again = read_settings_text<ExploreMission>(write_settings(mission), "mission.yaml",
                                                          {"rig.cameras.back.rate_hz=7"});
    EXPECT_EQ(write_settings(*nominal_of(again)), write_settings(as_written.rig)) << set;
  }
  const auto both = load_mission<ExploreMission>(
      kOffice, {"rig=" + other, "platform.nominal_rig=" + other, "rig.cameras.front.yaw_deg=2"});
  EXPECT_EQ(write_settings(*nominal_of(both)), write_settings(read_settings<Rig>(other)));
  const std::string corners = kScenes + "rigs/front-back-floor-corners.yaml";
  EXPECT_THAT(faults({"rig=" + corners}),
              testing::Contains(testing::HasSubstr("rig.cameras.corner_back_left: the simulated "
                                                   "robot has no camera corner_back_left")));
}

TEST(Mission, RefusesErrorsOfCamerasThatTheRigHasNot) {
  EXPECT_THAT(faults({"platform.mounting_error.exactly.frnt.yaw_deg=1"}),
              testing::ElementsAre("--set platform.mounting_error.exactly.frnt.yaw_deg: "
                                   "platform.mounting_error.exactly.frnt: the rig has no camera "
                                   "frnt; did you mean front?"));
  EXPECT_THAT(faults({"platform.lens_error.exactly={bak: {focal_percent: 1}}",
                      "platform.clock_error.exactly={flor: 0.01}"}),
              testing::UnorderedElementsAre(
                  testing::HasSubstr("lens_error.exactly.bak: the rig has no camera bak; did you "
                                     "mean back?"),
                  testing::HasSubstr("clock_error.exactly.flor: the rig has no camera flor; did "
                                     "you mean floor?")));
  EXPECT_THAT(faults({"platform.faults=[{camera: frnt, fault: knock, at_s: 1, yaw_deg: 1}]"}),
              testing::ElementsAre(testing::HasSubstr("the rig has no camera frnt; did you mean")));
  EXPECT_THAT(faults({"platform.faults=[{camera: front, fault: knock, at_s: 1, z_m: -0.9}]"}),
              testing::ElementsAre(testing::HasSubstr("is mounted 0.450 m below the floor")));
}

TEST(Mission, RefusesRequirementsThatNobodyCanCheck) {
  EXPECT_THAT(
      faults({"require=[\"collisions = 0\"]"}),
      testing::ElementsAre("--set require: requirement 'collisions = 0': must be a figure, one "
                           "of == != < <= > >=, and a value"));
}

TEST(Mission, RefusesWhatIsOutOfRange) {
  EXPECT_THAT(
      faults({"until.duration_s=-1", "seed=1.5", "drive=wheel", "platform.kind=p3dx"}),
      testing::UnorderedElementsAre(
          "--set until.duration_s: must be from 0.001 to 1e+08, got -1",
          "--set seed: must be a whole number, got 1.5",
          "--set drive: must be one of navigator, goals, route, program, teleop, none, got wheel",
          "--set platform.kind: platform: must be one of simulated, recorded, pioneer, got p3dx"));
}

TEST(Mission, NamesGoalsToDriveTo) {
  const auto mission = load_mission<ExploreMission>(
      kOffice, {"drive={goals: [{x_m: 1.5, y_m: -2}, {x_m: 0, y_m: 0}]}"});
  const auto& drive = std::get<Drive<"goals">>(mission.drive);
  ASSERT_EQ(drive.points.size(), 2U);
  EXPECT_EQ(drive.points[0].x_m, 1.5);
  EXPECT_EQ(drive.points[0].y_m, -2);
  const auto again = read_settings_text<ExploreMission>(write_settings(mission), "mission.yaml");
  EXPECT_EQ(write_settings(again), write_settings(mission));
  EXPECT_THAT(faults({"drive=goals"}),
              testing::ElementsAre(testing::HasSubstr("must hold at least one place")));
  EXPECT_THAT(faults({"drive={goals: [{x_m: 1}, {x_m: .nan, y_m: 20000}]}"}), testing::SizeIs(3));
}

TEST(Mission, NamesAProgramToDrive) {
  const auto motion = [](const std::string& drive, const std::string& more = "seed=1") {
    const auto mission = load_mission<ExploreMission>(kOffice, {"drive=" + drive, more});
    const auto again = read_settings_text<ExploreMission>(write_settings(mission), "mission.yaml");
    EXPECT_EQ(write_settings(again), write_settings(mission));
    return std::get<Drive<"program">>(mission.drive).motion;
  };
  EXPECT_EQ(std::get<Sawtooth>(motion("{program: sawtooth}")).left_rad, deg_to_rad(90));
  EXPECT_EQ(std::get<LegsAndTurns>(motion("{program: legs_and_turns}")).leg_m, 1);
  const Rose rose = std::get<Rose>(
      motion("{program: {kind: rose, petal_m: 0.4, step_deg: 30, turn_radps: 0.8}}"));
  EXPECT_EQ(rose.petal_m, 0.4);
  EXPECT_EQ(rose.step_rad, deg_to_rad(30));
  EXPECT_EQ(rose.pace.turn_radps, 0.8);
  EXPECT_EQ(std::get<Rose>(motion("{program: rose}", "drive.program.petal_m=0.3")).petal_m, 0.3);
}

TEST(Mission, RefusesProgramsThatCannotBeDriven) {
  EXPECT_THAT(faults({"drive=program"}),
              testing::ElementsAre("--set drive: drive.program: missing; it must be one of "
                                   "legs_and_turns, sawtooth, rose, circle"));
  EXPECT_THAT(faults({"drive={program: ros}"}),
              testing::ElementsAre("--set drive: drive.program: must be one of legs_and_turns, "
                                   "sawtooth, rose, circle, got ros; did you mean rose?"));
  EXPECT_THAT(
      faults({"drive={program: {kind: rose, petal_m: 0, step_deg: 200, over_deg: -1}}"}),
      testing::ElementsAre("--set drive: drive.program.petal_m: must be from 0.05 to 10, got 0",
                           testing::HasSubstr("drive.program.step_deg: must be from"),
                           testing::HasSubstr("drive.program.over_deg: must be from 0")));
  EXPECT_THAT(faults({"drive={program: {kind: sawtooth, left_deg: 45}}"}),
              testing::ElementsAre(testing::HasSubstr(
                  "must be at least a degree less than left_deg, or it would never come round")));
  EXPECT_THAT(faults({"drive={program: {kind: legs_and_turns, petal_m: 1, speed_mps: 0}}"}),
              testing::SizeIs(2));
}

TEST(Mission, ChecksThatAProgramHasRoom) {
  const auto told = [](const std::string& start) {
    const auto mission = load_mission<ExploreMission>(
        kOffice, {"drive={program: {kind: legs_and_turns, leg_m: 3}}", "platform.start=" + start});
    try {
      check_platform(mission);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("ok");
  };
  EXPECT_THAT(
      told("{x_m: 4.95, y_m: 4.0, theta_deg: 45}"),
      testing::AllOf(testing::HasSubstr("has no room for what drive: program is to do, "
                                        "which needs clear floor for 3.35 m ahead of where"),
                     testing::HasSubstr("from its way; move the start")));
  EXPECT_EQ(told("null"), "ok");  // then it is drawn
}

TEST(Mission, TellsWhatAPioneerLacks) {
  const auto told = [](const std::string& platform, const std::string& drive = "none") {
    try {
      read_settings_text<ExploreMission>("platform: " + platform + "\ndrive: " + drive + "\n",
                                         "m.yaml");
    } catch (const ConfigError& error) {
      return error.lines();
    }
    return std::vector<std::string>();
  };
  EXPECT_THAT(told("{kind: pioneer}"),
              testing::ElementsAre("m.yaml:1:11: platform.base: missing; it must be serial:PORT, "
                                   "tcp:HOST:PORT, standin:pty or standin:tcp"));
  EXPECT_THAT(told("{kind: pioneer, base: ttyUSB0}"),
              testing::ElementsAre("m.yaml:1:33: platform.base: must be serial:PORT, "
                                   "tcp:HOST:PORT, standin:pty or standin:tcp, got ttyUSB0"));
  EXPECT_THAT(told("{kind: pioneer, base: 'tcp:robot:0'}"),
              testing::ElementsAre("m.yaml:1:33: platform.base: its port must be a "
                                   "number between 1 and 65535, got \"tcp:robot:0\""));
  EXPECT_THAT(told("{kind: pioneer, base: 'standin:pty'}"),
              testing::ElementsAre("m.yaml:1:11: platform.standin: missing; it must name the "
                                   "mission whose simulated robot stands in"));
  EXPECT_THAT(told("{kind: pioneer, base: 'serial:/dev/ttyS0', cameras: standin}"),
              testing::Contains(testing::HasSubstr("must be none with this base")));
  EXPECT_THAT(told("{kind: pioneer, base: 'serial:/dev/ttyS0'}"), testing::IsEmpty());
  EXPECT_THAT(told("{kind: pioneer, base: 'serial:/dev/ttyS0'}",
                   "{route: {waypoints: [{x_m: 1, y_m: 2}], speed_mps: 0.3}}"),
              testing::ElementsAre(testing::EndsWith(
                  "drive: must not be route on a pioneer: it drives by the true pose, which only a "
                  "simulated platform knows; use program or teleop or none")));
  EXPECT_THAT(told("{kind: pioneer, base: 'serial:/dev/ttyS0'}", "navigator"),
              testing::ElementsAre(testing::EndsWith(
                  "platform: has cameras: none, and SLAM needs pictures; drive it with drive: "
                  "program or teleop or none")));
}

TEST(Mission, TakesRigAndRobotOfAStandIn) {
  const auto mission =
      load_mission<ExploreMission>(PANOPTES_SOURCE_DIR "/scenes/missions/wire-office.yaml");
  const auto& wired = std::get<PioneerOptions>(mission.platform);
  ASSERT_NE(wired.standin, nullptr);
  EXPECT_EQ(mission.rig.cameras.size(), wired.standin->rig.cameras.size());
  const auto again = read_settings_text<ExploreMission>(write_settings(mission), "again.yaml");
  EXPECT_EQ(write_settings(again), write_settings(mission));
}

TEST(Mission, DrivesAlongARouteGivenInline) {
  const auto mission = load_mission<ExploreMission>(
      kOffice, {"drive={route: {waypoints: [{x_m: 1, y_m: 2}], speed_mps: 0.3}}"});
  EXPECT_EQ(std::get<Drive<"route">>(mission.drive).route.waypoints.size(), 1U);
  // a run's mission.yaml holds the way itself, not the name of a file that may be gone
  const std::string route = testing::TempDir() + "panoptes-mission-test-route.yaml";
  write_file(route, "waypoints: [{x_m: 1, y_m: 2.5}]\n");
  const std::string written =
      write_settings(load_mission<ExploreMission>(kOffice, {"drive={route: " + route + "}"}));
  std::filesystem::remove(route);
  const auto again = read_settings_text<ExploreMission>(written, "mission.yaml");
  EXPECT_EQ(std::get<Drive<"route">>(again.drive).route.waypoints.at(0).y_m, 2.5);
  EXPECT_TRUE(std::holds_alternative<Drive<"none">>(
      load_mission<ExploreMission>(kOffice, {"drive=none"}).drive));
}

}  // namespace
}  // namespace panoptes

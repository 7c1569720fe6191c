// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/camera/rig.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

struct CovarianceText {
  std::string parameter;
  std::vector<double> row;
};

std::vector<std::string> faults(const std::string& text) {
  try {
    read_settings_text<Rig>(text, "rig.yaml");
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

constexpr const char* kRig = R"(cameras:
  front: {roles: [loop_front], rate_hz: 10, size_px: [640, 480], fov_deg: 80, at_m: [0.1, 0, 0.7]}
  down:
    roles: [floor]
    fov_deg: 75
    at_m: [0.1, -0.02, 0.75]
    yaw_deg: 3
    tilt_deg: 27
    floor:
      rows: lower_half
      near_m: 0.21
      far_m: 3.5
      marks: [{p_body_m: [1, 0.3], px: [20, 30]}, {p_body_m: [1, -0.3], px: [220, 30]},
              {p_body_m: [2, 0.3], px: [20, 5]}, {p_body_m: [2, -0.3], px: [200, 7]}]
      homography: [1, 2, 3, 4, 5, 6, 7, 8, 9]
)";

// Its right side down: what is level before it rises to the right in the picture.
TEST(RigFields, RollsACameraAboutItsAxis) {
  const std::string text =
      "cameras: {one: {fov_deg: 80, at_m: [0.1, 0, 0.5], yaw_deg: 30, tilt_deg: 10";
  const auto camera = [&](const std::string& more) {
    return read_settings_text<Rig>(text + more + "}}", "r.yaml").cameras.at("one");
  };
  const RigCamera level = camera("");
  const RigCamera rolled = camera(", roll_deg: 5");
  const Vec3 axis = level.T_body_camera.rotation * Vec3::UnitZ();
  EXPECT_NEAR((rolled.T_body_camera.rotation * Vec3::UnitZ() - axis).norm(), 0, 1e-12);
  const Vec3 to_the_right = rolled.T_body_camera.rotation * Vec3::UnitX();
  EXPECT_NEAR(to_the_right.z(), -std::sin(deg_to_rad(5)) * std::cos(deg_to_rad(10)), 1e-12);
  EXPECT_EQ(camera(", roll_deg: 0").T_body_camera.rotation.coeffs(),
            level.T_body_camera.rotation.coeffs());
}

TEST(RigFields, ReadsMountingAndView) {
  const auto rig = read_settings_text<Rig>(kRig, "rig.yaml");
  const RigCamera& front = rig.cameras.at("front");
  EXPECT_TRUE(front.has_role("loop_front"));
  EXPECT_EQ(front.rate_hz, 10);
  EXPECT_EQ(front.intrinsics.fx_px, pinhole(640, 480, deg_to_rad(80)).fx_px);
  EXPECT_FALSE(front.floor.has_value());
  const RigCamera& down = rig.cameras.at("down");
  const Pose3 expected = mounted_camera({0.1, -0.02, 0.75}, deg_to_rad(3), deg_to_rad(27));
  EXPECT_EQ(down.T_body_camera.rotation.coeffs(), expected.rotation.coeffs());
  EXPECT_EQ(down.T_body_camera.translation, expected.translation);
  EXPECT_EQ(down.floor->rows, FloorView::Rows::kLowerHalf);
  EXPECT_EQ(down.floor->near_m, 0.21);
  EXPECT_EQ(down.floor->marks.at(3).px, Vec2(200, 7));
  EXPECT_EQ((*down.floor->H_body_px)(0, 2), 3);
  EXPECT_EQ((*down.floor->H_body_px)(2, 0), 7);
}

TEST(RigFields, WhatIsWrittenReadsBackToTheSameBits) {
  const auto rig = read_settings_text<Rig>(kRig, "rig.yaml");
  const std::string text = write_settings(rig);
  const auto back = read_settings_text<Rig>(text, "rig.yaml");
  EXPECT_EQ(write_settings(back), text);
  for (const auto& [name, camera] : rig.cameras) {
    const RigCamera& other = back.cameras.at(name);
    EXPECT_EQ(other.T_body_camera.rotation.coeffs(), camera.T_body_camera.rotation.coeffs());
    EXPECT_EQ(other.T_body_camera.translation, camera.T_body_camera.translation);
    EXPECT_EQ(other.intrinsics.fx_px, camera.intrinsics.fx_px);
    EXPECT_EQ(other.intrinsics.cy_px, camera.intrinsics.cy_px);
    EXPECT_EQ(other.roles, camera.roles);
  }
}

TEST(RigFields, RefusesWhatNoCameraCanBe) {
  EXPECT_THAT(faults("camera: {}"),
              ElementsAre("rig.yaml:1:1: cameras: missing; it must be given",
                          "rig.yaml:1:1: camera: unknown key; did you mean cameras?"));
  EXPECT_THAT(
      faults("cameras:\n  a b: {size_px: [320], fov_deg: 190, at_m: [0, 0, 1]}\n"
             "  c: {roles: [floor]}\n"),
      ElementsAre("rig.yaml:2:3: cameras: must be named by letters, digits, _ and - (their names "
                  "become file names)",
                  "rig.yaml:2:18: cameras.a b.size_px: must be [width, height]",
                  "rig.yaml:2:34: cameras.a b.fov_deg: must be from 1 to 170, got 190",
                  "rig.yaml:3:6: cameras.c.fov_deg: missing; it must be given (or lens, or "
                  "intrinsics_px)",
                  "rig.yaml:3:6: cameras.c.at_m: missing; it must be given",
                  "rig.yaml:3:6: cameras.c.floor: missing; a camera with the role floor must say "
                  "which part of its picture is mapped"));
  EXPECT_THAT(
      faults("cameras: {a: {fov_deg: 80, at_m: [0, 0, 1], rate_hz: 0.01}, b: {fov_deg: 80, at_m: "
             "[0, 0, 1], rate_hz: 0, roles: [loop_back]}, c: {fov_deg: 80, at_m: [0, 0, 1], "
             "rate_hz: 0, roles: [corner]}, d: {fov_deg: 80, at_m: [0, 0, 1], rate_hz: 0, roles: "
             "[loop_left]}}"),
      ElementsAre("rig.yaml:1:54: cameras.a.rate_hz: must be from 0.1 to 1000, or 0 for a camera "
                  "that takes pictures only when it is asked to, got 0.01",
                  "rig.yaml:1:104: cameras.b.rate_hz: must be > 0 of a camera with the role "
                  "loop_back, whose pictures the navigator waits for, got 0",
                  "rig.yaml:1:235: cameras.d.rate_hz: must be > 0 of a camera with the role "
                  "loop_left, whose pictures the navigator waits for, got 0"));
  EXPECT_THAT(faults("cameras: {a: {fov_deg: 190, at_m: [0, 0, 1]}}"),
              ElementsAre("rig.yaml:1:24: cameras.a.fov_deg: must be from 1 to 170, got 190"));
  EXPECT_THAT(
      faults("cameras: {a: {fov_deg: 80, at_m: [0, 0, 1], floor: {near_m: 2, far_m: 1, marks: "
             "[{p_body_m: [1, 1], px: [1, 1]}]}}}"),
      ElementsAre("rig.yaml:1:71: cameras.a.floor.far_m: must be > near_m, got 1",
                  "rig.yaml:1:81: cameras.a.floor.marks: must be four or more, or none where they "
                  "are surveyed before the run"));
}

TEST(RigFields, RefusesNumbersThatShowNothing) {
  const std::string focal =
      "must have focal lengths of 0.05 to 100 times the picture's size (widths for fx, heights for "
      "fy); correct their unit";
  const std::string on_robot = "must be within 10 m of the robot's middle, in metres";
  EXPECT_THAT(
      faults("cameras:\n"
             "  a: {at_m: [0, 0, 790], intrinsics_px: [1e-3, 1e-3, 160, 120]}\n"
             "  b: {at_m: [0, 0, 1], lens: {focal_mm: 1e6, pixel_um: 3}}\n"
             "  c: {at_m: [0, 0, 1], intrinsics_px: [200, 200, 1e9, 120]}\n"
             "  d: {at_m: [0, 0, 1], fov_deg: 80, floor: {far_m: 1e9}}\n"),
      ElementsAre(
          "rig.yaml:2:13: cameras.a.at_m: " + on_robot,
          "rig.yaml:2:41: cameras.a.intrinsics_px: " + focal,
          "rig.yaml:3:30: cameras.b.lens: " + focal,
          "rig.yaml:4:39: cameras.c.intrinsics_px: must have cx and cy no farther from the middle "
          "of the picture than its own size",
          "rig.yaml:5:52: cameras.d.floor.far_m: must be from 0.01 to 100, got 1e9"));
}

TEST(RigFields, ReadsLensesThatBend) {
  const auto rig = read_settings_text<Rig>(
      "cameras:\n"
      "  a: {fov_deg: 80, at_m: [0, 0, 1], distortion: {kind: brown_conrady, k1: -0.2, k2: 0.03, "
      "p1: 0.001, p2: -0.002, k3: 0.004}}\n"
      "  b: {fov_deg: 190, at_m: [0, 0, 1], distortion: {kind: equidistant, k1: 0.01, k4: "
      "-0.0001}}\n"
      "  c: {fov_deg: 80, at_m: [0, 0, 1], distortion: none}\n",
      "rig.yaml");
  const Intrinsics& a = rig.cameras.at("a").intrinsics;
  EXPECT_EQ(a.distortion, Distortion(BrownConrady{-0.2, 0.03, 0.001, -0.002, 0.004}));
  const Intrinsics& b = rig.cameras.at("b").intrinsics;
  EXPECT_EQ(b.distortion, Distortion(Equidistant{0.01, 0, 0, -0.0001}));
  // 190 degrees from edge to edge
  const Vec3 left = b.direction({-0.5, 119.5}).value();
  EXPECT_NEAR(rad_to_deg(std::atan2(-left.x(), left.z())), 95, 1e-9);
  EXPECT_TRUE(rig.cameras.at("c").intrinsics.is_pinhole());
  const std::string text = write_settings(rig);
  const auto back = read_settings_text<Rig>(text, "rig.yaml");
  EXPECT_EQ(write_settings(back), text);
  EXPECT_EQ(back.cameras.at("a").intrinsics.distortion, a.distortion);
  EXPECT_EQ(back.cameras.at("a").intrinsics.fx_px, a.fx_px);
}

TEST(RigFields, TheViewFollowsFromLensAndSensor) {
  const auto rig = read_settings_text<Rig>(
      "cameras:\n"
      "  a: {size_px: [640, 480], at_m: [0, 0, 1], lens: {focal_mm: 2.8, sensor_mm: [4.8, 3.6]}}\n"
      "  b: {size_px: [640, 480], at_m: [0, 0, 1], lens: {focal_mm: 2.8, pixel_um: 7.5}}\n",
      "rig.yaml");
  for (const char* name : {"a", "b"}) {
    const Intrinsics& lens = rig.cameras.at(name).intrinsics;
    constexpr double kRoundoff_px = 1e-9;
    EXPECT_NEAR(lens.fx_px, 2.8 / 4.8 * 640, kRoundoff_px);
    EXPECT_NEAR(lens.fy_px, lens.fx_px, kRoundoff_px);  // square pixels
    EXPECT_EQ(lens.cx_px, 319.5);
    EXPECT_EQ(lens.cy_px, 239.5);
  }
}

TEST(RigFields, OneViewIsGivenOneWay) {
  EXPECT_THAT(
      faults(
          "cameras:\n"
          "  a: {fov_deg: 80, lens: {focal_mm: 2, pixel_um: 5}, at_m: [0, 0, 1]}\n"
          "  b: {fov_deg: 80, intrinsics_px: [100, 100, 160, 120], at_m: [0, 0, 1]}\n"
          "  c: {lens: {focal_mm: 2, pixel_um: 5}, intrinsics_px: [100, 100, 160, 120], at_m: [0, "
          "0, 1]}\n"
          "  d: {lens: {focal_mm: 2}, at_m: [0, 0, 1]}\n"
          "  e: {lens: {focal_mm: -2, pixel_um: 5, sensor_mm: [4, 3]}, at_m: [0, 0, 1]}\n"),
      ElementsAre(
          "rig.yaml:2:26: cameras.a.lens: must not be given beside the field of view",
          "rig.yaml:3:35: cameras.b.intrinsics_px: must not be given beside the field of view",
          "rig.yaml:4:56: cameras.c.intrinsics_px: must not be given beside lens",
          "rig.yaml:5:13: cameras.d.lens.sensor_mm: missing; it must be given (or pixel_um)",
          "rig.yaml:6:24: cameras.e.lens.focal_mm: must be > 0, got -2",
          "rig.yaml:6:38: cameras.e.lens.pixel_um: must not be given beside sensor_mm, got 5"));
}

TEST(RigFields, RefusesALensThatBendsBackInsideThePicture) {
  EXPECT_THAT(
      faults("cameras:\n"
             "  a:\n"
             "    fov_deg: 80\n"
             "    at_m: [0, 0, 1]\n"
             "    distortion: {kind: brown_conrady, k1: -0.4}\n"
             "  b:\n"
             "    fov_deg: 300\n"
             "    at_m: [0, 0, 1]\n"
             "    distortion: {kind: equidistant}\n"
             "  c:\n"
             "    intrinsics_px: [100, 100, -4, 120]\n"
             "    at_m: [0, 0, 1]\n"
             "    distortion: {kind: equidistant}\n"
             "  d:\n"
             "    fov_deg: 80\n"
             "    at_m: [0, 0, 1]\n"
             "    distortion: {kind: brown_conrady, k1: -0.1}\n"
             "    floor: {homography: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"),
      ElementsAre(
          "rig.yaml:5:17: cameras.a.distortion: bends back inside the picture: what is more than "
          "42.4 degrees off the axis is drawn nearer to the middle again, and the corners show "
          "nothing; narrow the field of view or correct the coefficients",
          "rig.yaml:7:14: cameras.b.fov_deg: must be from 1 to 288, got 300",
          "rig.yaml:11:20: cameras.c.intrinsics_px: must have cx and cy inside the picture where "
          "there is a distortion",
          "rig.yaml:18:12: cameras.d.floor: must not have a homography where the lens bends "
          "straight lines; give marks"));
}

TEST(RigFields, AllowsAFisheyeWhatItsCornersDo) {
  const auto fisheye = [](const char* size, int fov_deg) {
    return faults("cameras: {a: {size_px: " + std::string(size) +
                  ", fov_deg: " + std::to_string(fov_deg) +
                  ", at_m: [0, 0, 1], distortion: {kind: equidistant, k1: 0.001}}}");
  };
  const std::pair<const char*, int> widest[] = {
      {"[320, 240]", 289}, {"[240, 320]", 217}, {"[300, 300]", 255}};
  for (const auto& [size, fov_deg] : widest) {
    EXPECT_THAT(fisheye(size, fov_deg), ElementsAre()) << size;
    EXPECT_THAT(fisheye(size, fov_deg + 1),
                ElementsAre(HasSubstr("fov_deg: must be from 1 to " + std::to_string(fov_deg) +
                                      ", got " + std::to_string(fov_deg + 1))));
  }
}

TEST(RigFields, ACameraSaysHowWellItIsKnown) {
  const auto rig = read_settings_text<Rig>(
      "cameras:\n"
      "  plain: {fov_deg: 80, at_m: [0, 0, 1]}\n"
      "  known:\n"
      "    {fov_deg: 80, at_m: [0, 0, 1], clock_offset_s: -0.003,\n"
      "     sigma: {rotation_deg: [0.1, 0.2, 0.3], position_m: 0.002, focal_percent: 0.1,\n"
      "             centre_px: 0.7, clock_s: 0.001}}\n",
      "rig.yaml");
  const RigCamera& plain = rig.cameras.at("plain");
  EXPECT_EQ(plain.clock_offset_s, 0);
  EXPECT_EQ(plain.sigma.rotation_rad, Vec3::Constant(deg_to_rad(1)));
  EXPECT_EQ(plain.sigma.position_m, Vec3::Constant(0.01));
  EXPECT_EQ(plain.sigma.focal_ratio, 0.005);
  EXPECT_EQ(plain.sigma.centre_px, 2);
  EXPECT_EQ(plain.sigma.clock_s, 0.01);
  const auto back = read_settings_text<Rig>(write_settings(rig), "rig.yaml");
  for (const Rig& one : {rig, back}) {
    const RigCamera& known = one.cameras.at("known");
    EXPECT_EQ(known.clock_offset_s, -0.003);
    EXPECT_EQ(known.sigma.rotation_rad, Vec3(deg_to_rad(0.1), deg_to_rad(0.2), deg_to_rad(0.3)));
    EXPECT_EQ(known.sigma.position_m, Vec3::Constant(0.002));
    EXPECT_EQ(known.sigma.focal_ratio, 0.1 / 100);
    EXPECT_EQ(known.sigma.centre_px, 0.7);
    EXPECT_EQ(known.sigma.clock_s, 0.001);
  }
  EXPECT_EQ(write_settings(back), write_settings(rig));
}

TEST(RigFields, RefusesSigmasThatAreNone) {
  EXPECT_THAT(
      faults("cameras:\n"
             "  a: {fov_deg: 80, at_m: [0, 0, 1], clock_offset_s: 20,\n"
             "      sigma: {rotation_deg: -1, position_m: [1, 2], focal_percent: 1, focal_ratio: 1,"
             " centre: 2}}\n"),
      ElementsAre("rig.yaml:2:53: cameras.a.clock_offset_s: must be from -10 to 10, got 20",
                  "rig.yaml:3:29: cameras.a.sigma.rotation_deg: must be from 0 to 180, got -1",
                  "rig.yaml:3:45: cameras.a.sigma.position_m: must be a list of 3 numbers, got 2",
                  HasSubstr("cameras.a.sigma.focal_ratio: given twice; focal_percent says it "
                            "already"),
                  HasSubstr("cameras.a.sigma.centre: unknown key; did you mean centre_px?")));
}

// Two pinholes of 11 parameters each, with the lines of their rows from the fourth on.
std::string calibrated_text(const std::function<void(std::vector<CovarianceText>&)>& change) {
  std::vector<CovarianceText> rows;
  for (const char* camera : {"a", "b"}) {
    for (const char* parameter :
         {"rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "position_x_m", "position_y_m",
          "position_z_m", "fx_px", "fy_px", "cx_px", "cy_px", "clock_s"}) {
      rows.push_back({std::string(camera) + "." + parameter, std::vector<double>(22, 0.25)});
      rows.back().row[rows.size() - 1] = 1;
    }
  }
  change(rows);
  std::string text =
      "cameras:\n"
      "  a: {fov_deg: 80, at_m: [0, 0, 1]}\n"
      "  b: {fov_deg: 80, at_m: [0, 0, 1]}\n"
      "covariance:\n";
  for (const CovarianceText& row : rows) {
    text += "  - {parameter: " + row.parameter + ", row: [";
    for (const double number : row.row) {
      text += std::to_string(number) + ", ";
    }
    text += "]}\n";
  }
  return text;
}

TEST(RigFields, CamerasAreKnownTogether) {
  const auto rig = read_settings_text<Rig>(calibrated_text([](auto& rows) {
                                             rows[2].row[12] = -0.5;
                                             rows[12].row[2] = -0.5;
                                           }),
                                           "rig.yaml");
  ASSERT_TRUE(rig.covariance);
  EXPECT_EQ(rig.covariance->parameters[12], "b.rotation_y_rad");
  EXPECT_EQ(rig.covariance->covariance(2, 12), -0.5);
  EXPECT_EQ(rig.covariance->covariance(12, 2), -0.5);
  EXPECT_EQ(rig.covariance->covariance(2, 11), 0.25);

  const std::string text = write_settings(rig);
  const auto back = read_settings_text<Rig>(text, "rig.yaml");
  ASSERT_TRUE(back.covariance);
  EXPECT_EQ(back.covariance->parameters, rig.covariance->parameters);
  EXPECT_EQ(back.covariance->covariance, rig.covariance->covariance) << "to the bit";
  EXPECT_EQ(write_settings(back), text);
  EXPECT_FALSE(read_settings_text<Rig>(text, "rig.yaml", {"covariance=null"}).covariance);

  // How its cameras sit may be told alone.
  Rig mountings = rig;
  const std::vector<Eigen::Index> rows{0, 1, 2, 3, 4, 5, 11, 12, 13, 14, 15, 16};
  mountings.covariance->covariance = rig.covariance->covariance(rows, rows).eval();
  mountings.covariance->parameters.clear();
  for (const Eigen::Index row : rows) {
    mountings.covariance->parameters.push_back(
        rig.covariance->parameters[static_cast<std::size_t>(row)]);
  }
  const Rig told = read_settings_text<Rig>(write_settings(mountings), "rig.yaml");
  EXPECT_EQ(told.covariance->parameters, mountings.covariance->parameters);
  EXPECT_THAT(rig.doubts, IsEmpty());
  EXPECT_THAT(write_settings(rig), Not(HasSubstr("doubts")));
}

TEST(RigFields, SaysWhyItsCalibrationIsNotToBeTrusted) {
  auto rig = read_settings_text<Rig>(calibrated_text([](auto&) {}), "rig.yaml");
  rig.doubts = {"ahead: its lens is another one", "too few points: 7"};
  EXPECT_EQ(read_settings_text<Rig>(write_settings(rig), "rig.yaml").doubts, rig.doubts);
  EXPECT_FALSE(read_settings_text<Rig>(kRig, "rig.yaml").covariance);
  EXPECT_THAT(write_settings(read_settings_text<Rig>(kRig, "rig.yaml")),
              Not(HasSubstr("covariance")));
}

TEST(RigFields, RefusesWhatIsNoJointCovariance) {
  const auto faults_of = [](const auto& change) { return faults(calibrated_text(change)); };
  EXPECT_THAT(faults_of([](auto& rows) { rows[0].parameter = "c.rotation_x_rad"; }),
              ElementsAre("rig.yaml:5:17: covariance[0].parameter: must be of a camera of the rig, "
                          "as CAMERA.rotation_x_rad, got c.rotation_x_rad"));
  EXPECT_THAT(faults_of([](auto& rows) { std::swap(rows[3], rows[4]); }),
              ElementsAre("rig.yaml:8:17: covariance[3].parameter: must be a.position_x_m, got "
                          "a.position_y_m"));
  EXPECT_THAT(faults_of([](auto& rows) {
                const auto once = rows;
                rows.insert(rows.begin() + 11, once.begin(), once.begin() + 11);
              }),
              ElementsAre(HasSubstr("rig.yaml:16:17: covariance[11].parameter: must not be of a "
                                    "camera that had its rows before")));
  EXPECT_THAT(faults_of([](auto& rows) { rows.pop_back(); }),
              ElementsAre("rig.yaml:5:3: covariance: must go on with a row of b.clock_s"));
  EXPECT_THAT(faults_of([](auto& rows) { rows[7].row.pop_back(); }),
              ElementsAre("rig.yaml:12:31: covariance[7].row: must have a number for each of the "
                          "22 rows, got 21"));
  EXPECT_THAT(faults_of([](auto& rows) { rows[5].row[1] = 0.5; }),
              ElementsAre("rig.yaml:10:38: covariance[5].row: must say of a.rotation_y_rad what "
                          "the row of a.position_z_m says of it: 0.5 is not 0.25"));
  const auto semi_definite = ElementsAre(
      "rig.yaml:5:3: covariance: must be positive semi-definite, as every covariance is");
  EXPECT_THAT(faults_of([](auto& rows) {
                rows[2].row[12] = 1.5;
                rows[12].row[2] = 1.5;
              }),
              semi_definite);
  EXPECT_THAT(faults_of([](auto& rows) { rows[4].row[4] = -1; }), semi_definite);
  EXPECT_THAT(faults_of([](auto& rows) { rows[4].row[4] = 0; }), semi_definite)
      << "what is exact goes with nothing";
  EXPECT_THAT(faults("cameras: {a: {fov_deg: 80, at_m: [0, 0, 1]}}\ncovariance: 3\n"),
              ElementsAre("rig.yaml:2:13: covariance: must be a list, got 3"));
}

}  // namespace
}  // namespace panoptes

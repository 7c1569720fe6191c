// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/rig_errors.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/camera/mounting.h"

namespace panoptes::sim {
namespace {

using testing::HasSubstr;

constexpr int kDraws = 1000;
const RigErrors kNone{{0, 0}, {0, 0, 0}, {0}};

Rig one_camera(const Distortion& distortion = NoDistortion{}) {
  Rig rig;
  RigCamera& camera = rig.cameras["front"];
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.intrinsics.distortion = distortion;
  camera.T_body_camera = mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28));
  return rig;
}

RigCamera drawn(const RigErrors& errors, int seed, const Rig& rig = one_camera()) {
  return true_rig(errors, rig, Rng(static_cast<std::uint64_t>(seed))).cameras.at("front");
}

// Relative, of a variance from so many draws of so many numbers each.
double three_sigma(int numbers) { return 3 * std::sqrt(2.0 / (numbers * kDraws)); }

TEST(RigErrors, TheTrueRigIsTheNominalOneWithoutThem) {
  const Rig rig = one_camera();
  EXPECT_EQ(write_settings(true_rig(kNone, rig, Rng(1))), write_settings(rig));
}

TEST(RigErrors, TurnAndMoveEveryAxisByItsSigma) {
  const Pose3 nominal = one_camera().cameras.at("front").T_body_camera;
  RigErrors errors;
  errors.mounting.sigma_deg = 1;
  errors.mounting.sigma_m = 0.005;
  double turn2 = 0;
  double shift2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Pose3 pose = drawn(errors, i).T_body_camera;
    turn2 += std::pow(rad_to_deg(pose.rotation.angularDistance(nominal.rotation)), 2);
    shift2 += (pose.translation - nominal.translation).squaredNorm();
  }
  EXPECT_NEAR(turn2 / kDraws / 3, 1, three_sigma(3));
  EXPECT_NEAR(shift2 / kDraws / 3 / (0.005 * 0.005), 1, three_sigma(3));
}

TEST(RigErrors, AreAsFarOffAsTheRigSaysTheyAreKnown) {
  Rig rig = one_camera();
  rig.cameras["side"] = rig.cameras["front"];
  for (auto& [name, camera] : rig.cameras) {
    camera.sigma.rotation_rad = {0.001, 0.002, 0.003};
    camera.sigma.position_m = {0.004, 0.005, 0.01};
  }
  RigErrors errors;
  errors.mounting.as_known = true;
  const auto height_off = [&](int seed, const char* camera) {
    return true_rig(errors, rig, Rng(static_cast<std::uint64_t>(seed)))
               .cameras.at(camera)
               .T_body_camera.translation.z() -
           rig.cameras.at(camera).T_body_camera.translation.z();
  };
  double height2 = 0;
  double pitch2 = 0;
  double product = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Pose3 pose = drawn(errors, i, rig).T_body_camera;
    pitch2 +=
        std::pow(mounting_offset(rig.cameras["front"].T_body_camera, pose).rotation_rad.y(), 2);
    height2 += std::pow(height_off(i, "front"), 2);
    product += height_off(i, "front") * height_off(i, "side");
  }
  EXPECT_NEAR(pitch2 / kDraws / (0.002 * 0.002), 1, three_sigma(1));
  EXPECT_NEAR(height2 / kDraws / (0.01 * 0.01), 1, three_sigma(1));
  EXPECT_LT(std::abs(product / height2), 0.15) << "nothing says that they go together";

  rig.covariance =
      JointCovariance{{"front.position_z_m", "side.position_z_m"}, 1e-4 * Eigen::Matrix2d::Ones()};
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(height_off(i, "front"), height_off(i, "side"), 1e-9) << "now it does";
    EXPECT_NE(height_off(i, "front"), 0);
  }
}

TEST(RigErrors, AreDrawnByOneRuleAlone) {
  const auto read = [](const std::string& text) {
    return read_settings_text<MountingError>(text, "error", {});
  };
  EXPECT_TRUE(read("{as_known: true}").as_known);
  EXPECT_TRUE(read(write_settings(read("{as_known: true}"))).as_known);
  EXPECT_THROW(read("{as_known: true, sigma_deg: 1}"), ConfigError);
}

TEST(RigErrors, LensesAndClocksAreOffByTheirSigma) {
  const Intrinsics nominal = one_camera().cameras.at("front").intrinsics;
  RigErrors errors;
  errors.lens = {0.2, 1, 0.01, {}};
  errors.clock.sigma_s = 0.005;
  double focal2 = 0;
  double centre2 = 0;
  double distortion2 = 0;
  double clock2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const RigCamera camera = drawn(errors, i);
    const Intrinsics& lens = camera.intrinsics;
    constexpr double kRoundoff = 1e-12;
    EXPECT_NEAR(lens.fx_px / nominal.fx_px, lens.fy_px / nominal.fy_px, kRoundoff);
    focal2 += std::pow(100 * (lens.fx_px / nominal.fx_px - 1), 2);
    centre2 += std::pow(lens.cx_px - nominal.cx_px, 2) + std::pow(lens.cy_px - nominal.cy_px, 2);
    distortion2 += std::pow(std::get<BrownConrady>(lens.distortion).k1, 2);
    clock2 += std::pow(camera.clock_offset_s, 2);
  }
  EXPECT_NEAR(focal2 / kDraws / (0.2 * 0.2), 1, three_sigma(1));
  EXPECT_NEAR(centre2 / kDraws / 2, 1, three_sigma(2));
  EXPECT_NEAR(distortion2 / kDraws / (0.01 * 0.01), 1, three_sigma(1));
  EXPECT_NEAR(clock2 / kDraws / (0.005 * 0.005), 1, three_sigma(1));
}

TEST(RigErrors, AreWhatAGoodCalibrationLeavesWhereNothingIsSaid) {
  const RigCamera nominal = one_camera().cameras.at("front");
  double turn2 = 0;
  double shift2 = 0;
  double focal2 = 0;
  double centre2 = 0;
  double distortion2 = 0;
  double clock2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const RigCamera camera = drawn({}, i);
    const Pose3& pose = camera.T_body_camera;
    const Intrinsics& lens = camera.intrinsics;
    turn2 += std::pow(rad_to_deg(pose.rotation.angularDistance(nominal.T_body_camera.rotation)), 2);
    shift2 += (pose.translation - nominal.T_body_camera.translation).squaredNorm();
    focal2 += std::pow(100 * (lens.fx_px / nominal.intrinsics.fx_px - 1), 2);
    centre2 += std::pow(lens.cx_px - nominal.intrinsics.cx_px, 2);
    distortion2 += std::pow(std::get<BrownConrady>(lens.distortion).k1, 2);
    clock2 += std::pow(camera.clock_offset_s, 2);
  }
  EXPECT_NEAR(turn2 / kDraws / 3 / (0.2 * 0.2), 1, three_sigma(3));
  EXPECT_NEAR(shift2 / kDraws / 3 / (0.003 * 0.003), 1, three_sigma(3));
  EXPECT_NEAR(focal2 / kDraws / (0.2 * 0.2), 1, three_sigma(1));
  EXPECT_NEAR(centre2 / kDraws, 1, three_sigma(1));
  EXPECT_NEAR(distortion2 / kDraws / (0.0005 * 0.0005), 1, three_sigma(1));
  EXPECT_NEAR(clock2 / kDraws / (0.005 * 0.005), 1, three_sigma(1));
}

TEST(RigErrors, OfOneKindAreDrawnWhateverTheOthersAre) {
  RigErrors mounting = kNone;
  mounting.mounting.sigma_deg = 1;
  RigErrors all = mounting;
  all.lens = {0.2, 1, 0.01, {}};
  all.clock.sigma_s = 0.005;
  RigErrors others = all;
  others.mounting = {0, 0, {}};
  EXPECT_EQ(drawn(all, 4).T_body_camera.rotation.coeffs(),
            drawn(mounting, 4).T_body_camera.rotation.coeffs());
  EXPECT_EQ(drawn(all, 4).intrinsics.fx_px, drawn(others, 4).intrinsics.fx_px);
  EXPECT_EQ(drawn(all, 4).clock_offset_s, drawn(others, 4).clock_offset_s);
}

TEST(RigErrors, GivenExactlyTakeTheDrawsPlace) {
  RigErrors errors;
  errors.mounting.sigma_deg = 1;
  errors.mounting.sigma_m = 0.01;
  errors.mounting.exactly["front"].rotation_rad.z() = deg_to_rad(1);
  errors.lens = {0.2, 1, 0.01, {}};
  errors.lens.exactly["front"] = {1, {1, -2}, 0.02};
  errors.clock = {0.01, {{"front", 0.004}}};
  const RigCamera nominal = one_camera().cameras.at("front");
  const RigCamera camera = drawn(errors, 1);
  const MountingOffset off = mounting_offset(nominal.T_body_camera, camera.T_body_camera);
  constexpr double kRoundoff = 1e-12;
  EXPECT_LT((off.rotation_rad - Vec3(0, 0, deg_to_rad(1))).norm(), kRoundoff);
  EXPECT_EQ(off.shift_m, Vec3(0, 0, 0));
  EXPECT_EQ(camera.intrinsics.fx_px, nominal.intrinsics.fx_px * 1.01);
  EXPECT_EQ(camera.intrinsics.fy_px, nominal.intrinsics.fy_px * 1.01);
  EXPECT_EQ(camera.intrinsics.cx_px, nominal.intrinsics.cx_px + 1);
  EXPECT_EQ(camera.intrinsics.cy_px, nominal.intrinsics.cy_px - 2);
  EXPECT_EQ(std::get<BrownConrady>(camera.intrinsics.distortion).k1, 0.02);
  EXPECT_EQ(camera.clock_offset_s, 0.004);
}

TEST(RigErrors, DistortionIsOfTheLensThatThereIs) {
  RigErrors errors;
  errors.lens.exactly["front"].distortion = 0.01;
  const Rig brown = one_camera(BrownConrady{-0.1, 0.01, 0, 0, 0});
  EXPECT_EQ(std::get<BrownConrady>(drawn(errors, 1, brown).intrinsics.distortion).k1, -0.1 + 0.01);
  EXPECT_EQ(std::get<BrownConrady>(drawn(errors, 1, brown).intrinsics.distortion).k2, 0.01);
  const Rig fisheye = one_camera(Equidistant{0.02, 0, 0, 0});
  EXPECT_EQ(std::get<Equidistant>(drawn(errors, 1, fisheye).intrinsics.distortion).k1, 0.02 + 0.01);
}

TEST(RigErrors, ACalibratedClockIsOffByItsErrorBesides) {
  Rig rig = one_camera();
  rig.cameras["front"].clock_offset_s = 0.02;
  RigErrors errors;
  errors.clock.exactly["front"] = -0.005;
  EXPECT_EQ(drawn(errors, 1, rig).clock_offset_s, 0.02 - 0.005);
}

TEST(RigErrors, OfCamerasThatTheRigHasNotAreRefused) {
  RigErrors errors;
  errors.mounting.exactly["frnt"];
  errors.lens.exactly["side"];
  errors.lens.exactly["front"].distortion = -0.9;
  errors.clock.exactly["fronts"] = 0.1;
  const std::vector<KeyFault> faults = rig_error_faults(errors, one_camera());
  ASSERT_EQ(faults.size(), 4U);
  EXPECT_EQ(faults[0].key, "mounting_error.exactly.frnt");
  EXPECT_EQ(faults[0].what, "the rig has no camera frnt; did you mean front?");
  EXPECT_EQ(faults[1].key, "lens_error.exactly.side");
  EXPECT_EQ(faults[1].what, "the rig has no camera side; name one of the rig's");
  EXPECT_EQ(faults[2].key, "clock_error.exactly.fronts");
  EXPECT_EQ(faults[3].key, "lens_error.exactly.front");
  EXPECT_THAT(faults[3].what, HasSubstr("bends back inside the picture"));
}

TEST(RigErrors, ALensThatTheSeedMakesImpossibleIsRefusedWithItsErrors) {
  RigErrors errors = kNone;
  errors.lens.sigma_distortion = 0.2;
  int refused = 0;
  for (int seed = 0; seed < 20; ++seed) {
    try {
      drawn(errors, seed);
    } catch (const ConfigError& error) {
      ++refused;
      EXPECT_THAT(error.what(), HasSubstr("platform.lens_error: the camera front with its centre "
                                          "off by (0.0, 0.0) px and its distortion by -"));
    }
  }
  EXPECT_GT(refused, 0);
}

TEST(RigErrors, AreReadAsTheyAreWritten) {
  const auto mounting = read_settings_text<MountingError>(
      "{sigma_deg: 0.2, sigma_m: 0.003, exactly: {front: {yaw_deg: 1}}}", "m.yaml");
  EXPECT_EQ(mounting.exactly.at("front").rotation_rad.z(), deg_to_rad(1));
  const auto lens = read_settings_text<LensError>(
      "{sigma_focal_percent: 0.2, sigma_centre_px: 1, sigma_distortion: 0.005, exactly: {front: "
      "{focal_percent: 1, centre_px: [1, -2], distortion: 0.01}}}",
      "m.yaml");
  EXPECT_EQ(lens.exactly.at("front").centre_px, Vec2(1, -2));
  const auto clock =
      read_settings_text<ClockError>("{sigma_s: 0.005, exactly: {back: 0.01}}", "m.yaml");
  EXPECT_EQ(clock.exactly.at("back"), 0.01);
  const auto back = read_settings_text<MountingError>(write_settings(mounting), "m.yaml");
  EXPECT_EQ(back.exactly.at("front").rotation_rad, mounting.exactly.at("front").rotation_rad);
  EXPECT_EQ(write_settings(read_settings_text<LensError>(write_settings(lens), "m.yaml")),
            write_settings(lens));
}

}  // namespace
}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/attitude.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace panoptes::sim {
namespace {

constexpr double kRoundoff = 1e-12;

struct Holder {
  AttitudeOptions attitude;
};
void bind(Fields& f, Holder& o) { f.choice("attitude", o.attitude); }

AttitudeOptions read(const std::string& text) {
  return read_settings_text<Holder>("attitude: " + text + "\n", "a.yaml").attitude;
}

TEST(Attitude, IsLevelUnlessToldOtherwise) {
  const Attitude attitude(AttitudeOptions{}, Body{});
  EXPECT_TRUE(attitude.level());
  const Pose3 T = attitude.T_level_body(attitude.tilt(time_at(3), 0));
  EXPECT_EQ(T.translation.norm(), 0);
  EXPECT_EQ(T.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0);
}

TEST(Attitude, SumsItsWaves) {
  WavesAttitude waves;
  waves.pitch = {{0.1, 2, 0}, {0.05, 0.5, std::numbers::pi / 2}};
  waves.roll = {{0.02, 1, 0}};
  waves.heave = {{0.03, 1, 0}};
  const Attitude attitude(waves, Body{});
  EXPECT_FALSE(attitude.level());
  const Tilt tilt = attitude.tilt(time_at(0.125), 0.01);
  EXPECT_NEAR(tilt.pitch_rad, 0.01 + 0.1 + 0.05 * std::cos(std::numbers::pi / 8), kRoundoff);
  EXPECT_NEAR(tilt.roll_rad, 0.02 * std::sin(std::numbers::pi / 4), kRoundoff);
  EXPECT_NEAR(tilt.heave_m, 0.03 * std::sin(std::numbers::pi / 4), kRoundoff);
}

TEST(Attitude, TurnsTheBodyAboutItsAxle) {
  const Body body;
  const Attitude attitude(AttitudeOptions{}, body);
  const Vec3 axle(0, 0, body.wheel_radius_m);
  const Pose3 nod = attitude.T_level_body({0.2, 0, 0});
  EXPECT_NEAR((nod * axle - axle).norm(), 0, kRoundoff);
  EXPECT_LT((nod * Vec3(1, 0, body.wheel_radius_m)).z(), body.wheel_radius_m) << "nose down";
  const Pose3 list = attitude.T_level_body({0, 0.2, 0.1});
  EXPECT_NEAR((list * axle - axle - Vec3(0, 0, 0.1)).norm(), 0, kRoundoff);
  EXPECT_LT((list * Vec3(0, -1, 0)).z(), (list * Vec3(0, 1, 0)).z()) << "right side down";
}

TEST(Attitude, LeansIntoItsAcceleration) {
  WavesAttitude leaning;
  leaning.lean_rad_per_mps2 = 0.1;
  leaning.lean_time_s = 0.2;
  Attitude attitude(leaning, Body{});
  for (int i = 0; i < 24; ++i) {
    attitude.step(0.5, 1.0 / 120);
  }
  EXPECT_NEAR(attitude.lean_rad(), 0.05 * (1 - std::exp(-1)), kRoundoff);
  for (int i = 0; i < 1200; ++i) {
    attitude.step(0, 1.0 / 120);
  }
  EXPECT_NEAR(attitude.lean_rad(), 0, kRoundoff);
}

TEST(AttitudeOptions, AreReadByName) {
  EXPECT_TRUE(std::holds_alternative<BalancingAttitude>(read("balancing")));
  EXPECT_TRUE(std::holds_alternative<HandHeldAttitude>(read("hand_held")));
  EXPECT_TRUE(std::holds_alternative<LevelAttitude>(read("level")));
  const auto waves = std::get<WavesAttitude>(read(
      "{kind: waves, pitch: [{amplitude_deg: 2, frequency_hz: 0.5}], lean_rad_per_mps2: 0.1}"));
  ASSERT_EQ(waves.pitch.size(), 1U);
  EXPECT_EQ(waves.pitch[0].amplitude_rad, deg_to_rad(2));
  EXPECT_FALSE(Attitude(BalancingAttitude{}, Body{}).level());
  EXPECT_FALSE(Attitude(HandHeldAttitude{}, Body{}).level());
}

}  // namespace
}  // namespace panoptes::sim

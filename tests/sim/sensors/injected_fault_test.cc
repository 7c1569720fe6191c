// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/injected_fault.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace panoptes::sim {
namespace {

using testing::ElementsAre;

std::vector<std::string> faults(const std::string& text) {
  try {
    read_settings_text<InjectedFault>(text, "m.yaml");
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

TEST(InjectedFault, AKnockLastsAndHidesNoOther) {
  const auto knock = read_settings_text<InjectedFault>(
      "{camera: front, fault: knock, at_s: 2, yaw_deg: 1.5, x_m: 0.015}", "m.yaml");
  const auto freeze = read_settings_text<InjectedFault>(
      "{camera: front, fault: freeze, at_s: 1, for_s: 2}", "m.yaml");
  const std::vector<InjectedFault> all{knock, freeze};
  const Pose3 T = mounted_camera({0.1, 0, 0.7}, 0.2, 0);
  EXPECT_EQ(fault_at(all, "front", time_at(2.5)), CameraFaultKind::kFreeze);
  EXPECT_FALSE(fault_at(all, "front", time_at(9)).has_value());
  EXPECT_FALSE(is_knocked(all, "front", time_at(1.9)));
  EXPECT_FALSE(is_knocked(all, "back", time_at(9)));
  const Pose3 before = knocked(all, "front", time_at(1.9), T);
  EXPECT_EQ(before.rotation.coeffs(), T.rotation.coeffs());
  const MountingOffset off = mounting_offset(T, knocked(all, "front", time_at(9), T));
  constexpr double kRoundoff = 1e-12;
  EXPECT_LT((off.rotation_rad - Vec3(0, 0, deg_to_rad(1.5))).norm(), kRoundoff);
  EXPECT_LT((off.shift_m - Vec3(0.015, 0, 0)).norm(), kRoundoff);
  const std::string written = write_settings(knock);
  EXPECT_EQ(write_settings(read_settings_text<InjectedFault>(written, "m.yaml")), written);
}

TEST(InjectedFault, AKnockThatKnocksNothingOrEndsIsRefused) {
  EXPECT_THAT(faults("{camera: front, fault: knock, at_s: 2}"),
              ElementsAre("m.yaml:1:24: fault: must turn or shift the camera; give roll_deg, "
                          "pitch_deg, yaw_deg, x_m, y_m or z_m, got knock"));
  EXPECT_THAT(faults("{camera: front, fault: knock, at_s: 2, for_s: 3, yaw_deg: 1}"),
              ElementsAre("m.yaml:1:47: for_s: must not be given: what is knocked stays as it is; "
                          "to put it back, knock it back, got 3"));
  EXPECT_THAT(faults("{camera: front, fault: freeze, at_s: 2, yaw_deg: 1}"),
              ElementsAre(testing::HasSubstr("yaw_deg: unknown key")));
}

}  // namespace
}  // namespace panoptes::sim

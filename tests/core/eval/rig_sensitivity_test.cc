// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_sensitivity.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

Rig rig_with_floor_camera() {
  Rig rig;
  RigCamera& camera = rig.cameras["floor"];
  camera.rate_hz = 10;
  camera.roles = {"floor"};
  camera.floor.emplace().near_m = 0;
  camera.intrinsics = pinhole(320, 240, deg_to_rad(70));
  camera.T_body_camera = mounted_camera({0.2, 0, 0.6}, 0, deg_to_rad(40));
  return rig;
}

std::optional<ScoreSpread> spread_of(const RigSensitivityOptions& options, const std::string& key) {
  const Rig rig = rig_with_floor_camera();
  const auto spreads = rig_sensitivity(options, {}, rig, Body()).spreads;
  const auto names = named_scores(score_rig({}, rig, Body()));
  EXPECT_EQ(spreads.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].key == key) {
      return spreads[i];
    }
  }
  ADD_FAILURE() << "no score " << key;
  return std::nullopt;
}

double drawn(const std::string& key) {
  for (const NamedScore& score : named_scores(score_rig({}, rig_with_floor_camera(), Body()))) {
    if (score.key == key) {
      return *score.value;
    }
  }
  return 0;
}

TEST(RigSensitivity, OfARigThatIsMountedAsDrawnIsNone) {
  const auto spread = spread_of({0, 0, 5, 1}, "floor.mapped_m2");
  ASSERT_TRUE(spread);
  EXPECT_EQ(spread->low, drawn("floor.mapped_m2"));
  EXPECT_EQ(spread->high, drawn("floor.mapped_m2"));
}

TEST(RigSensitivity, GrowsWithHowFarCamerasAreOffAndHoldsWhatIsDrawn) {
  const auto little = spread_of({deg_to_rad(0.5), 0.002}, "blind.ahead_m");
  const auto much = spread_of({deg_to_rad(3), 0.02}, "blind.ahead_m");
  ASSERT_TRUE(little && much);
  EXPECT_LT(little->low, drawn("blind.ahead_m") + 0.01);
  EXPECT_GT(little->high, drawn("blind.ahead_m") - 0.01);
  EXPECT_GT(much->high - much->low, 2 * (little->high - little->low));
}

// The lower edge of a picture meets the floor at h / tan(tilt + half the field of view): a pitch of
// one sigma shifts it by h / sin^2 of that angle, and nine of ten lie within 1.64 sigmas.
TEST(RigSensitivity, IsThatOfTheLowerEdgeOfAPicture) {
  RigSensitivityOptions options{deg_to_rad(1), 0, 400, 3};
  const auto spread = spread_of(options, "blind.ahead_m");
  ASSERT_TRUE(spread);
  const double half_rad = std::atan(std::tan(deg_to_rad(35)) * 240 / 320);
  const double down_rad = deg_to_rad(40) + half_rad;
  const double by_rad = 0.6 / (std::sin(down_rad) * std::sin(down_rad));
  EXPECT_NEAR(spread->high - spread->low, 2 * 1.645 * deg_to_rad(1) * by_rad, 0.012);
}

TEST(RigSensitivity, HasTheSameDrawsAgain) {
  const auto once = spread_of({}, "floor.seen_m2");
  const auto again = spread_of({}, "floor.seen_m2");
  ASSERT_TRUE(once && again);
  EXPECT_EQ(once->low, again->low);
  EXPECT_EQ(once->high, again->high);
}

TEST(RigSensitivity, IsNoneOfWhatARigHasNot) { EXPECT_FALSE(spread_of({}, "loss.panorama")); }

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/loop_cameras.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "core/base/error.h"

namespace panoptes {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(LoopCameras, AreNamedByTheirRoles) {
  Rig rig;
  rig.cameras["F"].roles = {"floor"};
  EXPECT_THROW(loop_cameras(rig), ConfigError);
  rig.cameras["A"].roles = {"loop_front"};
  EXPECT_EQ(loop_cameras(rig).size(), 1U);
  rig.cameras["B"].roles = {"loop_back", "floor"};
  rig.cameras["B"].T_body_camera.translation = {-0.2, 0, 0.8};
  EXPECT_EQ(loop_cameras(rig)[1].T_body_camera.translation.x(), -0.2);
  rig.cameras["0"].roles = {"floor", "loop_right"};
  rig.cameras["C"].roles = {"loop_left"};
  std::vector<std::string> looks;
  std::vector<std::string> names;
  for (const LoopCamera& camera : loop_cameras(rig)) {
    looks.push_back(camera.looks);
    names.push_back(camera.name);
  }
  EXPECT_THAT(looks, ::testing::ElementsAre("front", "back", "left", "right"));
  EXPECT_THAT(names, ::testing::ElementsAre("A", "B", "C", "0"));
}

LoopCamera looking(double yaw_rad, double tilt_rad) {
  return {"eye", "eye", pinhole(320, 240, deg_to_rad(80)),
          mounted_camera({0, 0, 0.8}, yaw_rad, tilt_rad)};
}

std::vector<double> turns_deg(const std::vector<Facing>& all) {
  std::vector<double> turns;
  for (const Facing& facing : all) {
    turns.push_back(std::round(std::abs(rad_to_deg(facing.turn_rad))));
  }
  return turns;
}

TEST(Facings, OfOneCameraIsTheSameHeadingAlone) {
  const std::vector<Facing> all = facings({looking(0.3, 0)});
  EXPECT_THAT(turns_deg(all), ::testing::ElementsAre(0));
  EXPECT_THAT(all[0].pairs, ::testing::ElementsAre(CameraPair{0, 0}));
}

TEST(Facings, OfTwoThatLookApartAreTheSameAndTheOpposite) {
  for (const double yaw_rad : {0.0, kPi / 2}) {
    const std::vector<Facing> all = facings({looking(yaw_rad, 0), looking(yaw_rad + kPi, 0.02)});
    EXPECT_THAT(turns_deg(all), ::testing::ElementsAre(0, 180));
    EXPECT_THAT(all[1].pairs, ::testing::ElementsAre(CameraPair{0, 1}, CameraPair{1, 0}));
  }
}

TEST(Facings, OfFourCornersAreAllQuarters) {
  const LoopCameras corners{looking(kPi / 4, 0), looking(-3 * kPi / 4, 0), looking(3 * kPi / 4, 0),
                            looking(-kPi / 4, 0)};
  const std::vector<Facing> all = facings(corners);
  EXPECT_THAT(turns_deg(all), ::testing::ElementsAre(0, 180, 90, 90));
  for (const Facing& facing : all) {
    ASSERT_EQ(facing.pairs.size(), 4U);
    for (const CameraPair& pair : facing.pairs) {
      const Vec3 before = corners[pair.a].T_body_camera.rotation * Vec3::UnitZ();
      const Vec3 now = on_floor({0, 0, facing.turn_rad}).rotation *
                       (corners[pair.b].T_body_camera.rotation * Vec3::UnitZ());
      EXPECT_LT((before - now).norm(), 0.01);
    }
  }
}

TEST(Facings, OfACameraThatLooksUpAreAnyHeading) {
  const std::vector<Facing> all = facings({looking(0, -kPi / 2)});
  ASSERT_EQ(all.size(), 8U);
  EXPECT_EQ(all[0].pairs, (std::vector{CameraPair{0, 0, false}}));
  for (std::size_t k = 1; k < all.size(); ++k) {
    EXPECT_EQ(all[k].pairs, (std::vector{CameraPair{0, 0, true}}));
  }
  EXPECT_NEAR(std::abs(all[1].turn_rad), kPi, 1e-9);
}

}  // namespace
}  // namespace panoptes

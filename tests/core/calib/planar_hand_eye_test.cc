// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/planar_hand_eye.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/driven_camera.h"

namespace panoptes {
namespace {

using ::testing::HasSubstr;

constexpr double kMetre_m = 1.7;
/// The camera in a map of its own, which begins where it does.
std::vector<StampedCamera> path_of(const DrivenRose& drive, const RigCamera& camera,
                                   double noise_rad, double noise_m, Rng rng) {
  const Pose3 T_map_start = (on_floor(drive.T_start_body(0)) * camera.T_body_camera).inverse();
  std::vector<StampedCamera> path = driven_camera_path(drive, camera, T_map_start, kMetre_m);
  for (StampedCamera& at : path) {
    Pose3& T = at.T_map_camera;
    T.translation += noise_m * Vec3(rng.normal(), rng.normal(), rng.normal());
    T.rotation = T.rotation * turned_by(noise_rad * Vec3(rng.normal(), rng.normal(), rng.normal()));
  }
  return path;
}

RigCamera roughly_believed() {
  RigCamera camera = driven_camera();
  camera.T_body_camera = mounted_camera({0.3, 0.1, 0.65}, 0.2, -0.1);
  camera.clock_offset_s = 0;
  return camera;
}

PlanarHandEye found(const DrivenRose& drive, const std::vector<StampedCamera>& path) {
  return planar_hand_eye(
      path, [&drive](Time at) { return drive.wheels(at); }, roughly_believed());
}

TEST(PlanarHandEye, ExactPathsGiveAllButTheHeight) {
  const DrivenRose drive({}, Rng(1));
  const RigCamera truth = driven_camera();
  const PlanarHandEye eye = found(drive, path_of(drive, truth, 0, 0, Rng(2)));
  EXPECT_LT(eye.T_body_camera.rotation.angularDistance(truth.T_body_camera.rotation), 2e-3);
  EXPECT_NEAR(eye.T_body_camera.translation.x(), truth.T_body_camera.translation.x(), 2e-3);
  EXPECT_NEAR(eye.T_body_camera.translation.y(), truth.T_body_camera.translation.y(), 2e-3);
  EXPECT_EQ(eye.T_body_camera.translation.z(), 0.65) << "as it is believed";
  EXPECT_NEAR(eye.clock_offset_s, driven_camera().clock_offset_s, 2e-3);
  EXPECT_NEAR(eye.map_metre_m, kMetre_m, 0.01);
}

TEST(PlanarHandEye, LaysTheMapWhereTheBodyBegins) {
  const DrivenRose drive({}, Rng(1));
  const RigCamera truth = driven_camera();
  const auto path = path_of(drive, truth, 0, 0, Rng(2));
  const PlanarHandEye eye = found(drive, path);
  for (const std::size_t i : {std::size_t{0}, path.size() / 2}) {
    const Vec3 p_map = path[i].T_map_camera * Vec3(0.2, -0.1, 1);
    Vec3 p_start =
        on_floor(drive.T_start_body(i)) * (truth.T_body_camera * (kMetre_m * Vec3(0.2, -0.1, 1)));
    p_start.z() += 0.65 - truth.T_body_camera.translation.z();
    EXPECT_LT((eye.T_start_map * Vec3(eye.map_metre_m * p_map) - p_start).norm(), 0.02);
  }
}

TEST(PlanarHandEye, NoisyPathsGiveItWithinWhatItSays) {
  int outside = 0;
  constexpr int kRuns = 20;
  for (int seed = 0; seed < kRuns; ++seed) {
    RoseShape rose;
    rose.noise_m = 0.007;
    rose.turn_error = 0.01;
    const DrivenRose drive(rose, Rng(10 + seed));
    const RigCamera truth = driven_camera();
    const PlanarHandEye eye = found(drive, path_of(drive, truth, 5e-4, 5e-4, Rng(50 + seed)));
    const Vec3 off = mounting_offset(truth.T_body_camera, eye.T_body_camera).rotation_rad;
    EXPECT_LT(off.head<2>().norm(), 2e-3) << "roll and pitch are by the axis of all turns";
    outside += std::abs(off.z()) > 3 * eye.yaw_sigma_rad ? 1 : 0;
    EXPECT_LT(std::abs(off.z()), deg_to_rad(1.5));
  }
  EXPECT_LE(outside, 2);
}

TEST(PlanarHandEye, ADriveWithoutATurnIsRefused) {
  RoseShape straight;
  straight.turn_rad = 0;
  const DrivenRose drive(straight, Rng(1));
  try {
    found(drive, path_of(drive, driven_camera(), 1e-5, 1e-5, Rng(2)));
    FAIL() << "it knows how it is mounted";
  } catch (const HandEyeError& error) {
    EXPECT_THAT(error.what(), HasSubstr("drive a motion that turns"));
  }
}

TEST(PlanarHandEye, ATurnOnTheSpotLeavesYawPlaceAndMetreNearWhatIsBelieved) {
  RoseShape spin;
  spin.leg_m = 0;
  const DrivenRose drive(spin, Rng(1));
  const RigCamera truth = driven_camera();
  RigCamera believed = truth;
  believed.T_body_camera = displaced(truth.T_body_camera, {{0, 0, 0.15}, {0.02, 0, 0}});
  const PlanarHandEye eye = planar_hand_eye(
      path_of(drive, truth, 1e-5, 1e-5, Rng(2)), [&drive](Time at) { return drive.wheels(at); },
      believed);
  const Vec3 off = mounting_offset(truth.T_body_camera, eye.T_body_camera).rotation_rad;
  EXPECT_LT(off.head<2>().norm(), 2e-3) << "roll and pitch are by the axis of all turns";
  EXPECT_LT((eye.T_body_camera.translation - believed.T_body_camera.translation).norm(), 0.03);
  const double yaw_rad =
      mounting_offset(believed.T_body_camera, eye.T_body_camera).rotation_rad.z();
  EXPECT_LT(std::abs(yaw_rad), 0.1);
  EXPECT_GT(eye.yaw_sigma_rad, deg_to_rad(3));
  EXPECT_GT(eye.position_sigma_m, 0.03);
}

TEST(PlanarHandEye, WheelsOfAnotherDriveAreRefused) {
  const DrivenRose drive({}, Rng(1));
  RoseShape other;
  other.turn_rad = 0.3;
  other.leg_m = 0.9;
  const DrivenRose another(other, Rng(1));
  EXPECT_THROW(found(another, path_of(drive, driven_camera(), 0, 0, Rng(2))), HandEyeError);
}

}  // namespace
}  // namespace panoptes

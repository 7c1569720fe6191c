// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/tum.h"

#include <numbers>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using Tum = ScratchTest;
constexpr double kRoundoff = 1e-15;

TEST_F(Tum, ReadsBackWhatItWrote) {
  const auto path = folder_ / "t.tum";
  write_tum(path, {{time_at(0), on_floor({0, 0, 0})},
                   {time_at(0.1), on_floor({1.5, -2.25, std::numbers::pi})}});
  EXPECT_TRUE(read_file(path).starts_with("0 0 0 0 0 0 0 1\n0.1 1.5 -2.25 0 0 0 1 6.1"))
      << read_file(path);
  const auto poses = read_tum(path);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].stamp, time_at(0.1));
  EXPECT_EQ(poses[1].T_frame_body.translation, Vec3(1.5, -2.25, 0));
  EXPECT_NEAR(poses[1].T_frame_body.rotation.z(), 1, kRoundoff);
}

TEST(TumPose, StandsOnTheFloor) {
  constexpr double kRoundoff_rad = 1e-12;
  for (const double theta_rad : {-3.1, -1.0, 0.0, 0.5, std::numbers::pi}) {
    const Pose2 back = floor_pose({time_at(0), on_floor({1, -2, theta_rad})});
    EXPECT_EQ(back.position(), Vec2(1, -2));
    EXPECT_NEAR(wrap_angle(back.theta_rad - theta_rad), 0, kRoundoff_rad);
  }
  Pose3 nodding = on_floor({0, 0, 0.5});
  nodding.rotation = nodding.rotation * Eigen::AngleAxisd(0.1, Vec3::UnitY());
  EXPECT_NEAR(floor_pose({time_at(0), nodding}).theta_rad, 0.5, kRoundoff_rad);
}

TEST_F(Tum, SaysWhichLineIsNoPose) {
  const auto message = [&](const std::string& text) -> std::string {
    write_file(folder_ / "t.tum", text);
    try {
      read_tum(folder_ / "t.tum");
    } catch (const IoError& e) {
      return std::string(e.what()).substr((folder_ / "t.tum").string().size());
    }
    return "no error";
  };
  EXPECT_EQ(message("# t x y z qx qy qz qw\n1 2 3\n"),
            ":2: a pose is eight numbers, t x y z qx qy qz qw");
  EXPECT_EQ(message("1 2 3 4 0 0 0 1 9\n"), ":1: a pose is eight numbers, t x y z qx qy qz qw");
  EXPECT_EQ(message("1 2 3 4 0 0 0 0\n"), ":1: the quaternion has not length 1");
  EXPECT_EQ(message("1.5 2 3 4 0 0 0 1\n#\n1.5 2 3 4 0 0 0 1\n"),
            ":3: the stamp is not later than the one before, 1.5");
}

}  // namespace
}  // namespace panoptes

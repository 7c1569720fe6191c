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
}

}  // namespace
}  // namespace panoptes

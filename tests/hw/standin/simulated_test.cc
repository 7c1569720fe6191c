// SPDX-License-Identifier: BSD-3-Clause
// The controller around a simulated robot: its wheels, its bumpers, its pictures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hw/standin/controller.h"
#include "sim/simulated_robot.h"
#include "tests/sim/physics/rooms.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double kCount_m = 0.51e-3;
const double kCount_rad = 0.51 * find_model("p3dx-sh")->angle_rad;

sim::Surroundings room() {
  sim::Surroundings around;
  around.outlines = sim::walls(4);
  around.draw = [](const sim::View& view, const sim::RenderOutputs&, const sim::SceneState&) {
    sim::RenderedImage rendered;
    rendered.bgr =
        cv::Mat(view.intrinsics.height_px, view.intrinsics.width_px, CV_8UC3, cv::Scalar::all(120));
    return rendered;
  };
  return around;
}

Rig front_camera() {
  Rig rig;
  rig.cameras["front"].intrinsics = pinhole(16, 12, deg_to_rad(80));
  rig.cameras["front"].T_body_camera = mounted_camera({0.02, 0, 0.78}, 0, 0);
  return rig;
}

class SimulatedStandInTest : public testing::Test {
 protected:
  explicit SimulatedStandInTest(const Rig& rig = {}, double latency_s = 0) {
    sim::SimulatedOptions options;
    options.start = Pose2{2, 2, 0};
    options.trigger.latency_s = latency_s;
    robot_.emplace(options, room(), Body{}, rig, Rng(1));
    controller_.emplace(*robot_, Body{}, StandInOptions{},
                        [this](const Observation& seen) { seen_.push_back(seen); });
    for (const Bytes& frame : {command_frame(Command::kPulse), command_frame(Command::kOpen),
                               command_frame(Command::kClose), command_frame(Command::kOpen, 1),
                               command_frame(Command::kEnable, 1)}) {
      controller_->receive(controller_->now(), frame);
    }
    controller_->take_sent();
  }

  /// All reports of a while in which the client says the same again and again.
  std::vector<Sip> drive(int speed_mmps, int turn_degps, Duration during) {
    const Time end = controller_->now() + during;
    std::vector<Sip> reports;
    while (controller_->now() < end) {
      controller_->receive(controller_->now(), command_frame(Command::kVelocity, speed_mmps));
      controller_->receive(controller_->now(), command_frame(Command::kTurnVelocity, turn_degps));
      controller_->advance(std::min(end, controller_->now() + milliseconds(250)));
    }
    for (const Sent& sent : controller_->take_sent()) {
      if (const auto sip = read_sip(std::span(sent.bytes).subspan(3, sent.bytes.size() - 5))) {
        reports.push_back(*sip);
      }
    }
    return reports;
  }

  std::optional<sim::SimulatedRobot> robot_;
  std::optional<StandInController> controller_;
  std::vector<Observation> seen_;
};

TEST_F(SimulatedStandInTest, AWallPressesTheBumperInFrontAndHoldsTheWheels) {
  std::vector<Sip> reports = drive(300, 0, seconds(8));
  EXPECT_EQ(reports.front().front_bumpers, 0);
  const Sip held = reports.back();
  EXPECT_EQ(held.front_bumpers, 0b00100);
  EXPECT_EQ(held.rear_bumpers, 0);
  EXPECT_TRUE(held.left_stalled && held.right_stalled);
  EXPECT_NEAR(held.x, 1750, 15);  // where the robot's edge meets the wall; the wheels are not ideal
  ASSERT_EQ(robot_->truth()->contacts.size(), 1U);
  const Sip freed = drive(-200, 0, seconds(1)).back();
  EXPECT_EQ(freed.front_bumpers, 0);
  EXPECT_FALSE(freed.left_stalled);
  drive(0, 60, seconds(3));
  drive(0, 0, seconds(1));
  reports = drive(-300, 0, seconds(14));
  EXPECT_NE(reports.back().rear_bumpers, 0);
  EXPECT_EQ(reports.back().front_bumpers, 0);
}

class LateStandInTest : public SimulatedStandInTest {
 protected:
  LateStandInTest() : SimulatedStandInTest(front_camera(), 0.045) {}
};

TEST_F(LateStandInTest, PassesEveryFrameSetOnAndReportsTheWheelsOfTheInstant) {
  Time checked = controller_->now();
  for (int i = 0; i < 20; ++i) {
    const Sip sip = drive(500, 60, milliseconds(100)).back();
    const Odometry now = robot_->observe(robot_->now()).odometry;
    EXPECT_GT(controller_->now(), checked);
    checked = controller_->now();
    EXPECT_NEAR(sip.x * 1e-3, now.T_odom_body.x_m, kCount_m);
    EXPECT_NEAR(static_cast<std::int16_t>(sip.y) * 1e-3, now.T_odom_body.y_m, kCount_m);
    EXPECT_NEAR(
        wrap_angle(sip.theta * find_model("p3dx-sh")->angle_rad - now.T_odom_body.theta_rad), 0,
        kCount_rad);
  }
  EXPECT_EQ(seen_.size(), 30U);  // two seconds of 15 sets, but the last is not delivered yet
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    EXPECT_EQ(seen_[i].pictures.size(), 1U);
    EXPECT_GT(seen_[i].stamp, i == 0 ? Time(Duration(-1)) : seen_[i - 1].stamp);
  }
}

}  // namespace
}  // namespace panoptes::hw

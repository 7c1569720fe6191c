// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/localiser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/odometry/wheel_odometry.h"
#include "tests/core/nav/room_robot.h"

namespace panoptes {
namespace {

const WheelOdometry kWheels({}, Body());

std::vector<Vec2> no_contours(int /*keyframe*/) { return {}; }

// As the navigator steps it: with what is believed of what the cameras show.
Located step_accepted(Localiser& localiser, CameraHealth& health, const Observation& seen) {
  const CameraReports& cameras = health.check(seen);
  return localiser.step(health.accepted(seen), no_contours, {}, cameras);
}

TEST(Localiser, FirstObservationFoundsTheMap) {
  test::RoomRobot robot(1);
  Localiser localiser({}, kWheels, robot.rig(), Rng(1));
  const Located at = localiser.step(robot.look(0, {0.5, 0.2, 0.3}, {}), no_contours);
  EXPECT_EQ(at.keyframe_made, 0);
  EXPECT_EQ(at.T_map_body, Pose2{});
  EXPECT_EQ(localiser.keyframes().size(), 1U);
}

// What was calibrated together is off together: here both yaws, and a yaw and its lens' centre.
JointCovariance front_and_back_together(const LoopCameras& cameras) {
  JointCovariance joint;
  for (const LoopCamera& camera : cameras) {
    for (const std::string& parameter : joint_parameters(camera.name, camera.intrinsics)) {
      joint.parameters.push_back(parameter);
    }
  }
  const auto rows = static_cast<Eigen::Index>(joint.parameters.size());
  joint.covariance = 4 * Eigen::MatrixXd::Identity(rows, rows);
  const Eigen::Index second = rows / 2;
  joint.covariance(2, second + 2) = joint.covariance(second + 2, 2) = 3.96;
  joint.covariance(2, 8) = joint.covariance(8, 2) = -0.4;
  return joint;
}

// Sigmas are the cameras' own.
TEST(Localiser, BelievesCamerasTogetherThatWereCalibratedTogether) {
  test::RoomRobot robot(1);
  Rig rig = robot.rig();
  const Eigen::MatrixXd alone = Localiser({}, kWheels, rig, Rng(1)).rig_estimate().prior_covariance;
  rig.covariance = front_and_back_together(loop_cameras(rig));
  const Eigen::MatrixXd together =
      Localiser({}, kWheels, rig, Rng(1)).rig_estimate().prior_covariance;
  constexpr double kLoose = 1e-5;  // correlations are a millionth looser than told
  const int yaw = kRotation + 2;
  const int other_yaw = camera_state(1) + yaw;
  Eigen::MatrixXd expected = alone;
  expected(yaw, other_yaw) = expected(other_yaw, yaw) = 0.99 * alone(yaw, yaw);
  expected(yaw, kCentre) = expected(kCentre, yaw) =
      -0.1 * std::sqrt(alone(yaw, yaw) * alone(kCentre, kCentre));
  const Eigen::VectorXd by = alone.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((by.asDiagonal() * (together - expected) * by.asDiagonal()).cwiseAbs().maxCoeff(),
            kLoose);
}

TEST(Localiser, RemembersAPlaceAfterTheWayOrTheTurnThatOptionsSay) {
  test::RoomRobot robot(2);
  Localiser localiser({}, kWheels, robot.rig(), Rng(2));
  localiser.step(robot.look(0, {}, {}), no_contours);
  EXPECT_FALSE(localiser.step(robot.look(1, {0.2, 0, 0}, {0.2, 0, 0}), no_contours).keyframe_made);
  EXPECT_TRUE(localiser.step(robot.look(2, {0.26, 0, 0}, {0.26, 0, 0}), no_contours).keyframe_made);
  const double turn_rad = deg_to_rad(16);
  const Pose2 turned{0.26, 0, turn_rad};
  EXPECT_TRUE(localiser.step(robot.look(3, turned, turned), no_contours).keyframe_made);
}

TEST(Localiser, PicturesMendTheHeadingThatWheelsGetWrong) {
  // what feature matching leaves over a dozen keyframes is a tenth of a degree each at the worst
  constexpr double kHeadingLeft_deg = 1.2;
  test::RoomRobot robot(3);
  Localiser localiser({}, kWheels, robot.rig(), Rng(3));
  Pose2 T_scene_body{-1.5, -0.5, 0};
  const Pose2 T_scene_map = T_scene_body;
  Pose2 T_odom_body;
  localiser.step(robot.look(0, T_scene_body, T_odom_body), no_contours);
  Located at;
  for (int i = 1; i <= 12; ++i) {
    const Pose2 moved{0.25, 0, deg_to_rad(4)};
    T_scene_body = T_scene_body * moved;
    T_odom_body = T_odom_body * Pose2{0.25, 0, deg_to_rad(4.6)};  // wheels turn too far each time
    at = localiser.step(robot.look(i, T_scene_body, T_odom_body), no_contours);
  }
  const Pose2 error = (T_scene_map * at.T_map_body).inverse() * T_scene_body;
  const Pose2 wheels = (T_scene_map * T_odom_body).inverse() * T_scene_body;
  EXPECT_GT(std::abs(rad_to_deg(wheels.theta_rad)), 5 * kHeadingLeft_deg);
  EXPECT_LT(std::abs(rad_to_deg(error.theta_rad)), kHeadingLeft_deg);
}

TEST(Localiser, GoesOnByTheWheelsWithoutPictures) {
  test::RoomRobot robot(4);
  Localiser localiser({}, kWheels, robot.rig(), Rng(4));
  localiser.step(robot.look(0, {}, {}), no_contours);
  Observation blind;
  blind.stamp = time_at(1);
  blind.odometry.T_odom_body = {0.7, 0.1, 0.2};
  const Located at = localiser.step(blind, no_contours);
  EXPECT_FALSE(at.keyframe_made);
  EXPECT_EQ(at.T_map_body, blind.odometry.T_odom_body);
}

// A keyframe is of the instant of which the wheels tell: where it was by its pictures' stamps they
// would tell by their velocity alone, which lags behind a body that speeds up.
TEST(Localiser, RemembersHowLongBeforeAKeyframeItsPicturesWereTaken) {
  test::RoomRobot robot(6);
  Localiser localiser({}, kWheels, robot.rig(), Rng(6));
  localiser.step(robot.look(0, {}, {}), no_contours);
  // The cameras have seen it at 0.3 m, 50 ms before the set, when the wheels are 2 cm farther.
  const Pose2 then{0.3, 0, 0};
  const Twist2 twist{0.4, 0.2};
  const Pose2 now = then * exp_twist(twist, 0.05);
  Observation seen = robot.look(2, then, now);
  seen.odometry.twist_body = twist;
  seen.pictures.at("front").stamp = seen.pictures.at("back").stamp = time_at(1.95);
  const Located at = localiser.step(seen, no_contours);
  ASSERT_TRUE(at.keyframe_made);
  const Keyframe& keyframe = localiser.keyframes().back();
  EXPECT_EQ(keyframe.stamp, time_at(2));
  EXPECT_EQ(keyframe.T_wheels_body, now);
  EXPECT_EQ(at.T_odom_body, keyframe.T_odom_body);
  const PictureTimes& taken = localiser.place(1).taken;
  EXPECT_EQ(taken.twist_body.v_mps, twist.v_mps);
  EXPECT_EQ(taken.twist_body.w_radps, twist.w_radps);
  for (const double late_s : taken.late_s) {
    EXPECT_NEAR(late_s, -0.05, 1e-9);
  }
}

constexpr int kSpoiledFrom_s = 15;
constexpr double kWheelsTurn = 1.01;  // times too far, from then on: it is not learned before

// One and a half times round a square of 1.25 m, a keyframe a second: what is seen of it, drawn
// once, and where the robot truly is at the end.
struct Drive {
  test::RoomRobot robot{7};
  std::vector<Observation> seen;
  Pose2 T_map_body;

  Drive() {
    const Pose2 T_scene_map{-1.2, -1, 0};
    Pose2 T_odom_body;
    seen.push_back(robot.look(0, T_scene_map, T_odom_body));
    for (int step = 1; step <= 65; ++step) {
      const bool straight = (step - 1) / 5 % 2 == 0;
      const Pose2 moved = straight ? Pose2{0.26, 0, 0} : Pose2{0, 0, deg_to_rad(18)};
      T_map_body = T_map_body * moved;
      const double told = step < kSpoiledFrom_s ? 1 : kWheelsTurn;
      T_odom_body = T_odom_body * Pose2{moved.x_m, moved.y_m, told * moved.theta_rad};
      seen.push_back(robot.look(step, T_scene_map * T_map_body, T_odom_body));
    }
  }
};
// What the wheels get wrong from when the pictures are spoiled.
double wheels_off_since_rad() { return (kWheelsTurn - 1) * deg_to_rad(18) * 25; }

struct Round {
  double heading_off_rad = 0;  // at the end
  int closures = 0;
};
using Spoil = std::function<void(Observation&)>;

// Of a rig that is known exactly: what a lens may be wrong by, one camera alone could not tell from
// wheels that have changed.
Rig exact(Rig rig) {
  for (auto& [name, camera] : rig.cameras) {
    camera.sigma = {Vec3::Zero(), Vec3::Zero(), 0, 0, 0};
  }
  return rig;
}

Round drive_round(const LocaliserOptions& options, const Spoil& spoil) {
  static const Drive drive;
  Localiser localiser(options, kWheels, exact(drive.robot.rig()), Rng(7));
  CameraHealth health(drive.robot.rig());
  Round out;
  Located at;
  for (Observation seen : drive.seen) {
    if (spoil && seen.stamp >= time_at(kSpoiledFrom_s)) {
      spoil(seen);
    }
    at = step_accepted(localiser, health, seen);
    out.closures += static_cast<int>(std::count_if(at.closures.begin(), at.closures.end(),
                                                   [](const auto& c) { return c.accepted; }));
  }
  out.heading_off_rad = wrap_angle(at.T_map_body.theta_rad - drive.T_map_body.theta_rad);
  return out;
}

// The pictures of these cameras stay what they are now.
Spoil frozen(std::vector<std::string> cameras) {
  auto kept = std::make_shared<std::map<std::string, cv::Mat>>();
  return [cameras = std::move(cameras), kept](Observation& seen) {
    for (const std::string& camera : cameras) {
      cv::Mat& bgr = seen.pictures.at(camera).bgr;
      bgr = kept->try_emplace(camera, bgr).first->second;
    }
  };
}

// A cap is on: what is left is the sensor's noise about a grey.
Spoil covered(std::vector<std::string> cameras, double grey, double noise_grey) {
  auto rng = std::make_shared<cv::RNG>(5);
  return [=](Observation& seen) {
    for (const std::string& camera : cameras) {
      cv::Mat& bgr = seen.pictures.at(camera).bgr;
      bgr = cv::Mat(bgr.size(), bgr.type());
      rng->fill(bgr, cv::RNG::NORMAL, cv::Scalar::all(grey), cv::Scalar::all(noise_grey));
    }
  };
}

TEST(Localiser, BelievesNoCameraThatIsFrozenOrCovered) {
  constexpr double kHeadingLeft_rad = 0.01;  // what matching leaves
  const double wheels_rad = wheels_off_since_rad();
  ASSERT_GT(wheels_rad, 5 * kHeadingLeft_rad);

  const Round clear = drive_round({}, {});
  EXPECT_GE(clear.closures, 1);
  EXPECT_NEAR(clear.heading_off_rad, 0, kHeadingLeft_rad);

  const Round frozen_both = drive_round({}, frozen({"front", "back"}));
  EXPECT_EQ(frozen_both.closures, 0);
  EXPECT_NEAR(frozen_both.heading_off_rad, wheels_rad, kHeadingLeft_rad);

  const Round frozen_front = drive_round({}, frozen({"front"}));
  EXPECT_NEAR(frozen_front.heading_off_rad, 0, kHeadingLeft_rad);

  const Round noise = drive_round({}, covered({"front", "back"}, 128, 20));
  EXPECT_EQ(noise.closures, 0);
  EXPECT_NEAR(noise.heading_off_rad, wheels_rad, kHeadingLeft_rad);

  LocaliserOptions greys;  // which alone would say that all that is black is one place
  greys.loops.method = HistogramMethod{};
  greys.signature.method = SignatureMethod::kMosaic;
  const Round black = drive_round(greys, covered({"front", "back"}, 0, 0));
  EXPECT_EQ(black.closures, 0);
  EXPECT_NEAR(black.heading_off_rad, wheels_rad, kHeadingLeft_rad);
}

TEST(Localiser, BelievesACameraAgainThatThaws) {
  test::RoomRobot robot(8);
  Localiser localiser({}, kWheels, robot.rig(), Rng(8));
  CameraHealth health(robot.rig());
  const Observation first = robot.look(0, {}, {});
  step_accepted(localiser, health, first);
  const auto features = [&](const Observation& seen) {
    const Located at = step_accepted(localiser, health, seen);
    const PlaceFeatures& kept = localiser.place(at.keyframe_made.value()).features;
    return std::array{kept[0].px.size(), kept[1].px.size()};
  };
  Observation front_frozen = robot.look(2, {0.3, 0, 0}, {0.3, 0, 0});
  front_frozen.pictures.at("front").bgr = first.pictures.at("front").bgr;
  EXPECT_EQ(features(front_frozen)[0], 0U);
  const auto thawed = features(robot.look(3, {0.6, 0, 0}, {0.6, 0, 0}));
  EXPECT_GT(thawed[0], 0U);
  EXPECT_GT(thawed[1], 0U);
}

TEST(Localiser, MakesKeyframesWithoutACameraThatIsLost) {
  test::RoomRobot robot(9);
  for (const std::vector<std::string>& gone :
       {std::vector<std::string>{"front"}, {"back"}, {"front", "back"}}) {
    Localiser localiser({}, kWheels, robot.rig(), Rng(9));
    CameraHealth health(robot.rig());
    step_accepted(localiser, health, robot.look(0, {}, {}));
    int made = 0;
    for (int i = 1; i <= 4; ++i) {
      const Pose2 there{0.26 * i, 0, 0};
      Observation seen = robot.look(i, there, there);
      for (const std::string& camera : gone) {
        seen.pictures.erase(camera);
      }
      const Located at = step_accepted(localiser, health, seen);
      made += at.keyframe_made ? 1 : 0;
      EXPECT_NEAR((at.T_map_body.position() - there.position()).norm(), 0, 0.02);
    }
    EXPECT_EQ(made, 4) << gone.front();
    EXPECT_TRUE(localiser.place(4).partial);
    EXPECT_TRUE(localiser.place(4).featureless());
  }
}

// There and back and round, in a room.
Pose2 moved_at(int keyframe) {
  return keyframe % 12 < 4 ? Pose2{0.25, 0, 0.04} : Pose2{0, 0, deg_to_rad(15)};
}

void knock_and_learn(const std::optional<JointCovariance>& covariance) {
  constexpr int kKnockedAt = 56;
  test::RoomRobot robot(11);
  Rig believed = robot.rig();
  believed.covariance = covariance;
  Localiser localiser({}, kWheels, believed, Rng(11));
  Pose2 T_scene_body{-1, -0.5, 0};
  const Pose2 T_scene_map = T_scene_body;
  Pose2 T_odom_body;
  Located at = localiser.step(robot.look(0, T_scene_body, T_odom_body), no_contours);
  for (int k = 1; k <= 86; ++k) {
    if (k == kKnockedAt) {
      EXPECT_THAT(localiser.knocks(), testing::IsEmpty());
      robot.knock("front", Eigen::AngleAxisd(deg_to_rad(2), Vec3::UnitY()));
    }
    const Pose2 moved = moved_at(k);
    T_scene_body = T_scene_body * moved;
    T_odom_body = T_odom_body * moved;
    at = localiser.step(robot.look(k, T_scene_body, T_odom_body), no_contours);
  }
  ASSERT_EQ(localiser.knocks().size(), 1U);
  const KnockReport& knock = localiser.knocks().front();
  EXPECT_EQ(knock.camera, "front");
  EXPECT_NEAR(rad_to_deg(knock.turned_rad), 2, 0.5);
  EXPECT_LE(knock.since, time_at(kKnockedAt));
  EXPECT_THAT(told(knock), testing::HasSubstr("front: knocked by about"));
  const RigEstimate rig = localiser.rig_estimate();
  ASSERT_EQ(rig.believed[0].name, "front");
  const Eigen::MatrixXd mounted = rig.prior_covariance.topRows<6>();
  EXPECT_EQ(mounted.rightCols(mounted.cols() - 6).norm(), 0) << "it sits as nothing told";
  EXPECT_NEAR(rad_to_deg(rig.state[camera_state(0) + kRotation + 1]), 2, 0.3);
  // no bundle since is left as it looked at first
  const int pitch = camera_state(0) + kRotation + 1;
  for (const JointEdge& joint : localiser.graph().joints) {
    if (joint.first > kKnockedAt && joint.first < 75) {
      EXPECT_NEAR(rad_to_deg(joint.state[pitch]), rad_to_deg(rig.state[pitch]), 0.2);
    }
  }
  const Pose2 error = (T_scene_map * at.T_map_body).inverse() * T_scene_body;
  EXPECT_LT(error.position().norm(), 0.05);
  EXPECT_LT(std::abs(rad_to_deg(error.theta_rad)), 1);
}

TEST(Localiser, LearnsACameraAnewThatIsKnocked) { knock_and_learn(std::nullopt); }

TEST(Localiser, LearnsACameraAnewThatWasCalibratedTogetherWithAnother) {
  knock_and_learn(front_and_back_together(loop_cameras(test::RoomRobot(11).rig())));
}

TEST(Localiser, RefusesARigThatCannotRecognisePlaces) {
  test::RoomRobot robot(5);
  Rig rig = robot.rig();
  rig.cameras.erase("back");
  EXPECT_NO_THROW(Localiser({}, kWheels, rig, Rng(5)));  // one camera is enough
  rig.cameras.erase("front");
  EXPECT_THROW(Localiser({}, kWheels, rig, Rng(5)), ConfigError);
}

}  // namespace
}  // namespace panoptes

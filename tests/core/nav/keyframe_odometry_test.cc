// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/keyframe_odometry.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/motion/triangulation.h"
#include "core/nav/heading_edge.h"
#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

using testing::front_and_back;
using testing::SyntheticRoom;

constexpr double kNoise_px = 0.5;
constexpr double kWheels_m = 0.0005;
constexpr double kWheels_rad = 0.01;
constexpr double kWheelsTurn = 1.03;  // times too far

BundleFrame frame_of(const LoopCameras& cameras, const Pose2& moved, Rng& rng) {
  BundleFrame frame;
  frame.taken.late_s.assign(cameras.size(), 0);
  frame.T_before_here = {moved.x_m + rng.normal(0, kWheels_m), moved.y_m + rng.normal(0, kWheels_m),
                         kWheelsTurn * moved.theta_rad};
  frame.covariance = Vec3(kWheels_m, kWheels_m, kWheels_rad).cwiseAbs2().asDiagonal();
  return frame;
}

RigPriorState exact(const LoopCameras& cameras) {
  const RigState none = RigState::Zero(rig_states(cameras.size()));
  return {none, 1e12 * Eigen::MatrixXd::Identity(none.size(), none.size())};
}

// A robot that goes on, and what it says of that.
struct Walk {
  const LoopCameras& cameras;
  const SyntheticRoom& room;
  KeyframeOdometry odometry;
  Rng rng;
  Pose2 truth = {};
  int keyframes = 0;

  Walk(const LoopCameras& of, const SyntheticRoom& in, const BundleOdometryOptions& options,
       int seed)
      : cameras(of), room(in), odometry(options, {}, of), rng(seed) {}

  KeyframeOdometry::Motion go(const Pose2& step) {
    truth = truth * step;
    const PlaceFeatures seen =
        room.seen_from(cameras, truth, kNoise_px, 0.1, rng.fork(std::to_string(keyframes++)));
    return odometry.add(frame_of(cameras, step, rng), seen, exact(cameras));
  }
};

// Along a corridor of a few turns.
std::vector<Pose2> steps() {
  std::vector<Pose2> all;
  for (int k = 0; k < 23; ++k) {
    all.push_back(k % 8 < 5 ? Pose2{0.2, 0, 0.05} : Pose2{0, 0, -0.26});
  }
  return all;
}

TEST(KeyframeOdometry, JoinsKeyframesByBundlesThatFollowOneAnother) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1200, 3, Rng(1));
  const BundleOdometryOptions options;
  Walk walk(cameras, room, options, 2);
  walk.truth = {-1, -1, 0};
  Pose2 T_first_here;
  int closed = 0;
  int first_open = 0;
  const std::vector<Pose2> moved = steps();
  const Pose2 first = walk.truth;
  for (std::size_t k = 0; k <= moved.size(); ++k) {
    const Pose2 step = k == 0 ? Pose2{} : moved[k - 1];
    const auto motion = walk.go(step);
    T_first_here = T_first_here * motion.T_last_here;
    const int newest = static_cast<int>(k);
    if (motion.closed) {
      EXPECT_EQ(motion.closed->first, first_open);
      EXPECT_EQ(motion.closed->T_first_node.size(), static_cast<std::size_t>(newest - first_open));
      EXPECT_GE(newest - first_open, options.keyframes);
      EXPECT_GT(step.x_m, 0) << "amid a turn on the spot";
      EXPECT_TRUE(motion.open.empty());
      first_open = newest;
      ++closed;
    } else {
      ASSERT_EQ(motion.open.size(), static_cast<std::size_t>(newest - first_open));
      for (std::size_t i = 0; i < motion.open.size(); ++i) {
        EXPECT_EQ(motion.open[i].edge.from, first_open + static_cast<int>(i));
        EXPECT_EQ(motion.open[i].edge.to, first_open + static_cast<int>(i) + 1);
      }
    }
  }
  EXPECT_EQ(closed, 3);
  const Pose2 error = (first * T_first_here).inverse() * walk.truth;
  EXPECT_LT(error.position().norm(), 0.02);
  EXPECT_LT(std::abs(rad_to_deg(error.theta_rad)), 0.5);
}

// Cameras a hand's breadth ahead of and behind the axis: how far a turn on the spot goes depends on
// how far away things are, which the drive after it shows.
TEST(KeyframeOdometry, HasATurnOnTheSpotInOneBundleWithTheDriveAfterIt) {
  LoopCameras cameras = front_and_back();
  for (LoopCamera& camera : cameras) {
    camera.T_body_camera.translation += camera.T_body_camera.rotation * Vec3(0, 0, 0.2);
  }
  const SyntheticRoom room(1200, 3, Rng(21));
  constexpr double kTurn_rad = 0.26;
  constexpr int kTurns = 10;  // two bundles of five
  BundleOdometryOptions in_parts;
  in_parts.longest = in_parts.keyframes;
  double together_rad2 = 0;
  double apart_rad2 = 0;
  constexpr int kWalks = 8;
  for (int run = 0; run < kWalks; ++run) {
    Walk one(cameras, room, {}, 100 + run);
    Walk two(cameras, room, in_parts, 100 + run);
    double apart_rad = 0;
    for (int k = 0; k <= kTurns + 2; ++k) {
      const Pose2 step = k == 0 ? Pose2{} : k <= kTurns ? Pose2{0, 0, kTurn_rad} : Pose2{0.2, 0, 0};
      const std::optional<JointEdge> closed = one.go(step).closed;
      ASSERT_EQ(closed.has_value(), k == kTurns + 2) << k;
      if (closed) {
        together_rad2 += std::pow(
            wrap_angle(closed->T_first_node[kTurns - 1].theta_rad - kTurns * kTurn_rad), 2);
      }
      if (const std::optional<JointEdge> part = two.go(step).closed) {
        apart_rad += part->T_first_node.back().theta_rad;
      }
    }
    apart_rad2 += std::pow(wrap_angle(apart_rad - kTurns * kTurn_rad), 2);
  }
  EXPECT_LT(together_rad2, 0.5 * apart_rad2);
}

TEST(KeyframeOdometry, TellsOfPartsAndEndsABundleWhenAsked) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(600, 3, Rng(25));
  const BundleOdometryOptions options;
  Walk walk(cameras, room, options, 26);
  for (int k = 0; k <= 12; ++k) {
    walk.go({0, 0, k == 0 ? 0 : 0.26});
    const std::optional<JointEdge> part = walk.odometry.part(exact(cameras));
    ASSERT_EQ(part.has_value(), k > 0 && k % options.keyframes == 0) << k;
    if (part) {
      EXPECT_EQ(part->first, k - options.keyframes);
      EXPECT_EQ(part->T_first_node.size(), static_cast<std::size_t>(options.keyframes));
    }
  }
  const JointEdge closed = walk.odometry.close(exact(cameras));
  EXPECT_EQ(closed.first, 0);
  EXPECT_EQ(closed.T_first_node.size(), 12U);
  EXPECT_NEAR(rad_to_deg(wrap_angle(closed.T_first_node.back().theta_rad - 12 * 0.26)), 0, 1);
  const auto next = walk.go({0.2, 0, 0});
  ASSERT_EQ(next.open.size(), 1U);
  EXPECT_EQ(next.open.front().edge.from, 12);
}

TEST(KeyframeOdometry, EndsABundleThatGrowsTooLong) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(600, 3, Rng(23));
  BundleOdometryOptions options;
  options.longest = 9;
  Walk walk(cameras, room, options, 24);
  for (int k = 0; k <= 18; ++k) {
    const auto motion = walk.go({0, 0, k == 0 ? 0 : 0.26});
    EXPECT_EQ(motion.closed.has_value(), k > 0 && k % options.longest == 0) << k;
  }
}

TEST(KeyframeOdometry, GoesByTheWheelsAndTheirStatesWithoutPictures) {
  const LoopCameras cameras = front_and_back();
  KeyframeOdometry odometry({}, {}, cameras);
  RigPriorState rig = exact(cameras);
  rig.state.tail<kWheelStates>() << 0, 0, 0.02;
  Rng rng(3);
  const PlaceFeatures none(cameras.size());
  odometry.add(frame_of(cameras, {}, rng), none, rig);
  BundleFrame frame = frame_of(cameras, {0.2, 0, 0.3}, rng);
  frame.by_wheels = [](const Pose2& T) {
    WheelJacobian J = WheelJacobian::Zero();
    J(2, kWheelBase) = -T.theta_rad;
    return J;
  };
  const Pose2 told = odometry.add(frame, none, rig).T_last_here;
  EXPECT_NEAR(told.x_m, frame.T_before_here.x_m, 1e-6);
  EXPECT_NEAR(told.theta_rad, frame.T_before_here.theta_rad * (1 - 0.02), 1e-3);
}

TEST(KeyframeOdometry, MakesABundleOnceMore) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1200, 3, Rng(13));
  const BundleOdometryOptions options;
  KeyframeOdometry odometry(options, {}, cameras);
  Rng rng(14);
  std::vector<BundleFrame> frames;
  std::vector<PlaceFeatures> features;
  std::optional<JointEdge> closed;
  Pose2 truth;
  for (int k = 0; k <= options.keyframes; ++k) {
    const Pose2 step{0.2, 0, 0.1};
    truth = truth * step;
    frames.push_back(frame_of(cameras, step, rng));
    features.push_back(room.seen_from(cameras, truth, kNoise_px, 0.1, Rng(100 + k)));
    closed = odometry.add(frames.back(), features.back(), exact(cameras)).closed;
  }
  ASSERT_TRUE(closed);
  const JointEdge again = odometry.bundle_again(*closed, frames, features, exact(cameras), true);
  ASSERT_EQ(again.T_first_node.size(), closed->T_first_node.size());
  for (std::size_t k = 0; k < again.T_first_node.size(); ++k) {
    const Pose2 off = closed->T_first_node[k].inverse() * again.T_first_node[k];
    EXPECT_LT(off.position().norm(), 0.002) << k;
    EXPECT_LT(rad_to_deg(std::abs(off.theta_rad)), 0.02) << k;
  }
  // without one camera it is vaguer
  for (PlaceFeatures& place : features) {
    place[0] = {};
  }
  const JointEdge by_other =
      odometry.bundle_again(*closed, frames, features, exact(cameras), false);
  EXPECT_LT(by_other.information.diagonal().head<3>().maxCoeff(),
            0.8 * again.information.diagonal().head<3>().maxCoeff());
}

TEST(KeyframeOdometry, GivesTheSameBitsAgain) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(600, 3, Rng(4));
  std::vector<Pose2> told;
  for (int run = 0; run < 2; ++run) {
    KeyframeOdometry odometry({}, {}, cameras);
    Rng rng(5);
    Pose2 here;
    Pose2 truth;
    for (int k = 0; k < 7; ++k) {
      truth = truth * Pose2{0.2, 0, 0.2};
      here = here * odometry
                        .add(frame_of(cameras, {0.2, 0, 0.2}, rng),
                             room.seen_from(cameras, truth, kNoise_px, 0.1, Rng(k)), exact(cameras))
                        .T_last_here;
    }
    told.push_back(here);
  }
  EXPECT_EQ(told[0], told[1]);
}

// A body that has turned once round: what the wheels have got wrong by then is seen.
TEST(HeadingEdge, ShowsHowFarTheBodyHasTurned) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1200, 3, Rng(6));
  const Pose2 T_map_from{0.3, -0.5, 0.4};
  const Pose2 truth{0.01, -0.005, 0.03};
  const PlaceFeatures from = room.seen_from(cameras, T_map_from, kNoise_px, 0.2, Rng(7));
  const PlaceFeatures to = room.seen_from(cameras, T_map_from * truth, kNoise_px, 0.2, Rng(8));
  BundleFrame frame;
  frame.taken.late_s.assign(cameras.size(), 0);
  const RigState none = RigState::Zero(rig_states(cameras.size()));
  const Pose2 believed{truth.x_m, truth.y_m, truth.theta_rad + deg_to_rad(2)};
  const Mat3 covariance = Vec3(0.003, 0.003, 0.04).cwiseAbs2().asDiagonal();
  const auto edge = heading_edge({}, {}, cameras, none, {4, &frame, &from}, {29, &frame, &to},
                                 believed, covariance);
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->edge.from, 4);
  EXPECT_EQ(edge->edge.to, 29);
  const double sigma_rad = 1 / std::sqrt(edge->edge.information(2, 2));
  EXPECT_LT(rad_to_deg(sigma_rad), 0.1);
  EXPECT_NEAR(edge->edge.T_from_to.theta_rad, truth.theta_rad, 4 * sigma_rad);
  EXPECT_LT(edge->edge.information(0, 0), 1e-3);  // of the position next to nothing
}

TEST(HeadingEdge, IsNoneBetweenPlacesThatShareNothing) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom here(1200, 3, Rng(9));
  const SyntheticRoom elsewhere(1200, 3, Rng(10));
  const PlaceFeatures from = here.seen_from(cameras, {}, kNoise_px, 0, Rng(11));
  const PlaceFeatures to = elsewhere.seen_from(cameras, {}, kNoise_px, 0, Rng(12));
  BundleFrame frame;
  frame.taken.late_s.assign(cameras.size(), 0);
  const RigState none = RigState::Zero(rig_states(cameras.size()));
  const Mat3 covariance = Vec3(0.003, 0.003, 0.04).cwiseAbs2().asDiagonal();
  EXPECT_FALSE(
      heading_edge({}, {}, cameras, none, {0, &frame, &from}, {20, &frame, &to}, {}, covariance));
}

// Two keyframes half a turn apart on about one spot, the wheels' turn wrong by two degrees, the
// back camera turned by so much that nobody knows.
struct HalfTurn {
  LoopCameras believed = front_and_back();
  Pose2 truth{0.02, -0.01, std::numbers::pi - 0.05};
  Pose2 told{truth.x_m, truth.y_m, truth.theta_rad + deg_to_rad(2)};
  RigState off = RigState::Zero(rig_states(believed.size()));
  double sigma_heading_rad = deg_to_rad(1.5);
  bool back_shows_before = true;

  std::optional<SharedEdge> edge() const {
    const SyntheticRoom room(1200, 3, Rng(13));
    const LoopCameras cameras = corrected(believed, off);
    const Pose2 T_map_from{0.3, -0.5, 0.4};
    PlaceFeatures from = room.seen_from(cameras, T_map_from, kNoise_px, 0.2, Rng(14));
    if (!back_shows_before) {
      from[1] = {};
    }
    const PlaceFeatures to = room.seen_from(cameras, T_map_from * truth, kNoise_px, 0.2, Rng(15));
    const PictureTimes taken{{}, std::vector<double>(cameras.size(), 0.0)};
    const auto depths_of = [&](const PlaceFeatures& seen, const Pose2& T_map_here, int seed) {
      const Pose2 T_here_beside{0.2, 0.1, 0.1};
      const PlaceFeatures beside =
          room.seen_from(cameras, T_map_here * T_here_beside, kNoise_px, 0.2, Rng(seed));
      return triangulate({}, {}, believed, seen, {{believed, beside, T_here_beside}});
    };
    const PlaceDepths depths_from = depths_of(from, T_map_from, 16);
    const PlaceDepths depths_to = depths_of(to, T_map_from * truth, 17);
    SharedGraph graph;
    graph.T_map_node = {Pose2{}, told};
    graph.state = RigState::Zero(off.size());
    graph.prior_information = 1e4 * Eigen::MatrixXd::Identity(off.size(), off.size());
    const Mat3 covariance = Vec3(0.005, 0.005, sigma_heading_rad).cwiseAbs2().asDiagonal();
    graph.edges = {{{0, 1, told, covariance.inverse()}, {}, {}}};
    return facing_edge({}, {}, believed, graph.state, facings(believed)[1],
                       {0, {taken, from, depths_from}}, {1, {taken, to, depths_to}}, told,
                       SharedUncertainty(graph));
  }
};

TEST(FacingEdge, ShowsHowFarHalfATurnWas) {
  const auto edge = HalfTurn().edge();
  ASSERT_TRUE(edge);
  const double sigma_rad = std::sqrt(edge->edge.information.inverse()(2, 2));
  EXPECT_LT(rad_to_deg(sigma_rad), 0.15);
  EXPECT_NEAR(wrap_angle(edge->edge.T_from_to.theta_rad - HalfTurn().truth.theta_rad), 0,
              4 * sigma_rad);
}

// What one pair of cameras gets wrong the other gets wrong the other way round: both together lean
// on neither.
TEST(FacingEdge, OfBothCamerasNeedsNoKnownMounting) {
  HalfTurn robot;
  robot.off[camera_state(1) + kRotation + 2] = deg_to_rad(0.8);
  const auto edge = robot.edge();
  ASSERT_TRUE(edge);
  EXPECT_NEAR(wrap_angle(edge->edge.T_from_to.theta_rad - robot.truth.theta_rad), 0,
              deg_to_rad(0.15));
  EXPECT_LT(std::abs((edge->by_state * robot.off).z()), deg_to_rad(0.15));
}

TEST(FacingEdge, ChangesWithTheMountingOfItsCameras) {
  HalfTurn robot;
  robot.back_shows_before = false;
  robot.off[camera_state(1) + kRotation + 2] = deg_to_rad(0.8);
  const auto edge = robot.edge();
  ASSERT_TRUE(edge);
  const double sigma_rad = std::sqrt(edge->edge.information.inverse()(2, 2));
  const double off_rad = wrap_angle(edge->edge.T_from_to.theta_rad - robot.truth.theta_rad);
  EXPECT_GT(std::abs(off_rad), deg_to_rad(0.6));
  EXPECT_NEAR(off_rad + (edge->by_state * robot.off).z(), 0, 4 * sigma_rad + deg_to_rad(0.05));
}

TEST(FacingEdge, IsNoneWhereTheGraphKnowsBetter) {
  HalfTurn robot;
  robot.off[camera_state(1) + kRotation + 2] = deg_to_rad(4);
  robot.sigma_heading_rad = deg_to_rad(0.1);
  robot.told = robot.truth;
  EXPECT_FALSE(robot.edge());
}

}  // namespace
}  // namespace panoptes

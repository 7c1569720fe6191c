// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/local_bundle.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

using testing::front_and_back;
using testing::SyntheticRoom;

constexpr double kNoise_px = 0.5;

/// A drive seen by true cameras, as a bundle has it.
struct Seen {
  std::vector<Pose2> truth;  ///< seen from the first
  std::vector<BundleFrame> frames;
  std::vector<Track> tracks;

  std::vector<Pose2> by_wheels() const {
    std::vector<Pose2> poses{Pose2{}};
    for (std::size_t k = 1; k < frames.size(); ++k) {
      poses.push_back(poses.back() * frames[k].T_before_here);
    }
    return poses;
  }
};

struct WheelError {
  double turn = 1;  ///< times too far
  double sigma_m = 0.002;
  double sigma_rad = 0.002;
};

// Of a motion taken for one arc.
WheelJacobian wheels_of(const Pose2& T) {
  WheelJacobian J = WheelJacobian::Zero();
  J.row(2) << T.theta_rad, 0, -T.theta_rad;
  J.topRows<2>() = Vec2(-T.y_m, T.x_m) * (0.5 * J.row(2));
  J.col(kWheelScale).head<2>() += T.position();
  return J;
}

/// Cameras that sit otherwise from one keyframe on.
struct Knocked {
  int from = 0;
  LoopCameras cameras;
};

Seen drive(const SyntheticRoom& room, const LoopCameras& cameras, const std::vector<Pose2>& steps,
           double noise_px, const WheelError& wheels, const Rng& rng,
           const std::optional<Knocked>& knocked = {}) {
  Seen seen;
  const Pose2 T_map_first{-0.4, 0.3, 0.2};
  std::vector<PlaceFeatures> features;
  std::vector<std::vector<std::vector<int>>> tracks;
  for (std::size_t k = 0; k <= steps.size(); ++k) {
    Rng draw = rng.fork(std::to_string(k));
    seen.truth.push_back(k == 0 ? Pose2{} : seen.truth.back() * steps[k - 1]);
    BundleFrame frame;
    frame.taken.late_s.assign(cameras.size(), 0);
    if (k > 0) {
      const Pose2& step = steps[k - 1];
      frame.T_before_here = {step.x_m + draw.normal(0, wheels.sigma_m),
                             step.y_m + draw.normal(0, wheels.sigma_m),
                             wheels.turn * step.theta_rad + draw.normal(0, wheels.sigma_rad)};
      frame.covariance =
          Vec3(wheels.sigma_m, wheels.sigma_m, wheels.sigma_rad).cwiseAbs2().asDiagonal();
      frame.by_wheels = wheels_of;
    }
    seen.frames.push_back(frame);
    const bool before = !knocked || static_cast<int>(k) < knocked->from;
    features.push_back(room.seen_from(before ? cameras : knocked->cameras,
                                      T_map_first * seen.truth.back(), noise_px, 0,
                                      draw.fork("sees")));
    tracks.emplace_back();
    for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
      tracks.back().emplace_back(features.back()[camera].px.size(), -1);
      if (k == 0) {
        continue;
      }
      for (const FeatureMatch& match :
           match_features({}, features[k - 1][camera], features[k][camera])) {
        int& track = tracks[k - 1][camera][match.a];
        if (track < 0) {
          track = static_cast<int>(seen.tracks.size());
          seen.tracks.push_back({static_cast<int>(camera),
                                 {{static_cast<int>(k) - 1, match.a,
                                   features[k - 1][camera].px[match.a].cast<double>()}}});
        }
        seen.tracks[track].seen.push_back(
            {static_cast<int>(k), match.b, features[k][camera].px[match.b].cast<double>()});
        tracks[k][camera][match.b] = track;
      }
    }
  }
  return seen;
}

const std::vector<Pose2> kAhead{{0.25, 0, 0}, {0.25, 0, 0.1}, {0.24, 0.01, 0.2}, {0.25, 0, 0}};
const std::vector<Pose2> kSpin(4, Pose2{0, 0, 0.26});

RigPriorState held(const LoopCameras& cameras) {
  return {RigState::Zero(rig_states(cameras.size())), {}};
}

Eigen::VectorXd error_of(const BundleSolution& solution, const std::vector<Pose2>& truth) {
  const std::size_t count = truth.size() - 1;
  Eigen::VectorXd error(3 * count);
  for (std::size_t k = 0; k < count; ++k) {
    const Pose2& found = solution.T_first_frame[k + 1];
    error.segment<3>(static_cast<Eigen::Index>(3 * k)) =
        Vec3(found.x_m - truth[k + 1].x_m, found.y_m - truth[k + 1].y_m,
             wrap_angle(found.theta_rad - truth[k + 1].theta_rad));
  }
  return error;
}

TEST(LocalBundle, FindsPosesThatPicturesWithoutNoiseShow) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 3, Rng(1));
  for (const std::vector<Pose2>& steps : {kAhead, kSpin}) {
    const Seen seen = drive(room, cameras, steps, 0, {1.03, 1e-5, 0.05}, Rng(2));
    const BundleSolution found =
        adjust_bundle({}, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels());
    EXPECT_LT(error_of(found, seen.truth).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_TRUE(found.information.isApprox(found.information.transpose()));
  }
}

// Depths are nowhere known beforehand, cameras are off the axis that the body turns about.
TEST(LocalBundle, IsAsSureOfHeadingsAsItIsRight) {
  const LoopCameras cameras = front_and_back();
  for (const std::vector<Pose2>& steps : {kAhead, kSpin}) {
    double squares = 0;
    double turned_off_rad = 0;
    constexpr int kRuns = 20;
    for (int run = 0; run < kRuns; ++run) {
      const Rng rng(static_cast<std::uint64_t>(run));
      const SyntheticRoom room(1200, 3, rng.fork("room"));
      const Seen seen =
          drive(room, cameras, steps, kNoise_px, {1, 0.0005, 0.01}, rng.fork("drive"));
      const BundleSolution found =
          adjust_bundle({}, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels());
      const Eigen::Index poses = 3 * static_cast<Eigen::Index>(steps.size());
      const Eigen::VectorXd error = error_of(found, seen.truth);
      squares += error.dot(found.information.topLeftCorner(poses, poses) * error) /
                 static_cast<double>(poses);
      turned_off_rad += error[poses - 1];
    }
    EXPECT_GT(squares / kRuns, 0.4);
    EXPECT_LT(squares / kRuns, 2);
    EXPECT_LT(std::abs(rad_to_deg(turned_off_rad / kRuns)), 0.05);
  }
}

RigState sigmas(const LoopCameras& cameras, double rotation_rad, double position_m) {
  RigState s = RigState::Constant(rig_states(cameras.size()), 1e-6);
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const int at = camera_state(static_cast<int>(camera));
    s.segment<3>(at + kRotation).setConstant(rotation_rad);
    s.segment<2>(at + kPosition).setConstant(position_m);
  }
  s.tail<kWheelStates>() << 0.005, 0.005, 0.02;
  return s;
}

// Bundle after bundle, each with what those before have shown as its prior.
TEST(LocalBundle, LearnsHowCamerasAreMounted) {
  const LoopCameras believed = front_and_back();
  const RigState sigma = sigmas(believed, deg_to_rad(1), 0.01);
  RigState truth = RigState::Zero(sigma.size());
  truth.segment<5>(kRotation) << deg_to_rad(0.8), deg_to_rad(-0.6), deg_to_rad(1.1), 0.008, -0.012;
  truth.segment<5>(camera_state(1)) << deg_to_rad(-0.5), deg_to_rad(0.9), deg_to_rad(-0.7), -0.009,
      0.006;
  const LoopCameras cameras = corrected(believed, truth);
  const SyntheticRoom room(1200, 3, Rng(3));
  RigPriorState known{RigState::Zero(sigma.size()), sigma.cwiseAbs2().cwiseInverse().asDiagonal()};
  std::vector<Pose2> there_and_back = kSpin;
  for (int k = 0; k < 4; ++k) {
    const double ahead_m = k % 2 == 0 ? 0.25 : -0.25;
    there_and_back[k] = {ahead_m, 0, 0.15};
  }
  for (int bundle = 0; bundle < 16; ++bundle) {
    const Seen seen = drive(room, cameras, bundle % 2 == 0 ? kSpin : there_and_back, kNoise_px, {},
                            Rng(4).fork(std::to_string(bundle)));
    const BundleSolution found =
        adjust_bundle({}, believed, known, seen.frames, seen.tracks, seen.by_wheels());
    // what the bundle says of the states, its poses integrated out
    const Eigen::Index poses = 3 * static_cast<Eigen::Index>(seen.frames.size() - 1);
    const Eigen::Index states = sigma.size();
    const Eigen::LDLT<Eigen::MatrixXd> of_poses(found.information.topLeftCorner(poses, poses));
    const Eigen::MatrixXd across = found.information.topRightCorner(poses, states);
    const Eigen::MatrixXd said = found.information.bottomRightCorner(states, states) -
                                 across.transpose() * of_poses.solve(across);
    const Eigen::VectorXd gradient =
        found.gradient.tail(states) -
        across.transpose() * of_poses.solve(found.gradient.head(poses));
    const Eigen::MatrixXd information = known.information + said;
    const Eigen::VectorXd target = known.information * known.state + said * found.state - gradient;
    known = {information.ldlt().solve(target), information};
  }
  const Eigen::MatrixXd covariance = known.information.inverse();
  for (int camera = 0; camera < 2; ++camera) {
    for (int k = camera_state(camera); k < camera_state(camera) + kFocal; ++k) {
      EXPECT_LT(std::abs(known.state[k] - truth[k]), 4 * std::sqrt(covariance(k, k))) << k;
    }
    const int yaw = camera_state(camera) + kRotation + 2;
    EXPECT_LT(rad_to_deg(std::sqrt(covariance(yaw, yaw))), 0.2);
    EXPECT_NEAR(rad_to_deg(known.state[yaw] - truth[yaw]), 0, 0.3);
  }
}

// Thousands of depths and baselines that explain noise together tell of neither.
TEST(LocalBundle, LearnsNoLeverArmFromWhatIsFarAway) {
  const LoopCameras believed = front_and_back();
  const RigState sigma = sigmas(believed, deg_to_rad(1), 0.01);
  RigState truth = RigState::Zero(sigma.size());
  truth[kPosition] = 0.03;
  const SyntheticRoom hall(2500, 60, Rng(5));
  const Seen seen = drive(hall, corrected(believed, truth), kSpin, kNoise_px, {}, Rng(6));
  const RigPriorState prior{RigState::Zero(sigma.size()),
                            sigma.cwiseAbs2().cwiseInverse().asDiagonal()};
  const BundleSolution found =
      adjust_bundle({}, believed, prior, seen.frames, seen.tracks, seen.by_wheels());
  EXPECT_LT(std::abs(found.state[kPosition]), sigma[kPosition]);
  EXPECT_LT(found.information.diagonal()[3 * 4 + kPosition],
            1 / (sigma[kPosition] * sigma[kPosition]));
}

// A room twice as large, driven through by a robot twice as large, looks the same: however noisy
// its wheels are, no bundle says anything of the scale.
TEST(LocalBundle, SaysNothingOfTheScale) {
  LoopCameras cameras = front_and_back();
  for (LoopCamera& camera : cameras) {
    camera.T_body_camera.translation.head<2>().setZero();
  }
  const RigState sigma = sigmas(cameras, deg_to_rad(1), 0.01);
  const RigPriorState prior{RigState::Zero(sigma.size()),
                            sigma.cwiseAbs2().cwiseInverse().asDiagonal()};
  double pull = 0;
  constexpr int kRuns = 8;
  for (int run = 0; run < kRuns; ++run) {
    const Rng rng(static_cast<std::uint64_t>(run));
    const SyntheticRoom room(1200, 3, rng.fork("room"));
    const Seen seen = drive(room, cameras, kAhead, kNoise_px, {1, 0.003, 0.01}, rng.fork("drive"));
    const BundleSolution found =
        adjust_bundle({}, cameras, prior, seen.frames, seen.tracks, seen.by_wheels());
    Eigen::VectorXd larger = Eigen::VectorXd::Zero(found.gradient.size());
    for (std::size_t k = 1; k < seen.frames.size(); ++k) {
      larger.segment<2>(static_cast<Eigen::Index>(3 * (k - 1))) = found.T_first_frame[k].position();
    }
    const Eigen::Index states = larger.size() - found.state.size();
    for (int camera = 0; camera < 2; ++camera) {
      const int at = camera_state(camera) + kPosition;
      larger.segment<2>(states + at) = found.state.segment<2>(at);
    }
    const Eigen::Index wheels = larger.size() - kWheelStates;
    larger[wheels + kWheelScale] = larger[wheels + kWheelBase] = 1;
    pull += found.gradient.dot(larger) / kRuns;
  }
  EXPECT_LT(std::abs(pull), 0.1);  // one for each coordinate of noise were it scaled: a dozen
}

// The poses of held states move with these as the information says.
TEST(LocalBundle, SaysHowPosesFollowTheStates) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 3, Rng(7));
  const Seen seen = drive(room, cameras, kAhead, kNoise_px, {}, Rng(8));
  const auto solve = [&](const RigState& state) {
    return adjust_bundle({}, cameras, {state, {}}, seen.frames, seen.tracks, seen.by_wheels());
  };
  const RigState none = RigState::Zero(rig_states(cameras.size()));
  const BundleSolution here = solve(none);
  const Eigen::Index poses = 3 * static_cast<Eigen::Index>(seen.frames.size() - 1);
  const Eigen::MatrixXd by_state = -here.information.topLeftCorner(poses, poses)
                                        .ldlt()
                                        .solve(here.information.topRightCorner(poses, none.size()));
  for (const int k :
       {kRotation + 2, static_cast<int>(kPosition), camera_state(1) + kRotation + 2}) {
    RigState moved = none;
    moved[k] = 0.002;
    const BundleSolution there = solve(moved);
    const Eigen::VectorXd off = error_of(there, here.T_first_frame) - by_state.col(k) * moved[k];
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 0.15 * (by_state.col(k) * moved[k]).cwiseAbs().maxCoeff())
        << k;
  }
}

TEST(LocalBundle, TellsWhatIsMismatchedFromWhatFits) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(800, 3, Rng(9));
  Seen seen = drive(room, cameras, kAhead, kNoise_px, {}, Rng(10));
  Rng rng(11);
  std::size_t spoiled = 0;
  for (std::size_t t = 0; t < seen.tracks.size(); t += 5) {
    seen.tracks[t].seen.back().px += Vec2(rng.uniform(15, 40), rng.uniform(-40, -15));
    ++spoiled;
  }
  const BundleSolution found =
      adjust_bundle({}, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels());
  std::size_t believed = 0;
  std::size_t refused = 0;
  for (std::size_t t = 0; t < seen.tracks.size(); ++t) {
    (t % 5 == 0 ? believed : refused) += found.inlier[t] == (t % 5 == 0) ? 1 : 0;
  }
  EXPECT_LT(static_cast<double>(believed), 0.05 * static_cast<double>(spoiled));
  EXPECT_LT(static_cast<double>(refused), 0.1 * static_cast<double>(seen.tracks.size() - spoiled));
  EXPECT_LT(error_of(found, seen.truth).cwiseAbs().maxCoeff(), 0.02);
}

// Somebody walks behind the robot, as fast as it drives, and fills most of what the back camera
// shows; before the front one is all but a blank wall.
TEST(LocalBundle, IsNotLedAstrayByWhoFillsOneCamerasPicture) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(800, 3, Rng(9));
  constexpr double kWheels_rad = 0.009;
  constexpr std::size_t kOfTheWall = 25;
  const std::vector<Pose2> steps{
      {0.27, 0, 0.03}, {0.27, 0, 0.04}, {0.27, 0, 0.04}, {0.27, 0, 0.05}};
  for (std::uint64_t seed = 20; seed < 25; ++seed) {
    Seen seen = drive(room, cameras, steps, kNoise_px, {1, 0.002, kWheels_rad}, Rng(seed));
    Rng rng(seed + 100);
    std::size_t of_front = 0;
    std::erase_if(seen.tracks,
                  [&](const Track& t) { return t.camera == 0 && ++of_front > kOfTheWall; });
    for (Track& track : seen.tracks) {
      if (track.camera == 1 && rng.uniform(0, 1) < 0.8) {
        const Vec2 along = track.seen.front().px;
        for (std::size_t k = 1; k < track.seen.size(); ++k) {
          track.seen[k].px = along + Vec2(rng.normal(0, kNoise_px), rng.normal(0, kNoise_px));
        }
      }
    }
    const BundleSolution found =
        adjust_bundle({}, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels());
    EXPECT_LT(error_of(found, seen.truth).cwiseAbs().maxCoeff(), 0.03) << seed;
  }
}

// Things that the robot all but touches fall behind a picture's plane with the last steps.
TEST(LocalBundle, KnowsItsNoiseAmongThingsThatItAllButTouches) {
  const LoopCameras cameras = front_and_back();
  for (int run = 0; run < 10; ++run) {
    const Rng rng(static_cast<std::uint64_t>(run));
    const SyntheticRoom narrow(1500, 1.1, rng.fork("room"));
    const Seen seen = drive(narrow, cameras, kAhead, kNoise_px, {1, 0.02, 0.02}, rng.fork("drive"));
    const BundleSolution found =
        adjust_bundle({}, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels());
    EXPECT_LT(found.noise_px, 1) << run;
    EXPECT_GT(found.noise_px, 0.3) << run;
  }
}

// What one bundle has learned the next begins with: what is left of corners without noise would
// shrink for ever, until nothing that is true fits any more.
TEST(LocalBundle, CornersAreNeverSurerThanTheirPixel) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 3, Rng(30));
  BundleOptions options;
  for (int bundle = 0; bundle < 4; ++bundle) {
    const Seen seen = drive(room, cameras, kAhead, 0, {}, Rng(31));
    options.noise_px =
        adjust_bundle(options, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels())
            .noise_px;
  }
  EXPECT_NEAR(options.noise_px, 1 / std::sqrt(12), 1e-9);
}

TEST(LocalBundle, GoesByTheWheelsWhereNothingIsSeen) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(10, 3, Rng(12));
  Seen seen = drive(room, cameras, kAhead, kNoise_px, {}, Rng(13));
  seen.tracks.clear();
  const BundleSolution found =
      adjust_bundle({}, cameras, held(cameras), seen.frames, seen.tracks, seen.by_wheels());
  EXPECT_LT(error_of(found, seen.by_wheels()).cwiseAbs().maxCoeff(), 1e-9);
}

// A drive with a turn, then on.
std::vector<Pose2> about_a_corner() {
  std::vector<Pose2> steps(5, Pose2{0.2, 0, 0});
  steps.insert(steps.end(), 3, Pose2{0, 0, 0.26});
  steps.insert(steps.end(), 4, Pose2{0.2, 0, 0.05});
  return steps;
}

// How far the jump of a camera is from `change`, in sigmas, that of the other none.
double jump_error_sigmas(const MountingJump& jump, int camera, const MountingChange& change) {
  const int first = camera * kMountingStates;
  const Eigen::MatrixXd information =
      jump.information.block<kMountingStates, kMountingStates>(first, first);
  const MountingChange off =
      information.ldlt().solve(jump.pull.segment<kMountingStates>(first)) - change;
  return std::sqrt(off.dot(information * off));
}

TEST(LocalBundle, ShowsByHowMuchACameraJumped) {
  constexpr int kFrom = 4;
  constexpr double kFarOff_sigmas = 5;  // six freedoms: once in 10^3
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 3, Rng(30));
  RigPriorState known{RigState::Zero(rig_states(cameras.size())), {}};
  known.information = 1e6 * Eigen::MatrixXd::Identity(known.state.size(), known.state.size());
  for (int camera = 0; camera < 2; ++camera) {
    for (const int state : {kRotation + 2, kPosition + 0, kPosition + 1}) {
      RigState now = known.state;
      MountingChange change = MountingChange::Zero();
      change[state] = state < kPosition ? deg_to_rad(1.5) : 0.015;
      now.segment<kMountingStates>(camera_state(camera)) = change;
      const Seen seen = drive(room, cameras, about_a_corner(), kNoise_px, {1, 0.001, 0.002},
                              Rng(31 + state), Knocked{kFrom, corrected(cameras, now)});
      const MountingJump jump =
          mounting_jump({}, cameras, known, seen.frames, seen.tracks, seen.by_wheels(), kFrom);
      EXPECT_LT(jump_error_sigmas(jump, camera, change), kFarOff_sigmas) << camera << state;
      EXPECT_GT(jump_error_sigmas(jump, camera, MountingChange::Zero()), 2 * kFarOff_sigmas)
          << camera << state;
      EXPECT_GT(jump.fitting[camera], 0.8 * jump.crossing[camera]);
    }
  }
}

TEST(LocalBundle, ShowsNoJumpWhereThereIsNoneAndAsSurelyAsTracksAgree) {
  constexpr int kFrom = 4;
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 3, Rng(40));
  RigPriorState known{RigState::Zero(rig_states(cameras.size())), {}};
  known.information = 1e6 * Eigen::MatrixXd::Identity(known.state.size(), known.state.size());
  for (int run = 0; run < 5; ++run) {
    const Seen seen =
        drive(room, cameras, about_a_corner(), kNoise_px, {1, 0.001, 0.002}, Rng(41 + run));
    const MountingJump jump =
        mounting_jump({}, cameras, known, seen.frames, seen.tracks, seen.by_wheels(), kFrom);
    constexpr double kFarOff_sigmas = 5;
    for (int camera = 0; camera < 2; ++camera) {
      EXPECT_LT(jump_error_sigmas(jump, camera, MountingChange::Zero()), kFarOff_sigmas);
    }
    // independent noise: the scatter is the information but for chance
    const double share = jump.scatter.trace() / jump.information.trace();
    EXPECT_GT(share, 0.5);
    EXPECT_LT(share, 1.5);
  }
}

}  // namespace
}  // namespace panoptes

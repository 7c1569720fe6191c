// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "core/camera/loop_cameras.h"
#include "core/geometry/pose2.h"
#include "core/motion/rig_correction.h"

namespace panoptes {

/// Where one camera shows one thing at several keyframes.
struct Track {
  struct Seen {
    int frame = 0;
    int feature = 0;
    Vec2 px = Vec2::Zero();
  };
  int camera = 0;
  std::vector<Seen> seen;  ///< in order of frames, at least two
};

/// One keyframe of a bundle.
struct BundleFrame {
  PictureTimes taken;
  // What the odometry tells of the motion since the frame before; x, y, theta in that one's frame:
  Pose2 T_before_here;
  Mat3 covariance = Mat3::Identity();  ///< of what differs from one motion to the next,
  /// and how such a motion changes with the wheels' states; empty where there are none.
  std::function<WheelJacobian(const Pose2& T_from_to)> by_wheels;
};

struct BundleOptions {
  double noise_px = 0.8;    ///< of a feature's position, one sigma, before the run has shown it
  double inlier_sigma = 3;  ///< by which the sum of a track's squared residuals may be too large
  int iterations = 8;
  bool starts_near = false;  ///< the start was adjusted before: outliers are told apart sooner
};

/// What a local bundle adjustment found: a Gaussian in the frames' poses seen from the first (x, y,
/// theta of frames 1, 2, ...) and in the rig's states, all depths integrated out.
struct BundleSolution {
  std::vector<Pose2> T_first_frame;
  RigState state;               ///< about which it was linearised
  Eigen::MatrixXd information;  ///< of (poses, states), without the states' prior
  Eigen::VectorXd gradient;     ///< of half the squared error there: zero in the poses
  std::vector<bool> inlier;
  double noise_px = 0;  ///< as its residuals have it
};

/// What is known of the rig before a bundle is adjusted.
struct RigPriorState {
  RigState state;
  Eigen::MatrixXd information;  ///< inverse covariance; empty: the states are held
};

/// By how much each camera's mounting changed between two keyframes of a bundle: a Gaussian in
/// kMountingStates of each, poses, depths and states integrated out.
struct MountingJump {
  Eigen::MatrixXd information;
  Eigen::VectorXd pull;     ///< information times what explains all best
  Eigen::MatrixXd scatter;  ///< of the pull, as the tracks show it that make it up: the same as the
                            ///< information where their noise is what it is taken for
  std::vector<int> crossing;  ///< how many tracks of each camera go from before to after it,
  std::vector<int> fitting;   ///< and how many of these are inliers
};

/// One sigma of a mounting's change before anything is seen of it.
MountingChange mounting_jump_sigmas();

/// Poses and depths that explain the tracks and the wheels best, and the states of the rig where
/// they are not held.
/// Each thing is a point of unknown bearing and inverse depth at the first keyframe that saw it
/// (Civera, Davison and Montiel 2008), integrated out by Schur's complement (Triggs et al.
/// 2000).
BundleSolution adjust_bundle(const BundleOptions& options, const LoopCameras& believed,
                             const RigPriorState& prior, const std::vector<BundleFrame>& frames,
                             const std::vector<Track>& tracks,
                             const std::vector<Pose2>& start_T_first_frame);

/// The same where each camera's mounting may be another from frame `jump_at` on. The scatter is of
/// what whole tracks say (White 1980, Liang and Zeger 1986), so that neither a feature that slips
/// the same way in all of its pictures nor one that is noisier than others makes it too sure.
MountingJump mounting_jump(const BundleOptions& options, const LoopCameras& believed,
                           const RigPriorState& prior, const std::vector<BundleFrame>& frames,
                           const std::vector<Track>& tracks,
                           const std::vector<Pose2>& start_T_first_frame, int jump_at);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"
#include "core/vision/local_features.h"

namespace panoptes {

/// A camera that recognises places, as the robot believes it to be.
struct LoopCamera {
  std::string name;   ///< in the rig
  std::string looks;  ///< where its role says: front, back, left
  Intrinsics intrinsics;
  Pose3 T_body_camera;
  double clock_offset_s = 0;  ///< by which its stamps are believed to be late
  CameraSigmas sigma = {};    ///< of all of these
};
using LoopCameras = std::vector<LoopCamera>;       ///< front, back, then any others
using PlaceFeatures = std::vector<LocalFeatures>;  ///< one for each loop camera

constexpr std::size_t kLoopFront = 0;
constexpr std::size_t kLoopBack = 1;

/// The cameras whose roles begin with loop_: loop_front, loop_back, then all others in the order of
/// their roles. ConfigError when there is none for the first two.
LoopCameras loop_cameras(const Rig& rig);

/// The camera that shows what `camera` shows when the robot stands the other way round; empty where
/// there is none.
std::optional<int> opposite_of(int camera);

/// Inverse distance along a camera's axis of what a pixel shows, 1/m, and how sure that is.
struct InverseDepth {
  double mean_per_m = 0.4;
  double sigma_per_m = 0.5;  ///< the defaults say "somewhere between half a metre and infinity"
};
/// One for each feature of each loop camera; none for a camera where nothing is known.
using PlaceDepths = std::vector<std::vector<InverseDepth>>;

/// One thing seen from two places, `a` and `b`.
struct PlaceMatch {
  int camera_a = 0;
  int camera_b = 0;
  int feature_a = 0;
  int feature_b = 0;
};

/// Matches each camera with itself, or, for a place seen the other way round (`opposite`), with the
/// one that looks there then: front with back and back with front.
std::vector<PlaceMatch> match_places(const FeatureOptions& options, const PlaceFeatures& a,
                                     const PlaceFeatures& b, bool opposite);

struct MotionOptions {
  double noise_px =
      0.8;  ///< of a feature's position, one sigma: corners on a pixel grid and pyramid
  double inlier_sigma = 3;  ///< how far a residual may be from what noise and depth explain
  int hypotheses = 240;     ///< tried when the prior is too wide to start from
};
void bind(Fields& f, MotionOptions& o);

/// The prior of the pose of `b` seen from `a`; x, y, theta in the frame of `a`.
struct MotionPrior {
  Pose2 T_a_b;
  Mat3 covariance = Mat3::Identity();
};

struct PlanarMotion {
  Pose2 T_a_b;                           ///< prior and pictures together
  Mat3 covariance = Mat3::Identity();    ///< of it; x, y, theta in the frame of `a`
  Pose2 T_a_b_seen;                      ///< by the pictures alone, prior forgotten,
  Mat3 information_seen = Mat3::Zero();  ///< and what they alone say
  double sigma_theta_rad = 0;            ///< of T_a_b
  double direction_rad = 0;              ///< of the translation of T_a_b, in the frame of `a`
  int matches = 0;
  int inliers = 0;
  std::vector<int> inliers_by_camera;  ///< by the camera of `a`
  double rms_px = 0;                   ///< of the inliers, across their epipolar lines
};

/// The motion on the floor between two places from matched features: each match is compared where
/// the other picture shows it, with noise and uncertain depth weighing the residual, so that a
/// point without known depth counts only across its epipolar line. Robust Gauss-Newton from the
/// prior, or, when `search` is set, from the best of many sampled hypotheses within three sigma of
/// it. Empty with too few consistent matches. Depths (of either place, or empty) make the
/// translation observable.
std::optional<PlanarMotion> motion_by_features(const MotionOptions& options,
                                               const LoopCameras& cameras, const PlaceFeatures& a,
                                               const PlaceDepths& depths_a, const PlaceFeatures& b,
                                               const PlaceDepths& depths_b,
                                               const std::vector<PlaceMatch>& matches,
                                               const MotionPrior& prior, Rng* search);

/// What each camera of `a` says alone of a motion found by all: from its own matches, beginning at
/// `T_a_b` with the prior's certainty. Empty where a camera has too few.
std::vector<std::optional<PlanarMotion>> motion_by_each_camera(
    const MotionOptions& options, const LoopCameras& cameras, const PlaceFeatures& a,
    const PlaceDepths& depths_a, const PlaceFeatures& b, const PlaceDepths& depths_b,
    const std::vector<PlaceMatch>& matches, const MotionPrior& prior);

/// A place seen from where `here` was or will be.
struct Neighbour {
  const PlaceFeatures* features = nullptr;
  Pose2 T_here_there;
};

/// Depth of each of a place's features, from its matches in neighbouring places at known relative
/// poses; a feature without a consistent partner keeps the default.
PlaceDepths triangulate(const FeatureOptions& feature_options, const MotionOptions& options,
                        const LoopCameras& cameras, const PlaceFeatures& here,
                        const std::vector<Neighbour>& neighbours);

}  // namespace panoptes

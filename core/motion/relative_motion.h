// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/loop_cameras.h"
#include "core/config/fields.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"
#include "core/vision/local_features.h"

namespace panoptes {

/// Inverse distance along a camera's axis of what a pixel shows, 1/m, and how sure that is.
struct InverseDepth {
  double mean_per_m = 0.4;
  double sigma_per_m = 0.5;  ///< the defaults say "somewhere between half a metre and infinity"

  /// Surer than the default.
  bool is_measured() const { return sigma_per_m < 0.25; }
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

/// Matches the cameras that show the same in this facing; `a` was there before, `b` is now.
std::vector<PlaceMatch> match_places(const FeatureOptions& options, const PlaceFeatures& a,
                                     const PlaceFeatures& b, const Facing& facing);

/// A place as its cameras saw it: these as they stood in the keyframe's body, features and, where
/// they are known, depths of each.
struct SeenPlace {
  const LoopCameras& cameras;
  const PlaceFeatures& features;
  const PlaceDepths& depths;
};

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
  int matches = 0;
  int inliers = 0;
  std::vector<int> inliers_by_camera;  ///< by the camera of `a`
  std::vector<PlaceMatch> inlier_matches;
  double rms_px = 0;  ///< of the inliers, across their epipolar lines
};

/// The motion on the floor between two places from matched features: each match is compared where
/// the other picture shows it, with noise and uncertain depth weighing the residual, so that a
/// point without known depth counts only across its epipolar line. Robust Gauss-Newton from the
/// prior, or, when `search` is set, from the best of many sampled hypotheses within three sigma of
/// it. Empty with too few consistent matches. Depths (of either place, or empty) make the
/// translation observable.
std::optional<PlanarMotion> motion_by_features(const MotionOptions& options, const SeenPlace& a,
                                               const SeenPlace& b,
                                               const std::vector<PlaceMatch>& matches,
                                               const MotionPrior& prior, Rng* search);

/// What each camera of `a` says alone of a motion found by all: from its own matches, beginning at
/// `T_a_b` with the prior's certainty. Empty where a camera has too few.
std::vector<std::optional<PlanarMotion>> motion_by_each_camera(
    const MotionOptions& options, const SeenPlace& a, const SeenPlace& b,
    const std::vector<PlaceMatch>& matches, const MotionPrior& prior);

/// How far from `T_a_b` these matches alone would put the motion, to first order: x, y, theta in
/// the frame of `a`. Not a number where they do not show it.
Vec3 step_by_features(const MotionOptions& options, const SeenPlace& a, const SeenPlace& b,
                      const std::vector<PlaceMatch>& matches, const Pose2& T_a_b);

}  // namespace panoptes

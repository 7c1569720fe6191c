// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/time.h"
#include "core/calib/rig_costs.h"
#include "core/calib/wheel_readings.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// Cameras that share fewer points do not tell how high one stands beside the other.
inline constexpr int kFewestShared = 20;

/// A picture of one of the rig's cameras, of about one of the instants.
struct RigView {
  std::size_t camera = 0;
  std::size_t instant = 0;
  Time stamp;  ///< by the camera's clock
};

/// A point where a view shows it.
struct RigSeen {
  std::size_t view = 0;
  std::size_t point = 0;
  Vec2 px = Vec2::Zero();
  bool own = true;  ///< the point is of this camera's map; else it was found by another one's
  bool believed = true;
};

/// What all cameras of a rig saw while it drove: instants by the odometry's clock, in order.
struct RigTracks {
  std::vector<Time> instants;
  std::vector<RigView> views;
  std::vector<RigSeen> seen;
};

/// What is estimated. `start` is the body at the first instant.
struct RigBundleState {
  std::vector<Pose3> T_start_body;  ///< at the instants
  std::vector<Pose3> T_body_camera;
  std::vector<Intrinsics> lenses;
  std::vector<double> clock_offset_s;
  Vec3 wheel_errors = Vec3::Zero();  ///< WheelError
  std::vector<Vec3> points_start;
};

/// Standard deviations of what wheels err by (WheelError), before anything is seen. Of the way no
/// picture tells: what is left of it is of every distance that is told.
struct WheelsKnown {
  Vec3 sigma = Vec3(0.005, 0.03, 0.02);
};

struct RigBundleOptions {
  WheelsKnown wheels;
  /// Else what wheels say is a camera's own path (path_as_wheels): it tells which pictures are of
  /// one instant and nothing more, so that place, yaw and metre are as the rig is believed to be.
  bool has_wheels = true;
  double inlier_sigma = 3;  ///< by which an observation may be off
  int iterations = 50;
  /// What is known before (covariance_before), where numbers go together that are not known by
  /// themselves; empty where each is known to its sigma.
  Eigen::MatrixXd before;
  std::function<void()> each_step;  ///< is called at every step of the solver; may throw
  /// What no run makes surer: a lens is not what its model says, a floor is not plane, and places
  /// of what a picture shows lie off the same way whenever it is seen. So much were cameras off in
  /// rendered rooms, beyond their noise: lenses, and all cameras together against the floor, each
  /// coefficient of a distortion at the picture's edge, and cameras against one another.
  double systematic_lens_px = 0.025;
  double systematic_distortion_px = 0.005;
  double systematic_mounting_px = 0.005;
};

/// How far wheels and floor are off. What wheels are off by grows with the root of the way that
/// they roll, together: of a metre of it, so much.
struct MotionNoise {
  double way_m = 0.005;
  double across_m = 0.005;
  double turn_rad = 0.02;
  double height_m = 0.001;
  double tilt_rad = deg_to_rad(0.1);
};

/// What a run has of noise: standard deviations, of pictures of where a point is seen, each way.
struct RigNoise {
  double own_px = 0.1;    ///< of points of the camera's own map
  double other_px = 0.1;  ///< of points of other cameras' maps
  MotionNoise motion;
  /// By which a point slides (rig_reprojection_cost) when it is seen from e times nearer, or from a
  /// radian aside.
  double slide_rad = 0;
};

/// How well a rig is known by what was seen. The rows: for each camera its turn (rad) and its shift
/// (m) about and along the body's axes, its lens (lens_parameters) and its clock (s); then the
/// wheels' errors.
struct RigCovariance {
  std::vector<Eigen::Index> camera;  ///< where each camera's rows begin,
  Eigen::Index wheels = 0;           ///< and the wheels'
  Eigen::MatrixXd covariance;
  /// In words, by camera: what nothing has shown, and so stays as it was believed.
  std::vector<std::vector<std::string>> unobservable;

  /// Of the turn and the shift of a camera as another one sees it, about and along that one's axes.
  Eigen::Matrix<double, 6, 6> relative(const RigBundleState& state, std::size_t reference,
                                       std::size_t camera_seen) const;
};

struct RigBundle {
  RigBundleState state;
  RigCovariance known;
  std::vector<double> sigma_own_px;    ///< of observations, each way, by camera
  std::vector<double> sigma_other_px;  ///< of points of other cameras' maps
  double slide_rad = 0;                ///< RigNoise
  int observations = 0;                ///< that are believed
  int observations_other = 0;          ///< of these, of points of other cameras' maps
  int left_out = 0;
  double rms_before_px = 0;  ///< sqrt(mean(dx^2 + dy^2)) of the believed
  double rms_after_px = 0;
  bool has_wheels = true;   ///< RigBundleOptions
  bool tells_metre = true;  ///< else (a turn on the spot, no wheels) lengths are as believed
  int without_wheels = 0;   ///< stretches between instants of which they say nothing
  bool converged = false;
};

/// Bundle adjustment of a rig that drives over a level floor (thesis 4.3.6): its motion, mounting,
/// lenses and clocks within their sigmas, the wheels' errors and the points. Mountings are held by
/// what is seen alone; what nothing shows stays as `believed` has it, and is named. `tracks` are
/// told what is believed of them.
RigBundle adjust_rig(const RigBundleOptions& options, const std::vector<RigCamera>& believed,
                     const WheelReadings& wheels, RigTracks& tracks, const RigBundleState& start);

/// What that would tell of a rig that is as `truth` has it, of tracks and wheels that are off by
/// nothing but weighed as if they had this noise: nothing is learned, nothing solved.
RigBundle expect_rig(const RigBundleOptions& options, const std::vector<RigCamera>& believed,
                     const WheelReadings& wheels, RigTracks& tracks, const RigBundleState& truth,
                     const RigNoise& noise);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"

namespace ceres {
class CostFunction;
}

// Cost functions of a rig that drives over a floor. Poses are blocks of core/calib/pose_block.h;
// all residuals are in standard deviations. For the solver, which owns them.

namespace panoptes {

/// What odometry misses, besides noise: of the way and of the turn as a share, and how it turns
/// with the way (forward is positive: of unequal wheels, the way back undoes it).
enum WheelError : int { kWayError = 0, kTurnError = 1, kTurnPerMetre = 2, kWheelErrors = 3 };

/// How the body truly moved, by what the wheels say and what they err by (WheelError).
Pose2 truly_moved(const Pose2& by_wheels, const Vec3& wheel_errors);

/// What the wheels say from a keyframe's instant to when a camera took its picture, by a clock
/// offset of that camera.
struct BodyMoved {
  Pose2 T_instant_taken;
  Twist2 twist_body;  ///< then
  double clock_offset_s = 0;

  /// By another offset: a later clock means an earlier picture.
  Pose2 with_offset(double offset_s) const;
};

/// A point in homogeneous coordinates seen from another frame: that of (x, w) is x / w, and with w
/// = 0 it is a direction, which no shift changes. What is seen is in front, whatever sign w has.
Eigen::Vector4d seen_from(const Pose3& T, const Eigen::Vector4d& p);

/// By which turn (rad) about the body's axes and which shift (m) along them a camera is mounted
/// otherwise.
Eigen::Matrix<double, 6, 1> mounting_moved(const Pose3& from_T_body_camera,
                                           const Pose3& to_T_body_camera);

/// How that moves with the six moves of T_camera_body (pose_block.h), from small ones on.
Eigen::Matrix<double, 6, 6> mounting_by_moves(const Pose3& T_body_camera);

/// Of what a picture shows of a surface, no place stays quite where it is when it is seen from
/// nearer, or from aside: it slides, one way and another for each of both.
inline constexpr int kSlides = 4;

/// What its slides (rad) shift a point by in a view, as shares of its distance from the camera and
/// along start's axes: a column for each; no columns where it does not slide.
using BySlides = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kSlides>;

/// A point where a picture of a rig's camera shows it. Blocks: the lens (lens_parameters),
/// T_camera_body, T_body_start, the clock offset in s, the wheels' errors, the point in start
/// (homogeneous, as seen_from) and its slides.
ceres::CostFunction* rig_reprojection_cost(const Intrinsics& lens, const Vec2& seen_px,
                                           double sigma_px, const BodyMoved& moved,
                                           const BySlides& by_slides = {});

/// Two slides of a point, known to be none to a sigma: the solver is faster where all rows of a
/// point come by two. Block: the point with kSlides slides.
ceres::CostFunction* slides_cost(int first, double sigma_rad);

/// How well wheels tell a motion: wheels slip along the way rather than across it.
struct WheelSigma {
  double along_m = 1;
  double across_m = 1;
  double turn_rad = 1;
};

/// What the wheels say between two instants: along and across its chord, and the turn. Blocks:
/// T_body_start of both, the wheels' errors. What it is off by is in the wheels' own metres: in
/// true ones a shorter metre would make all noise less, and the metre shrink with every motion
/// told.
ceres::CostFunction* wheels_cost(const Pose2& T_before_now, const WheelSigma& sigma);

/// The body where `start` lies, but for what a level floor says. Block: T_body_start.
ceres::CostFunction* start_cost();

/// A body on a level floor, in the wheels' metres (as wheels_cost). Blocks: T_body_start, the
/// wheels' errors.
ceres::CostFunction* level_cost(double sigma_m, double sigma_rad);

/// How far a point of the body is from where it was in start, whose frame is the body's then.
/// Block: T_body_start.
ceres::CostFunction* away_cost(const Vec3& p_body, double away_m, double sigma_m);

/// Numbers that are known before, each to its sigma. One block.
ceres::CostFunction* known_cost(const Eigen::VectorXd& value, const Eigen::VectorXd& sigma);

/// What is known of a camera before: standard deviations of its mounting (rad, m, about and along
/// the body's axes), its lens (lens_parameters) and its clock (s), one after another.
Eigen::VectorXd sigmas_before(const CameraSigmas& known, const Eigen::VectorXd& lens);

/// Of what both focal lengths of a lens may be off, one may be alone: pixels are square, or as long
/// as the file says.
inline constexpr double kFocalApart = 0.1;

/// What is known of a lens before: both focal lengths move together, and what they are known to as
/// a share is the sigma of each coefficient of its distortion. Block: the lens.
ceres::CostFunction* lens_known_cost(const Intrinsics& lens, const CameraSigmas& known);

/// How a camera is mounted, as far as it is known before: its turn, and its place along the body's
/// axes. Block: T_camera_body.
ceres::CostFunction* mounting_known_cost(const Pose3& T_body_camera, double sigma_rad,
                                         const Vec3& sigma_m);

/// Cameras mounted as they are told to be along some directions, each a row of mounting_moved of
/// all of them, one after another, in standard deviations. Blocks: T_camera_body of each.
ceres::CostFunction* mountings_kept_cost(const std::vector<Pose3>& T_body_camera,
                                         const Eigen::MatrixXd& directions);

/// Numbers of some blocks, of which combinations are known: `weight` by what they are off, one
/// after another, in standard deviations. Blocks: those of `values`.
ceres::CostFunction* known_together_cost(const std::vector<Eigen::VectorXd>& values,
                                         const Eigen::MatrixXd& weight);

}  // namespace panoptes

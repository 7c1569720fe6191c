// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/rig.h"
#include "core/eval/hull_shadow.h"
#include "core/geometry/body.h"

namespace panoptes {

/// A bit for each camera of a rig, in the order of the cameras' names.
using CameraSet = std::uint64_t;
inline constexpr std::size_t kMostSightCameras = 64;

constexpr CameraSet camera_bit(std::size_t camera) { return CameraSet{1} << camera; }

/// Whether the robot's hull stands between the two: a cylinder about the middle of the wheel axle,
/// from the floor to `hull_height_m`. The mast on it is taken to be thin, as a body says no more of
/// it.
bool hidden_by_hull(const Body& body, const Vec3& eye_body, const Vec3& p_body);

/// A camera as it looks past its own robot.
class CameraSight {
 public:
  CameraSight(const RigCamera& camera, const Body& body);

  const RigCamera& camera() const { return camera_; }
  const Vec3& eye_body() const { return camera_.T_body_camera.translation; }

  /// Whether a point shows in the picture, with nothing around but the robot itself.
  bool sees(const Vec3& p_body) const;
  /// The same of what is far away in a direction.
  bool sees_direction(const Vec3& direction_body) const;
  /// Whether a point of the floor lies in the mapped part of a camera with the role `floor`. Of a
  /// lens that bends the straightened picture is mapped (core/camera/rectify.h).
  bool maps(const Vec2& p_body) const;

  /// Where the pixel looks, in `body`; empty where the lens draws nothing.
  std::optional<Vec3> direction_body(const Vec2& px) const;
  Vec3 in_camera(const Vec3& p_body) const;
  /// Whether the robot itself stands before a point: its faces where it has any, else a cylinder.
  bool hidden(const Vec3& p_body) const;

  /// Pixels a metre of what is shown there along two directions: columns of the result.
  Eigen::Matrix2d px_per_m(const Vec3& p_body, const Vec3& along_a, const Vec3& along_b) const;
  /// Metres of floor that a pixel covers there the longer way: the ground sampling distance.
  double sampling_m(const Vec2& p_body) const;

  /// Shares of the picture's pixels, of a coarse grid of them.
  double hull_share() const { return hull_share_; }    ///< that show the robot's hull
  double floor_share() const { return floor_share_; }  ///< that show the floor

 private:
  RigCamera camera_;
  Intrinsics mapped_lens_;
  Mat3 R_camera_body_;
  Body body_;
  std::shared_ptr<const HullShadow> shadow_;  // of a body with faces
  Vec2 heading_ = Vec2::UnitX();              // along the floor
  double widest_cos_ = -1;                    // nothing farther off the axis is seen
  double hull_share_ = 0;
  double floor_share_ = 0;
};

/// What the cameras of a rig see, each past the robot itself.
class RigSight {
 public:
  /// Of at most kMostSightCameras cameras.
  RigSight(const Rig& rig, const Body& body);

  const Body& body() const { return body_; }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<CameraSight>& cameras() const { return cameras_; }

  CameraSet seeing(const Vec3& p_body) const;
  CameraSet seeing_direction(const Vec3& direction_body) const;
  CameraSet mapping(const Vec2& p_body) const;

  CameraSet loop_cameras() const { return loop_cameras_; }    ///< with a role loop_...
  CameraSet floor_cameras() const { return floor_cameras_; }  ///< with the role floor

 private:
  Body body_;
  std::vector<std::string> names_;
  std::vector<CameraSight> cameras_;
  CameraSet loop_cameras_ = 0;
  CameraSet floor_cameras_ = 0;
};

/// Why such a rig cannot be, or is of no use to such a robot: a camera inside of the body, under
/// the floor, in another camera's place, one that sees nothing but the robot or, with the role
/// floor, no floor where it is to be mapped. A line each, which begins with the key; empty when all
/// is well.
std::vector<std::string> placement_faults(const Rig& rig, const Body& body);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/camera/joint_covariance.h"
#include "core/config/fields.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A lens that bends nothing.
struct NoDistortion {
  static constexpr std::string_view kName = "none";
  friend bool operator==(const NoDistortion&, const NoDistortion&) = default;
};

/// Brown 1971 and Conrady 1919, as OpenCV's calib3d has them.
struct BrownConrady {
  static constexpr std::string_view kName = "brown_conrady";
  double k1 = 0;
  double k2 = 0;
  double p1 = 0;
  double p2 = 0;
  double k3 = 0;
  friend bool operator==(const BrownConrady&, const BrownConrady&) = default;
};

/// Kannala and Brandt 2006, as OpenCV's fisheye has it: r = theta (1 + k1 theta^2 + ... + k4
/// theta^8).
struct Equidistant {
  static constexpr std::string_view kName = "equidistant";
  double k1 = 0;
  double k2 = 0;
  double k3 = 0;
  double k4 = 0;
  friend bool operator==(const Equidistant&, const Equidistant&) = default;
};

using Distortion = std::variant<NoDistortion, BrownConrady, Equidistant>;

/// A lens and its sensor: pixels (0, 0 at the centre of the top-left one) from points in the
/// camera's frame.
struct Intrinsics {
  int width_px = 320;
  int height_px = 240;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  Distortion distortion;

  bool is_pinhole() const { return std::holds_alternative<NoDistortion>(distortion); }

  /// z must be positive, but for Equidistant.
  Vec2 project(const Vec3& p_camera) const;

  /// Direction with z = 1, of a pixel that has one less than 90 degrees off the axis.
  Vec3 ray(const Vec2& px) const;

  /// Unit vector, also of what lies beside and behind a fisheye. Empty for a pixel so far out that
  /// the distortion bends back before it: nothing is seen there.
  std::optional<Vec3> direction(const Vec2& px) const;

  /// Whether a point falls on the picture.
  bool sees(const Vec3& p_camera) const;
};

/// A pinhole of this width of view with its centre in the middle of the picture.
Intrinsics pinhole(int width_px, int height_px, double horizontal_fov_rad);

/// The same for a lens that bends: what is seen from its left edge to its right one, p1 and p2
/// not counted.
Intrinsics lens_of_view(int width_px, int height_px, double horizontal_fov_rad,
                        const Distortion& distortion);

/// Why some pixels have no direction of their own; empty when all have.
std::string lens_fault(const Intrinsics& lens);

/// A surveyed mark: where it lies on the floor, and where the camera sees it.
struct FloorMark {
  Vec2 p_body = Vec2::Zero();
  Vec2 px = Vec2::Zero();
};

/// Which part of a floor camera's picture is mapped, and how its pixels fall on the floor. Pixels
/// are those of the picture as the camera gives it; only marks can say how a picture that a lens
/// bends falls on the floor.
struct FloorView {
  enum class Rows { kAll, kLowerHalf };
  Rows rows = Rows::kAll;
  double near_m = 0.2;            ///< along the floor from the body's front
  double far_m = 3.0;             ///< along the floor from the body's front
  std::vector<FloorMark> marks;   ///< four surveyed marks give the homography,
  std::optional<Mat3> H_body_px;  ///< or it is given: floor point in body (x, y, 1) ~ H * (u, v, 1)
};

/// How well what a rig file says of one camera is known: standard deviations. The defaults are what
/// a ruler, a data sheet and a look at the robot leave.
struct CameraSigmas {
  Vec3 rotation_rad = Vec3::Constant(deg_to_rad(1));  ///< roll, pitch, yaw, as in MountingOffset
  Vec3 position_m = Vec3::Constant(0.01);             ///< in body
  double focal_ratio = 0.005;                         ///< of both focal lengths together, relative
  double centre_px = 2;                               ///< of the principal point, each way
  double clock_s = 0.01;
};

/// Places are recognised by the pictures of a camera with this role: it begins with `loop_`.
bool is_loop_role(std::string_view role);

/// One camera as the robot believes it to be.
struct RigCamera {
  std::vector<std::string> roles;  ///< loop_front, loop_back, floor, stereo_left, ...
  double rate_hz = 15;
  Intrinsics intrinsics;
  Pose3 T_body_camera;
  std::optional<FloorView> floor;
  double clock_offset_s = 0;  ///< to be taken from its stamps, by the odometry's clock
  CameraSigmas sigma;

  bool has_role(std::string_view role) const;
  /// By any of its roles.
  bool is_loop() const;
};

/// What the robot believes it carries, by the cameras' names.
struct Rig {
  std::map<std::string, RigCamera> cameras;

  /// Where they were calibrated together. Only how parameters go together counts: how well each is
  /// known, its camera's sigma says.
  std::optional<JointCovariance> covariance;

  /// Why how they were calibrated is not to be trusted, a sentence each.
  std::vector<std::string> doubts;

  /// The name of the first camera (in order of name) with this role; empty when there is none.
  std::string with_role(std::string_view role) const;
};
void bind(Fields& f, NoDistortion& o);
void bind(Fields& f, BrownConrady& o);
void bind(Fields& f, Equidistant& o);
/// {distortion, size_px, and one of fov_deg, lens, intrinsics_px}
void bind(Fields& f, Intrinsics& o);
void bind(Fields& f, FloorMark& o);
void bind(Fields& f, FloorView& o);
/// {rotation_deg, position_m (one number or three), focal_percent, centre_px, clock_s}
void bind(Fields& f, CameraSigmas& o);
void bind(Fields& f, RigCamera& o);
/// {cameras, covariance: [{parameter, row}], doubts: [text]}
void bind(Fields& f, Rig& o);

}  // namespace panoptes

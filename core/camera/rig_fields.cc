// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <numbers>

#include "core/camera/rig.h"
#include "core/config/geometry_fields.h"

namespace panoptes {
namespace {

constexpr int kMaxSize_px = 8192;
constexpr double kMaxFov_rad = deg_to_rad(170);  // beyond it a pinhole's picture is all edge

// size_px with fov_deg, or size_px with intrinsics_px: [fx, fy, cx, cy].
void bind_intrinsics(Fields& f, Intrinsics& o) {
  std::vector<int> size{o.width_px, o.height_px};
  f("size_px", size, between(1, kMaxSize_px));
  f.require(size.size() == 2, "size_px", "must be [width, height]");
  size.resize(2, 1);
  if (f.writing() || f.present("intrinsics_px")) {
    f.require(!f.present("fov_deg") && !f.present("fov_rad"), "intrinsics_px",
              "must not be given beside the field of view");
    std::vector<double> numbers{o.fx_px, o.fy_px, o.cx_px, o.cy_px};
    f("intrinsics_px", numbers);
    f.require(numbers.size() == 4, "intrinsics_px", "must be [fx, fy, cx, cy]");
    if (numbers.size() == 4) {
      f.require(numbers[0] > 0 && numbers[1] > 0, "intrinsics_px",
                "must have focal lengths > 0 ([fx, fy, cx, cy])");
      o = {size[0], size[1], numbers[0], numbers[1], numbers[2], numbers[3], o.distortion};
    }
    return;
  }
  double fov_rad = 0;
  f.angle("fov", fov_rad, between(deg_to_rad(1), kMaxFov_rad));
  const bool given = f.present("fov_deg") || f.present("fov_rad");
  f.require(given, "fov_deg", "missing; it must be given (or intrinsics_px)");
  if (fov_rad > 0) {
    o = pinhole(size[0], size[1], fov_rad);
  }
}

// at_m, yaw_deg and tilt_deg, or T_body_camera.
void bind_mounting(Fields& f, Pose3& T_body_camera) {
  if (f.writing() || f.present("T_body_camera")) {
    f("T_body_camera", T_body_camera);
    f.require(!f.present("at_m"), "T_body_camera", "must not be given beside at_m");
    return;
  }
  Vec3 position_body = Vec3::Zero();
  double yaw_rad = 0;
  double tilt_rad = 0;
  f.needed("at_m", position_body);
  f.angle("yaw", yaw_rad, between(-2 * std::numbers::pi, 2 * std::numbers::pi));
  f.angle("tilt", tilt_rad, between(-std::numbers::pi / 2, std::numbers::pi / 2));
  T_body_camera = mounted_camera(position_body, yaw_rad, tilt_rad);
}

bool is_name(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

}  // namespace

void bind(Fields& f, FloorMark& o) {
  f.needed("p_body_m", o.p_body);
  f.needed("px", o.px);
}

void bind(Fields& f, FloorView& o) {
  f.word("rows", o.rows,
         {{"all", FloorView::Rows::kAll}, {"lower_half", FloorView::Rows::kLowerHalf}});
  f("near_m", o.near_m, not_negative);
  f("far_m", o.far_m, positive);
  f.require(o.far_m > o.near_m, "far_m", "must be > near_m");
  f("marks", o.marks);
  f.require(o.marks.empty() || o.marks.size() >= 4, "marks",
            "must be four or more, or none where they are surveyed before the run");
  f("homography", o.H_body_px);
}

void bind(Fields& f, RigCamera& o) {
  f("roles", o.roles);
  f("rate_hz", o.rate_hz, between(0.1, 1000));
  bind_intrinsics(f, o.intrinsics);
  bind_mounting(f, o.T_body_camera);
  f("floor", o.floor);
  f.require(!o.has_role("floor") || o.floor.has_value(), "floor",
            "missing; a camera with the role floor must say which part of its picture is mapped");
}

void bind(Fields& f, Rig& o) {
  f.needed("cameras", o.cameras);
  f.require(!o.cameras.empty(), "cameras", "must hold at least one camera");
  f.require(std::all_of(o.cameras.begin(), o.cameras.end(),
                        [](const auto& camera) { return is_name(camera.first); }),
            "cameras", "must be named by letters, digits, _ and - (their names become file names)");
}

}  // namespace panoptes

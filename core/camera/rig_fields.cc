// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "core/camera/rig.h"
#include "core/config/geometry_fields.h"

namespace panoptes {
namespace {

constexpr int kMaxSize_px = 8192;
// Beyond it a pinhole's picture is all edge.
constexpr double kMaxFov_rad = deg_to_rad(170);
// In widths (heights) of the picture: from beyond the widest fisheye to half a degree of view.
constexpr double kShortestFocal = 0.05;
constexpr double kLongestFocal = 100;
constexpr double kFarthestMount_m = 10;   // a mast; beyond it somebody wrote millimetres
constexpr double kLargestClock_s = 10;    // beyond it nobody drives by what is seen
constexpr double kFarthestFloor_m = 100;  // no camera on a robot tells floor from wall out there

// A lens and its sensor as data sheets have them.
struct LensSheet {
  double focal_mm = 0;
  std::optional<Vec2> sensor_mm;   // of the whole picture
  std::optional<double> pixel_um;  // or of one pixel
};

void bind(Fields& f, LensSheet& o) {
  f("focal_mm", o.focal_mm, positive);
  f.require(f.present("focal_mm"), "focal_mm", "missing; it must be given");
  f("sensor_mm", o.sensor_mm, positive);
  f("pixel_um", o.pixel_um, positive);
  f.require(o.sensor_mm.has_value() != o.pixel_um.has_value(),
            o.pixel_um ? "pixel_um" : "sensor_mm",
            o.pixel_um ? "must not be given beside sensor_mm"
                       : "missing; it must be given (or pixel_um)");
}

// A fisheye's corners see at most what is right behind it. In whole degrees, as it is told; of a
// lens that bends back before that another fault tells.
double widest_fov_rad(int width_px, int height_px, const Distortion& distortion) {
  if (!std::holds_alternative<Equidistant>(distortion)) {
    return kMaxFov_rad;
  }
  constexpr int kAllAround_deg = 360;
  int low_deg = 1;
  int high_deg = kAllAround_deg;
  double corner_rad = 0;
  while (high_deg - low_deg > 1) {
    const int middle_deg = (low_deg + high_deg) / 2;
    const auto corner = lens_of_view(width_px, height_px, deg_to_rad(middle_deg), distortion)
                            .direction({-0.5, -0.5});
    (corner ? low_deg : high_deg) = middle_deg;
    corner_rad = corner ? std::acos(corner->normalized().z()) : corner_rad;
  }
  const double step_rad = deg_to_rad(2);  // a degree of view is up to two in the corner
  const bool bends_back = corner_rad < std::numbers::pi - step_rad;
  return deg_to_rad(bends_back ? kAllAround_deg : low_deg);
}

// size_px and one of fov_deg, lens and intrinsics_px: [fx, fy, cx, cy].
void bind_view(Fields& f, Intrinsics& o) {
  std::vector<int> size{o.width_px, o.height_px};
  f("size_px", size, between(1, kMaxSize_px));
  f.require(size.size() == 2, "size_px", "must be [width, height]");
  size.resize(2, 1);
  double fov_rad = 0;
  if (!f.writing()) {
    f.angle("fov", fov_rad, between(deg_to_rad(1), widest_fov_rad(size[0], size[1], o.distortion)));
  }
  const bool view_given = f.present("fov_deg") || f.present("fov_rad");
  LensSheet sheet;
  if (f.present("lens")) {
    f.require(!view_given, "lens", "must not be given beside the field of view");
    f("lens", sheet);
  }
  if (f.writing() || f.present("intrinsics_px")) {
    f.require(!view_given, "intrinsics_px", "must not be given beside the field of view");
    f.require(!f.present("lens"), "intrinsics_px", "must not be given beside lens");
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
  if (f.present("lens")) {
    const Vec2 pixel_mm = sheet.sensor_mm
                              ? Vec2(sheet.sensor_mm->x() / size[0], sheet.sensor_mm->y() / size[1])
                              : Vec2::Constant(sheet.pixel_um.value_or(0) * 1e-3);
    if (sheet.focal_mm > 0 && pixel_mm.minCoeff() > 0) {
      o = {size[0],
           size[1],
           sheet.focal_mm / pixel_mm.x(),
           sheet.focal_mm / pixel_mm.y(),
           (size[0] - 1) / 2.0,
           (size[1] - 1) / 2.0,
           o.distortion};
    }
    return;
  }
  f.require(view_given, "fov_deg", "missing; it must be given (or lens, or intrinsics_px)");
  if (fov_rad > 0) {
    o = lens_of_view(size[0], size[1], fov_rad, o.distortion);
  }
}

// at_m, yaw_deg, tilt_deg and roll_deg, or T_body_camera.
void bind_mounting(Fields& f, Pose3& T_body_camera) {
  const auto require_on_robot = [&f](const char* key, const Vec3& eye_body) {
    f.require(eye_body.cwiseAbs().maxCoeff() <= kFarthestMount_m, key,
              "must be within 10 m of the robot's middle, in metres");
  };
  if (f.writing() || f.present("T_body_camera")) {
    f("T_body_camera", T_body_camera);
    f.require(!f.present("at_m"), "T_body_camera", "must not be given beside at_m");
    require_on_robot("T_body_camera", T_body_camera.translation);
    return;
  }
  Vec3 position_body = Vec3::Zero();
  double yaw_rad = 0;
  double tilt_rad = 0;
  double roll_rad = 0;
  f.needed("at_m", position_body);
  require_on_robot("at_m", position_body);
  f.angle("yaw", yaw_rad, between(-2 * std::numbers::pi, 2 * std::numbers::pi));
  f.angle("tilt", tilt_rad, between(-std::numbers::pi / 2, std::numbers::pi / 2));
  f.angle("roll", roll_rad, between(-std::numbers::pi, std::numbers::pi));
  T_body_camera = mounted_camera(position_body, yaw_rad, tilt_rad);
  if (roll_rad != 0) {
    T_body_camera.rotation =
        (T_body_camera.rotation * Eigen::AngleAxisd(roll_rad, Vec3::UnitZ())).normalized();
  }
}

struct CovarianceRow {
  std::string parameter;
  std::vector<double> row;
};

void bind(Fields& f, CovarianceRow& o) {
  f.needed("parameter", o.parameter);
  f.needed("row", o.row);
}

std::string key_of_row(std::size_t i, const char* what) {
  return fmt::format("covariance[{}].{}", i, what);
}

constexpr std::size_t kMountingParameters = 6;  // the first of a camera's: its turn, its place

/// Whether the rows are those of cameras of the rig in order, each whole, or of its mounting alone.
bool has_right_order(Fields& f, const Rig& rig, const std::vector<CovarianceRow>& rows) {
  std::vector<std::string> told;  // cameras
  std::size_t i = 0;
  while (i < rows.size()) {
    const std::string camera = rows[i].parameter.substr(0, rows[i].parameter.find('.'));
    const auto found = rig.cameras.find(camera);
    const bool anew = std::find(told.begin(), told.end(), camera) == told.end();
    if (found == rig.cameras.end() || !anew) {
      f.require(false, key_of_row(i, "parameter"),
                anew ? "must be of a camera of the rig, as CAMERA.rotation_x_rad"
                     : "must not be of a camera that had its rows before");
      return false;
    }
    told.push_back(camera);
    const std::size_t first = i;
    for (const std::string& expected : joint_parameters(camera, found->second.intrinsics)) {
      const bool ends = i == rows.size() || !rows[i].parameter.starts_with(camera + ".");
      if (ends && i == first + kMountingParameters) {
        break;
      }
      if (i == rows.size()) {
        f.require(false, "covariance", "must go on with a row of " + expected);
        return false;
      }
      if (rows[i].parameter != expected) {
        f.require(false, key_of_row(i, "parameter"), "must be " + expected);
        return false;
      }
      ++i;
    }
  }
  return true;
}

/// No direction in which it is negative, each parameter counted in its sigmas.
bool is_semi_definite(const Eigen::MatrixXd& covariance) {
  if (covariance.diagonal().minCoeff() < 0) {
    return false;
  }
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd by = (sigma.array() > 0).select(sigma.cwiseInverse(), 1);
  const Eigen::MatrixXd scaled = by.asDiagonal() * covariance * by.asDiagonal();
  constexpr double kRoundoff = 1e-6;  // of what an inversion leaves
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
             .eigenvalues()
             .minCoeff() >= -kRoundoff;
}

std::optional<Eigen::MatrixXd> checked_matrix(Fields& f, const std::vector<CovarianceRow>& rows) {
  const auto size = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd covariance(size, size);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].row.size() != rows.size()) {
      f.require(false, key_of_row(i, "row"),
                fmt::format("must have a number for each of the {} rows, got {}", rows.size(),
                            rows[i].row.size()));
      return std::nullopt;
    }
    covariance.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVectorXd>(rows[i].row.data(), size);
  }
  constexpr double kPrinted = 1e-6;  // a few digits may be missing
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) {
      const double most = kPrinted * std::sqrt(std::abs(covariance(i, i) * covariance(k, k)));
      if (std::abs(covariance(i, k) - covariance(k, i)) > most) {
        f.require(false, key_of_row(static_cast<std::size_t>(i), "row"),
                  fmt::format("must say of {} what the row of {} says of it: {} is not {}",
                              rows[static_cast<std::size_t>(k)].parameter,
                              rows[static_cast<std::size_t>(i)].parameter, covariance(i, k),
                              covariance(k, i)));
        return std::nullopt;
      }
    }
  }
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  if (!is_semi_definite(covariance)) {
    f.require(false, "covariance", "must be positive semi-definite, as every covariance is");
    return std::nullopt;
  }
  return covariance;
}

void bind_covariance(Fields& f, Rig& o) {
  std::optional<std::vector<CovarianceRow>> rows;
  if (f.writing()) {
    if (!o.covariance) {
      return;
    }
    rows.emplace();
    for (std::size_t i = 0; i < o.covariance->parameters.size(); ++i) {
      const Eigen::VectorXd row = o.covariance->covariance.row(static_cast<Eigen::Index>(i));
      rows->push_back({o.covariance->parameters[i], {row.begin(), row.end()}});
    }
    f("covariance", rows);
    return;
  }
  f("covariance", rows);
  o.covariance.reset();
  if (!rows || rows->empty() || !has_right_order(f, o, *rows)) {
    return;
  }
  if (std::optional<Eigen::MatrixXd> matrix = checked_matrix(f, *rows)) {
    JointCovariance& joint = o.covariance.emplace();
    for (const CovarianceRow& row : *rows) {
      joint.parameters.push_back(row.parameter);
    }
    joint.covariance = std::move(*matrix);
  }
}

bool is_name(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

}  // namespace

void bind(Fields&, NoDistortion&) {}

void bind(Fields& f, BrownConrady& o) {
  f("k1", o.k1);
  f("k2", o.k2);
  f("p1", o.p1);
  f("p2", o.p2);
  f("k3", o.k3);
}

void bind(Fields& f, Equidistant& o) {
  f("k1", o.k1);
  f("k2", o.k2);
  f("k3", o.k3);
  f("k4", o.k4);
}

void bind(Fields& f, Intrinsics& o) {
  f.choice("distortion", o.distortion);
  bind_view(f, o);
  if (o.fx_px > 0 && o.fy_px > 0) {
    const auto sensible = [](double focal_px, int size_px) {
      return focal_px >= kShortestFocal * size_px && focal_px <= kLongestFocal * size_px;
    };
    f.require(sensible(o.fx_px, o.width_px) && sensible(o.fy_px, o.height_px),
              f.present("lens") ? "lens" : "intrinsics_px",
              "must have focal lengths of 0.05 to 100 times the picture's size (widths for fx, "
              "heights for fy); correct their unit");
    f.require(std::abs(o.cx_px - o.width_px / 2.0) <= o.width_px &&
                  std::abs(o.cy_px - o.height_px / 2.0) <= o.height_px,
              "intrinsics_px",
              "must have cx and cy no farther from the middle of the picture than its own size");
    const bool axis_inside =
        o.cx_px > 0 && o.cy_px > 0 && o.cx_px < o.width_px - 1 && o.cy_px < o.height_px - 1;
    f.require(o.is_pinhole() || axis_inside, "intrinsics_px",
              "must have cx and cy inside the picture where there is a distortion");
    const std::string fault = axis_inside ? lens_fault(o) : "";
    f.require(fault.empty(), "distortion", fault);
  }
}

void bind(Fields& f, FloorMark& o) {
  f.needed("p_body_m", o.p_body);
  f.needed("px", o.px);
}

void bind(Fields& f, FloorView& o) {
  f.word("rows", o.rows,
         {{"all", FloorView::Rows::kAll}, {"lower_half", FloorView::Rows::kLowerHalf}});
  f("near_m", o.near_m, not_negative);
  f("far_m", o.far_m, between(0.01, kFarthestFloor_m));
  f.require(o.far_m > o.near_m, "far_m", "must be > near_m");
  f("marks", o.marks);
  f.require(o.marks.empty() || o.marks.size() >= 4, "marks",
            "must be four or more, or none where they are surveyed before the run");
  f("homography", o.H_body_px);
}

void bind(Fields& f, CameraSigmas& o) {
  f.one_angle_or_each("rotation", o.rotation_rad, between(0, std::numbers::pi));
  f.one_or_each("position_m", o.position_m, between(0, kFarthestMount_m));
  if (f.writing()) {
    f("focal_ratio", o.focal_ratio);  // the very bits
  } else {
    const bool twice = f.present("focal_percent") && f.present("focal_ratio");
    f.require(!twice, "focal_ratio", "given twice; focal_percent says it already");
    double percent = 0;
    f("focal_percent", percent, between(0, 100));
    f("focal_ratio", o.focal_ratio, between(0, 1));
    o.focal_ratio = f.present("focal_percent") ? percent / 100 : o.focal_ratio;
  }
  f("centre_px", o.centre_px, between(0, kMaxSize_px));
  f("clock_s", o.clock_s, between(0, kLargestClock_s));
}

void bind(Fields& f, RigCamera& o) {
  f("roles", o.roles);
  f("rate_hz", o.rate_hz, [](double rate_hz) {
    return rate_hz == 0 || (rate_hz >= 0.1 && rate_hz <= 1000)
               ? std::string()
               : "must be from 0.1 to 1000, or 0 for a camera that takes pictures only when it "
                 "is asked to";
  });
  for (const std::string& role : o.roles) {
    f.require(o.rate_hz > 0 || (role != "floor" && !is_loop_role(role)), "rate_hz",
              "must be > 0 of a camera with the role " + role +
                  ", whose pictures the navigator waits for");
  }
  bind(f, o.intrinsics);
  bind_mounting(f, o.T_body_camera);
  f("floor", o.floor);
  f.require(!o.has_role("floor") || o.floor.has_value(), "floor",
            "missing; a camera with the role floor must say which part of its picture is mapped");
  f.require(o.intrinsics.is_pinhole() || !o.floor || !o.floor->H_body_px, "floor",
            "must not have a homography where the lens bends straight lines; give marks");
  f("clock_offset_s", o.clock_offset_s, between(-kLargestClock_s, kLargestClock_s));
  f("sigma", o.sigma);
}

void bind(Fields& f, Rig& o) {
  f.needed("cameras", o.cameras);
  f.require(std::all_of(o.cameras.begin(), o.cameras.end(),
                        [](const auto& camera) { return is_name(camera.first); }),
            "cameras", "must be named by letters, digits, _ and - (their names become file names)");
  bind_covariance(f, o);
  if (!f.writing() || !o.doubts.empty()) {
    f("doubts", o.doubts);
  }
}

}  // namespace panoptes

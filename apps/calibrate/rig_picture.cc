// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/calibrate/drawn_ellipse.h"
#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"
#include "apps/draw/plan_picture.h"
#include "core/base/text.h"
#include "core/eval/statistics.h"

namespace panoptes {
namespace {

constexpr double kMargin = 20;
constexpr double kTitle = 46;
constexpr double kLine = 22;
constexpr double kSide = 620;
constexpr double kWidestWedge_rad = deg_to_rad(60);
const double kOf95 = std::sqrt(5.991);  // chi-squared of two numbers

/// A square of the canvas that shows a square of a plane, x right and y up.
struct Square {
  Vec2 low_px;
  Vec2 middle = Vec2::Zero();
  double half = 1;

  Vec2 at(const Vec2& p) const {
    const Vec2 d = (p - middle) * (kSide / (2 * half));
    return low_px + Vec2(kSide / 2 + d.x(), kSide / 2 - d.y());
  }
  void draw_scale_bar(Canvas& canvas, double length_m) const {
    canvas.scale_bar(low_px + Vec2(kSide, kSide + 22), length_m, kSide / (2 * half));
  }
  bool shows(const Vec2& p) const { return (p - middle).cwiseAbs().maxCoeff() < half; }
};

double draw_grid(const Square& square, Canvas& canvas) {
  const double step = round_step(2 * square.half, 10);
  for (int axis = 0; axis < 2; ++axis) {
    for (const double v :
         round_values(square.middle[axis] - square.half, square.middle[axis] + square.half, step)) {
      Vec2 a = square.middle - Vec2::Constant(square.half);
      Vec2 b = square.middle + Vec2::Constant(square.half);
      a[axis] = b[axis] = v;
      canvas.line(square.at(a), square.at(b), kGridColour, 1);
    }
  }
  return step;
}

struct LegendEntry {
  std::string words;
  std::optional<std::size_t> camera;  ///< else it is of the path
  double mark = 14;                   ///< room before the words
  Vec2 at = Vec2::Zero();             ///< below what the map is called
};

/// Of the map, in as many lines as it takes.
std::vector<LegendEntry> map_legend(const RigCalibration& calibration) {
  std::vector<std::size_t> points(calibration.cameras.size(), 0);
  for (const int map : calibration.map_of_point) {
    ++points[static_cast<std::size_t>(map)];
  }
  std::vector<LegendEntry> entries;
  for (std::size_t c = 0; c < points.size(); ++c) {
    entries.push_back(
        {fmt::format("{}: {}", calibration.cameras[c], counted(points[c], "point")), c});
  }
  entries.push_back({"path of the robot", std::nullopt, 30});
  Vec2 at(0, kLine);
  for (LegendEntry& entry : entries) {
    const double needs = entry.mark + Canvas::text_width(entry.words, 15) + 20;
    if (at.x() + needs > kSide) {
      at = Vec2(0, at.y() + kLine);
    }
    entry.at = at;
    at.x() += needs;
  }
  return entries;
}

void draw_map(const RigCalibration& calibration, Canvas& canvas, Square square) {
  const RigBundleState& state = calibration.bundle.state;
  std::vector<double> xs;
  std::vector<double> ys;
  for (const Vec3& p : state.points_start) {
    xs.push_back(p.x());
    ys.push_back(p.y());
  }
  if (!xs.empty()) {  // what nearly all of the points lie in
    const Vec2 low(quantile(xs, 0.02), quantile(ys, 0.02));
    const Vec2 high(quantile(xs, 0.98), quantile(ys, 0.98));
    square.middle = (low + high) / 2;
    square.half = 0.58 * (high - low).maxCoeff();
  }
  const double step = draw_grid(square, canvas);
  for (std::size_t i = 0; i < state.points_start.size(); ++i) {
    const Vec2 p = state.points_start[i].head<2>();
    if (square.shows(p)) {
      canvas.disc(square.at(p), 2.2,
                  nth_colour(static_cast<std::size_t>(calibration.map_of_point[i])));
    }
  }
  std::vector<Vec2> path;
  for (const Pose3& T : state.T_start_body) {
    path.push_back(square.at(T.translation.head<2>()));
  }
  canvas.polyline(path, kInk, 1.5);
  canvas.frame(square.low_px, square.low_px + Vec2::Constant(kSide), kFaint, 1);
  const Vec2 below = square.low_px + Vec2(0, kSide + 22);
  canvas.text("The joint map from above", below, kInk);
  square.draw_scale_bar(canvas, step);
  for (const LegendEntry& entry : map_legend(calibration)) {
    const Vec2 at = below + entry.at;
    canvas.text(entry.words, at + Vec2(entry.mark, 0), kInk);
    if (entry.camera) {
      canvas.disc(at + Vec2(5, -5), 4, nth_colour(*entry.camera));
    } else {
      canvas.line(at + Vec2(0, -5), at + Vec2(22, -5), kInk, 2);
    }
  }
}

/// Of where a camera is, as the first one sees it; of the first one in the body, where wheels tell.
/// In body.
Mat2 place_covariance(const RigCalibration& calibration, std::size_t c) {
  const RigBundleState& state = calibration.bundle.state;
  const RigCovariance& known = calibration.bundle.known;
  if (c == 0 && !calibration.bundle.has_wheels) {
    return Mat2::Zero();
  }
  if (c == 0) {
    return known.covariance.block<2, 2>(known.camera[0] + 3, known.camera[0] + 3);
  }
  const Mat3 R = state.T_body_camera.front().rotation.toRotationMatrix();
  return (R * known.relative(state, 0, c).block<3, 3>(3, 3) * R.transpose()).topLeftCorner<2, 2>();
}

void draw_mounting(const RigCalibration& calibration, const Rig& believed, Canvas& canvas,
                   Square square) {
  const RigBundleState& state = calibration.bundle.state;
  double far_m = 0.05;
  double sigma_m = 0;
  std::vector<Mat2> covariance_m2;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    far_m = std::max(far_m, state.T_body_camera[c].translation.head<2>().norm());
    covariance_m2.push_back(place_covariance(calibration, c));
    sigma_m = std::max(sigma_m, std::sqrt(covariance_m2.back().trace()));
  }
  square.half = 1.6 * far_m;
  const double step = draw_grid(square, canvas);
  // Ellipses are drawn so much larger that they can be seen.
  double enlarged = 1;
  while (sigma_m > 0 && kOf95 * sigma_m * enlarged * 10 < far_m / 2) {
    enlarged *= 10;
  }
  canvas.cross(square.at(Vec2::Zero()), 7, kFaint, 1.5);
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const Pose3& T = state.T_body_camera[c];
    const Pose3& before = believed.cameras.at(calibration.cameras[c]).T_body_camera;
    const Colour colour = nth_colour(c);
    canvas.ring(square.at(before.translation.head<2>()), 6, kFaint, 1.5);
    const Vec2 eye = T.translation.head<2>();
    const Vec2 ahead = (T.rotation * Vec3::UnitZ()).head<2>();
    // what it sees of, no wider than tells where it looks
    const double half_rad = std::min(
        kWidestWedge_rad, std::atan(state.lenses[c].width_px / (2 * state.lenses[c].fx_px)));
    for (const double side_rad : {-half_rad, half_rad}) {
      const Vec2 edge = Eigen::Rotation2Dd(side_rad) * ahead;
      canvas.line(square.at(eye), square.at(eye + 0.35 * far_m * edge), colour, 1.5);
    }
    canvas.disc(square.at(eye), 4, colour);
    std::vector<Vec2> line = drawn_ellipse(eye, covariance_m2[c], kOf95 * enlarged);
    std::transform(line.begin(), line.end(), line.begin(),
                   [&square](const Vec2& p) { return square.at(p); });
    canvas.polyline(line, colour, 1.5);
    canvas.label(calibration.cameras[c], square.at(eye + 0.42 * far_m * ahead), colour, 15, 0.5);
  }
  canvas.frame(square.low_px, square.low_px + Vec2::Constant(kSide), kFaint, 1);
  const Vec2 below = square.low_px + Vec2(0, kSide + 22);
  canvas.text("The rig from above, the robot's front to the right", below, kInk);
  square.draw_scale_bar(canvas, step);
  canvas.ring(below + Vec2(8, kLine - 5), 6, kFaint, 1.5);
  canvas.text("as the rig file has it", below + Vec2(22, kLine), kInk);
  canvas.cross(below + Vec2(228, kLine - 5), 5, kFaint, 1.5);
  canvas.text("origin of the body, between its wheels", below + Vec2(242, kLine), kInk);
  const std::string& first = calibration.cameras.front();
  canvas.text(fmt::format("95 % ellipses{}: {}",
                          enlarged > 1 ? fmt::format(", {:g} times", enlarged) : std::string(),
                          calibration.bundle.has_wheels
                              ? fmt::format("of {} in the body, others' as it sees them", first)
                              : fmt::format("of places as {} sees them", first)),
              below + Vec2(0, 2 * kLine), kInk);
}

}  // namespace

cv::Mat draw_rig(const RigCalibration& calibration, const Rig& believed, Verdict verdict) {
  const double legend = std::max(2 * kLine, map_legend(calibration).back().at.y());
  Canvas canvas(static_cast<int>(2 * kSide + 3 * kMargin),
                static_cast<int>(kTitle + kSide + legend + 2 * kLine), kPaper);
  canvas.text(fmt::format("{}: {}, {} keyframes, {} observations, {} of other cameras' points; "
                          "reprojection {:.2f} px",
                          name(verdict), counted(calibration.cameras.size(), "camera"),
                          calibration.tracks.instants.size(), calibration.bundle.observations,
                          calibration.bundle.observations_other, calibration.bundle.rms_after_px),
              {kMargin, 30}, kInk, 18);
  draw_map(calibration, canvas, {Vec2(kMargin, kTitle)});
  draw_mounting(calibration, believed, canvas, {Vec2(2 * kMargin + kSide, kTitle)});
  return canvas.shrunk();
}

}  // namespace panoptes

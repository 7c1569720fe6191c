// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/render/renderer.h"
#include "sim/sensors/camera_sensor.h"

// OpenCV's calibration, which knows nothing of us, finds the lens that was simulated.

namespace panoptes::sim {
namespace {

constexpr int kColumns = 9;  // of inner corners
constexpr int kRows = 6;
constexpr double kSquare_m = 0.03;
constexpr std::size_t kPictures = 72;

/// A chessboard with a white border a square wide. The middle of the inner corners lies in the
/// origin of the scene, the columns run along x, the rows along y, and it is seen from below (-z).
World board_world() {
  // A power of two, so that it is not drawn anew in another size, and so coarse that the edges are
  // soft over a pixel or two, as a lens makes them.
  constexpr int kTexel = 8;  // a square
  constexpr int kSquares = 16;
  cv::Mat bgr(kSquares * kTexel, kSquares * kTexel, CV_8UC3, cv::Scalar::all(230));
  for (int row = 0; row <= kRows; ++row) {
    for (int column = 0; column <= kColumns; ++column) {
      if ((row + column) % 2 == 0) {
        bgr(cv::Rect((column + 1) * kTexel, (row + 1) * kTexel, kTexel, kTexel)).setTo(20);
      }
    }
  }
  const double x_m = (kColumns + 3) * kSquare_m / 2;
  const double y_m = (kRows + 3) * kSquare_m / 2;
  const double u = (kColumns + 3.0) / kSquares;
  const double v = (kRows + 3.0) / kSquares;
  const Corner a{{-x_m, -y_m, 0}, {0, 0}};
  const Corner b{{x_m, -y_m, 0}, {u, 0}};
  const Corner c{{x_m, y_m, 0}, {u, v}};
  const Corner d{{-x_m, y_m, 0}, {0, v}};
  World world;
  world.ambient = 0.8;
  world.textures = {{"board", bgr}};
  Object board;
  board.name = "board";
  board.triangles = {{{a, d, c}, 0}, {{a, c, b}, 0}};
  world.objects = {board};
  return world;
}

struct Seen {
  std::vector<std::vector<cv::Point3f>> p_board;
  std::vector<std::vector<cv::Point2f>> px;
};

/// Pictures of the board in every part of the picture, from many sides, and the corners that OpenCV
/// finds in them.
Seen corners_seen(const Intrinsics& lens, double near_m, double far_m) {
  Renderer renderer(board_world());
  SensorOptions sensor;
  sensor.exposure = FixedExposure{};  // for the board's white, whatever else is in the picture
  CameraSensor camera("calibrated", lens, sensor, Rng(1));
  const CameraSensor::Draw draw = [&renderer](const View& view, const RenderOutputs& outputs) {
    return renderer.draw(view, outputs);
  };
  std::vector<cv::Point3f> p_board;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      p_board.emplace_back(static_cast<float>((column - (kColumns - 1) / 2.0) * kSquare_m),
                           static_cast<float>((row - (kRows - 1) / 2.0) * kSquare_m), 0.0F);
    }
  }
  Seen seen;
  Rng rng(2);
  constexpr int kParts = 6;  // of the picture, each way
  constexpr int kMostLooks = 6000;
  for (int i = 0; i < kMostLooks && seen.px.size() < kPictures; ++i) {
    // The board's middle somewhere in the part whose turn it is.
    const auto turn = static_cast<int>(seen.px.size()) % (kParts * kParts);
    const int row = turn / kParts;
    const double x = (turn % kParts + rng.uniform()) / kParts;
    const double y = (row + rng.uniform()) / kParts;
    const Vec2 at(x * lens.width_px, y * lens.height_px);
    const Vec3 d_camera = lens.direction(at).value();
    const Eigen::Quaterniond facing = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), d_camera);
    const double axis_rad = rng.uniform(-3, 3);
    const Vec3 axis(std::cos(axis_rad), std::sin(axis_rad), 0);
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(rng.uniform(-0.6, 0.6), axis));
    const Eigen::Quaterniond roll(Eigen::AngleAxisd(rng.uniform(-0.5, 0.5), Vec3::UnitZ()));
    const Pose3 T_camera_board{facing * tilt * roll, d_camera * rng.uniform(near_m, far_m)};
    const bool whole = std::all_of(p_board.begin(), p_board.end(), [&](const cv::Point3f& p) {
      return lens.sees(T_camera_board * (Vec3(p.x, p.y, p.z) * 1.1));
    });
    if (!whole) {
      continue;
    }
    const cv::Mat bgr =
        camera.take(draw, [&T_camera_board](Duration) { return T_camera_board.inverse(); }, i, {})
            .bgr;
    cv::Mat grey;
    cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
    std::vector<cv::Point2f> px;
    if (!cv::findChessboardCorners(grey, {kColumns, kRows}, px,
                                   cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FAST_CHECK)) {
      continue;
    }
    cv::cornerSubPix(grey, px, {5, 5}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4});
    seen.px.push_back(px);
    seen.p_board.push_back(p_board);
  }
  return seen;
}

/// How far apart at most two lenses draw the same things over the picture, after one has been
/// shifted to where it fits: a camera turned a little sees the same.
double worst_px(const Intrinsics& a, const Intrinsics& b) {
  std::vector<Vec2> apart;
  Vec2 sum = Vec2::Zero();
  for (int v = 0; v < a.height_px; v += 5) {
    for (int u = 0; u < a.width_px; u += 5) {
      const Vec2 px(u, v);
      apart.push_back(b.project(a.direction(px).value()) - px);
      sum += apart.back();
    }
  }
  const Vec2 shift = sum / static_cast<double>(apart.size());
  double worst = 0;
  for (const Vec2& one : apart) {
    worst = std::max(worst, (one - shift).norm());
  }
  return worst;
}

void expect_recovered(const Intrinsics& lens, const Intrinsics& found) {
  constexpr double kFocal = 0.005;
  constexpr double kCentre_px = 1;
  constexpr double kField_px = 0.2;
  EXPECT_NEAR(found.fx_px / lens.fx_px, 1, kFocal);
  EXPECT_NEAR(found.fy_px / lens.fy_px, 1, kFocal);
  EXPECT_NEAR(found.cx_px, lens.cx_px, kCentre_px);
  EXPECT_NEAR(found.cy_px, lens.cy_px, kCentre_px);
  EXPECT_LT(worst_px(lens, found), kField_px);
}

TEST(Calibration, FindsABrownConradyLens) {
  Intrinsics lens =
      lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.25, 0.07, 0.001, -0.0008, 0});
  lens.cx_px += 6.3;
  lens.cy_px -= 4.6;
  const Seen seen = corners_seen(lens, 0.35, 0.8);
  ASSERT_EQ(seen.px.size(), kPictures);
  cv::Matx33d K;
  std::vector<double> d;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  cv::calibrateCamera(seen.p_board, seen.px, {lens.width_px, lens.height_px}, K, d, rotations,
                      translations, cv::CALIB_FIX_K3);
  expect_recovered(lens, {640, 480, K(0, 0), K(1, 1), K(0, 2), K(1, 2),
                          BrownConrady{d[0], d[1], d[2], d[3], d[4]}});
}

TEST(Calibration, FindsAFisheye) {
  Intrinsics lens =
      lens_of_view(640, 480, deg_to_rad(130), Equidistant{-0.015, 0.004, -0.001, 0.0002});
  lens.cx_px += 6.3;
  lens.cy_px -= 4.6;
  const Seen seen = corners_seen(lens, 0.2, 0.45);
  ASSERT_GE(seen.px.size(), 3 * kPictures / 4);  // OpenCV misses a board that is bent too much
  cv::Mat1d K = (cv::Mat1d(3, 3) << 250, 0, 320, 0, 250, 240, 0, 0, 1);
  cv::Mat1d d(1, 4, 0.0);
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  cv::fisheye::calibrate(seen.p_board, seen.px, {lens.width_px, lens.height_px}, K, d, rotations,
                         translations,
                         cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW |
                             cv::fisheye::CALIB_USE_INTRINSIC_GUESS);
  expect_recovered(
      lens, {640, 480, K(0, 0), K(1, 1), K(0, 2), K(1, 2), Equidistant{d(0), d(1), d(2), d(3)}});
}

}  // namespace
}  // namespace panoptes::sim

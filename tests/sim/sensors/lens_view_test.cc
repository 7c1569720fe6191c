// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lens_view.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/sim/sensors/sphere.h"

namespace panoptes::sim {
namespace {

struct Case {
  std::string name;
  Intrinsics lens;
};

std::vector<Case> lenses() {
  const auto seen = [](double fov_deg, const Distortion& d) {
    return lens_of_view(320, 240, deg_to_rad(fov_deg), d);
  };
  Intrinsics off_centre = seen(90, BrownConrady{-0.2, 0.03, 0.002, -0.001, 0});
  off_centre.cx_px += 12;
  off_centre.cy_px -= 9;
  return {{"pinhole", seen(80, NoDistortion{})},
          {"barrel", seen(80, BrownConrady{-0.28, 0.09, 0.0012, -0.0007, 0})},
          {"pincushion", seen(80, BrownConrady{0.15, 0.02, 0, 0, 0})},
          {"off centre", off_centre},
          {"fisheye 100", seen(100, Equidistant{0.01, -0.002, 0, 0})},
          {"fisheye 130", seen(130, Equidistant{})},
          {"fisheye 180", seen(180, Equidistant{-0.01, 0, 0, 0})},
          {"fisheye 220", seen(220, Equidistant{})}};
}

const Pose3 kTurned{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3(0.3, -1, 0.5).normalized())),
                    Vec3::Zero()};

// Smooth, so that a part of a pixel changes little, and bright enough to see rounding alone.
Vec3 smooth(const Vec3& d_scene) {
  return {std::pow(0.5 + 0.3 * std::sin(3 * d_scene.x()), 2),
          std::pow(0.5 + 0.3 * std::sin(4 * d_scene.y()), 2),
          std::pow(0.5 + 0.3 * std::sin(5 * d_scene.z()), 2)};
}

Drawn draw_smooth(const View& view, const Ask& ask) { return draw_sphere(smooth, view, ask); }

TEST(LensView, ShowsWhatTheLensSees) {
  for (const auto& [name, lens] : lenses()) {
    LensView view(lens);
    const cv::Mat bgr = view.draw(draw_smooth, kTurned, 1, {}).bgr;
    double worst_grey = 0;
    for (int v = 0; v < lens.height_px; ++v) {
      for (int u = 0; u < lens.width_px; ++u) {
        const Vec3 d_scene = kTurned.rotation * lens.direction(Vec2(u, v)).value();
        const Vec3 expected = smooth(d_scene).cwiseSqrt() * 255;
        for (int i = 0; i < 3; ++i) {
          worst_grey = std::max(worst_grey, std::abs(bgr.at<cv::Vec3b>(v, u)[i] - expected[i]));
        }
      }
    }
    // Two roundings, and a 64th of a pixel of the map where it changes by up to 6 levels a pixel.
    constexpr double kGreyLevels = 1.5;
    EXPECT_LT(worst_grey, kGreyLevels) << name;
  }
}

TEST(LensView, TheTruthLiesUnderThePicture) {
  const Ask ask{.floor_label = true, .depth = true, .instance = true};
  for (const auto& [name, lens] : lenses()) {
    LensView view(lens);
    const Drawn drawn = view.draw(draw_smooth, kTurned, 1, ask);
    int wrong_labels = 0;
    int wrong_instances = 0;
    double worst_m = 0;
    for (int v = 0; v < lens.height_px; ++v) {
      for (int u = 0; u < lens.width_px; ++u) {
        const Vec3 d_camera = lens.direction(Vec2(u, v)).value();
        const Vec3 d_scene = kTurned.rotation * d_camera;
        wrong_labels += (drawn.floor_label.at<std::uint8_t>(v, u) != 0) != (d_scene.z() < 0);
        wrong_instances +=
            drawn.instance.at<std::uint16_t>(v, u) != 1 + (d_scene.x() < 0) + 2 * (d_scene.y() < 0);
        worst_m =
            std::max(worst_m, std::abs(drawn.depth_m.at<float>(v, u) - kSphere_m * d_camera.z()));
      }
    }
    // The borders between labels, a few lines through the picture, may be half a pixel off.
    const int on_borders = 2 * (lens.width_px + lens.height_px);
    EXPECT_LT(wrong_labels, on_borders) << name;
    EXPECT_LT(wrong_instances, on_borders) << name;
    // Half a drawn pixel, 1/70 rad at the coarsest, on a sphere of 3 m.
    constexpr double kHalfAPixel_m = 0.04;
    EXPECT_LT(worst_m, kHalfAPixel_m) << name;
  }
}

TEST(LensView, HasNoBorder) {
  const auto white = [](const View& view, const Ask&) {
    Drawn out;
    out.bgr =
        cv::Mat(view.intrinsics.height_px, view.intrinsics.width_px, CV_8UC3, cv::Scalar::all(255));
    return out;
  };
  for (const auto& [name, lens] : lenses()) {
    LensView view(lens);
    const cv::Mat bgr = view.draw(white, kTurned, 1, {}).bgr;
    EXPECT_EQ(cv::countNonZero(bgr.reshape(1) != 255), 0) << name;
  }
}

TEST(LensView, DrawsLittleMoreThanThePicture) {
  for (const auto& [name, lens] : lenses()) {
    const LensView view(lens);
    double pixels = 0;
    for (const LensView::Face& face : view.faces()) {
      pixels += static_cast<double>(face.pinhole.width_px) * face.pinhole.height_px;
    }
    const double picture = static_cast<double>(lens.width_px) * lens.height_px;
    constexpr double kMost = 1.4;  // 1.25 and margins
    EXPECT_LT(pixels, kMost * picture) << name;
    // As fine in the middle as the lens draws, or not much coarser.
    EXPECT_GT(view.faces().front().pinhole.fx_px, 0.6 * lens.fx_px) << name;
  }
}

TEST(LensView, APinholesPictureIsTheDrawnOne) {
  cv::Mat drawn;
  LensView view(pinhole(320, 240, deg_to_rad(80)));
  const cv::Mat bgr = view.draw(
                              [&drawn](const View& v, const Ask& ask) {
                                Drawn out = draw_smooth(v, ask);
                                drawn = out.bgr;
                                return out;
                              },
                              kTurned, 1, {})
                          .bgr;
  EXPECT_EQ(bgr.data, drawn.data);
}

TEST(LensView, RowsAreThoseOfTheWholePicture) {
  const Ask ask{.depth = true};
  for (const auto& [name, lens] : lenses()) {
    LensView view(lens);
    const Drawn whole = view.draw(draw_smooth, kTurned, 1, ask);
    for (const cv::Range& rows : {cv::Range(0, 17), cv::Range(100, 140), cv::Range(230, 240)}) {
      const Drawn part = view.draw(draw_smooth, kTurned, 1, ask, rows.start, rows.end);
      constexpr double kRounding_grey = 1;
      EXPECT_LE(cv::norm(part.bgr, whole.bgr.rowRange(rows), cv::NORM_INF), kRounding_grey) << name;
      constexpr double kRounding_m = 1e-5;
      EXPECT_LE(cv::norm(part.depth_m, whole.depth_m.rowRange(rows), cv::NORM_INF), kRounding_m)
          << name;
    }
  }
}

}  // namespace
}  // namespace panoptes::sim

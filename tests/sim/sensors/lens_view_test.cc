// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lens_view.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/sim/render/crowded_room.h"
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

RenderedImage draw_smooth(const View& view, const RenderOutputs& outputs) {
  return draw_sphere(smooth, view, outputs);
}

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
  const RenderOutputs outputs{.floor_label = true, .depth = true, .instance = true};
  for (const auto& [name, lens] : lenses()) {
    LensView view(lens);
    const RenderedImage rendered = view.draw(draw_smooth, kTurned, 1, outputs);
    int wrong_labels = 0;
    int wrong_instances = 0;
    double worst_m = 0;
    for (int v = 0; v < lens.height_px; ++v) {
      for (int u = 0; u < lens.width_px; ++u) {
        const Vec3 d_camera = lens.direction(Vec2(u, v)).value();
        const Vec3 d_scene = kTurned.rotation * d_camera;
        wrong_labels += (rendered.floor_label.at<std::uint8_t>(v, u) != 0) != (d_scene.z() < 0);
        wrong_instances += rendered.instance.at<std::uint16_t>(v, u) !=
                           1 + (d_scene.x() < 0) + 2 * (d_scene.y() < 0);
        const bool along_rays = std::holds_alternative<Equidistant>(lens.distortion);
        const double depth_m = kSphere_m * (along_rays ? 1 : d_camera.z());
        worst_m = std::max(worst_m, std::abs(rendered.depth_m.at<float>(v, u) - depth_m));
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
  const auto white = [](const View& view, const RenderOutputs& outputs) {
    return draw_sphere([](const Vec3& /*d_scene*/) { return Vec3::Ones(); }, view, outputs);
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
    for (const PinholeFaces::Face& face : view.faces()) {
      pixels += static_cast<double>(face.pinhole.width_px) * face.pinhole.height_px;
    }
    const double picture = static_cast<double>(lens.width_px) * lens.height_px;
    constexpr double kMost = 1.65;  // 1.5 and margins
    EXPECT_LT(pixels, kMost * picture) << name;
    // As fine in the middle as the lens draws, or not much coarser.
    EXPECT_GT(view.faces().front().pinhole.fx_px, 0.6 * lens.fx_px) << name;
  }
}

TEST(LensView, APinholesPictureIsTheDrawnOne) {
  cv::Mat rendered;
  LensView view(pinhole(320, 240, deg_to_rad(80)));
  const cv::Mat bgr = view.draw(
                              [&rendered](const View& v, const RenderOutputs& outputs) {
                                RenderedImage out = draw_smooth(v, outputs);
                                rendered = out.bgr;
                                return out;
                              },
                              kTurned, 1, {})
                          .bgr;
  EXPECT_EQ(bgr.data, rendered.data);
}

TEST(LensView, RowsAreThoseOfTheWholePicture) {
  const RenderOutputs outputs{.depth = true};
  for (const auto& [name, lens] : lenses()) {
    LensView view(lens);
    const RenderedImage whole = view.draw(draw_smooth, kTurned, 1, outputs);
    for (const cv::Range& rows : {cv::Range(0, 17), cv::Range(100, 140), cv::Range(230, 240)}) {
      const RenderedImage part = view.draw(draw_smooth, kTurned, 1, outputs, rows.start, rows.end);
      constexpr double kRounding_grey = 1;
      EXPECT_LE(cv::norm(part.bgr, whole.bgr.rowRange(rows), cv::NORM_INF), kRounding_grey) << name;
      constexpr double kRounding_m = 1e-5;
      EXPECT_LE(cv::norm(part.depth_m, whole.depth_m.rowRange(rows), cv::NORM_INF), kRounding_m)
          << name;
    }
  }
}

const RenderOutputs kAll{.floor_label = true, .depth = true, .instance = true};
const Pose3 kInRoom = mounted_camera({0, 0, 0.5}, 1, 0.1);

LensView::Draw drawing(Renderer& renderer) {
  return [&renderer](const View& view, const RenderOutputs& outputs) {
    return renderer.draw(view, outputs);
  };
}

TEST(LensView, EachPixelShowsWhatAPinholeAlongItsDirectionSees) {
  Renderer renderer(crowded_room());
  for (const auto& [name, lens] : lenses()) {
    const LensView view(lens);
    const RenderedImage rendered = view.draw(drawing(renderer), kInRoom, 1, kAll);
    Rng rng(3);
    int others = 0;
    constexpr int kLooks = 1000;
    for (int i = 0; i < kLooks; ++i) {
      const int u = static_cast<int>(rng.uniform() * lens.width_px);
      const int v = static_cast<int>(rng.uniform() * lens.height_px);
      const Vec3 d_camera = lens.direction(Vec2(u, v)).value();
      const Pose3 T_camera_ray{Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), d_camera),
                               Vec3::Zero()};
      const View alone{{1, 1, lens.fx_px, lens.fy_px, 0, 0, {}}, kInRoom * T_camera_ray};
      const RenderedImage one = renderer.draw(alone, kAll);
      const bool same_object =
          one.instance.at<std::uint16_t>(0, 0) == rendered.instance.at<std::uint16_t>(v, u);
      const double depth_per_range =
          std::holds_alternative<Equidistant>(lens.distortion) ? 1 : d_camera.z();
      const double inverse_depth = 1 / (one.depth_m.at<float>(0, 0) * depth_per_range);
      const double seen_inverse_depth = 1 / rendered.depth_m.at<float>(v, u);
      others += !same_object ||
                std::abs(seen_inverse_depth - inverse_depth) > 1e-3 * std::abs(inverse_depth);
    }
    // Half a drawn pixel from its edge a thing may be seen beyond it.
    EXPECT_LT(others, 0.03 * kLooks) << name;
  }
}

TEST(LensView, OpenGlShowsTheSame) {
  RendererOptions options;
  Renderer ours(crowded_room(), options);
  options.painter = PainterKind::kOsMesa;
  Renderer theirs(crowded_room(), options);
  for (const auto& [name, lens] : lenses()) {
    const LensView view(lens);
    const RenderedImage a = view.draw(drawing(ours), kInRoom, 1, kAll);
    const RenderedImage b = view.draw(drawing(theirs), kInRoom, 1, kAll);
    cv::Mat blurred_a;
    cv::Mat blurred_b;
    cv::blur(a.bgr, blurred_a, {5, 5});
    cv::blur(b.bgr, blurred_b, {5, 5});
    EXPECT_LT(share_differing(blurred_a, blurred_b, 8), 0.01) << name;
    EXPECT_LT(share_differing(a.instance, b.instance, 0), 0.002) << name;
    EXPECT_LT(share_differing(a.floor_label, b.floor_label, 0), 0.002) << name;
  }
}

TEST(LensView, NarrowVectorsDrawTheSameBits) {
  RendererOptions options;
  Renderer wide(crowded_room(), options);
  options.narrow_vectors = true;
  Renderer narrow(crowded_room(), options);
  for (const auto& [name, lens] : lenses()) {
    const LensView view(lens);
    const RenderedImage a = view.draw(drawing(wide), kInRoom, 1, kAll);
    const RenderedImage b = view.draw(drawing(narrow), kInRoom, 1, kAll);
    EXPECT_EQ(cv::norm(a.bgr, b.bgr, cv::NORM_INF), 0) << name;
    EXPECT_EQ(cv::norm(a.floor_label, b.floor_label, cv::NORM_INF), 0) << name;
    EXPECT_EQ(cv::norm(1 / a.depth_m, 1 / b.depth_m, cv::NORM_INF), 0) << name;
    EXPECT_EQ(cv::norm(a.instance, b.instance, cv::NORM_INF), 0) << name;
  }
}

}  // namespace
}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
// Our painter against OpenGL's, which knows nothing of it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/rng.h"
#include "sim/world/load.h"
#include "tests/sim/render/crowded_room.h"

namespace panoptes::sim {
namespace {

RenderedImage drawn_by(PainterKind painter, const World& world, const View& view) {
  RendererOptions options;
  options.painter = painter;
  Renderer renderer(world, options);
  return renderer.draw(view, {.floor_label = true, .depth = true, .instance = true});
}

TEST(Painters, AgreeInACrowdedRoom) {
  const World world = crowded_room();
  for (int i = 0; i < 8; ++i) {
    View view{pinhole(203, 151, deg_to_rad(60 + 8 * i)),
              mounted_camera({0, 0, 0.2 + 0.15 * i}, deg_to_rad(50 * i), deg_to_rad(4 * i - 10))};
    view.intrinsics.cx_px += 3 * i;
    const RenderedImage ours = drawn_by(PainterKind::kSoftware, world, view);
    const RenderedImage theirs = drawn_by(PainterKind::kOsMesa, world, view);
    EXPECT_LT(share_differing(ours.bgr, theirs.bgr, 2), 0.01) << i;
    EXPECT_LT(share_differing(ours.instance, theirs.instance, 0), 0.002) << i;
    EXPECT_LT(share_differing(ours.floor_label, theirs.floor_label, 0), 0.002) << i;
    cv::Mat inverse_ours = 1 / ours.depth_m;
    cv::Mat inverse_theirs = 1 / theirs.depth_m;
    EXPECT_LT(share_differing(inverse_ours, inverse_theirs, 1e-4), 0.002) << i;
  }
}

/// A hall seen from inside, each of its faces cut into many triangles of all shapes.
World closed_hall(Rng& rng) {
  World world;
  world.ambient = 1;
  world.sky_bgr = {1, 1, 1};
  world.textures = {{"grey", cv::Mat(64, 64, CV_8UC3, kGrey)}};
  std::vector<Triangle> faces = box({-6, -4, -1}, {6, 4, 3});
  for (Triangle& t : faces) {
    std::swap(t.corners[1], t.corners[2]);
  }
  for (int i = 0; i < 600; ++i) {
    const auto k = static_cast<std::size_t>(rng.uniform() * static_cast<double>(faces.size()));
    const Triangle whole = faces[k];
    // A point on the triangle, kept as it is: every part that has it has the same bits.
    const double a = 0.1 + 0.6 * rng.uniform();
    const double b = (1 - a) * (0.1 + 0.8 * rng.uniform());
    Corner middle = whole.corners[0];
    middle.p_object = a * whole.corners[0].p_object + b * whole.corners[1].p_object +
                      (1 - a - b) * whole.corners[2].p_object;
    for (std::size_t side = 0; side < 3; ++side) {
      Triangle part = whole;
      part.corners[side] = middle;
      if (side == 0) {
        faces[k] = part;
      } else {
        faces.push_back(part);
      }
    }
  }
  world.objects = {{"hall", {}, std::move(faces)}};
  return world;
}

TEST(Painters, NoSkyShowsBetweenTrianglesThatTouch) {
  Rng rng(8);
  RendererOptions options;
  Renderer renderer(closed_hall(rng), options);
  for (int i = 0; i < 60; ++i) {
    // In the middle, then ever closer to a corner of the hall.
    const double near = 1 - std::pow(0.9, i);
    const View view{pinhole(180 + i, 133, deg_to_rad(40 + 1.5 * i)),
                    mounted_camera({5.9 * near, 3.9 * near, 2.9 * near}, 6.3 * rng.uniform(),
                                   2 * rng.uniform() - 1)};
    const RenderedImage rendered = renderer.draw(view, {.depth = true, .instance = true});
    EXPECT_EQ(cv::countNonZero(rendered.instance == 0), 0) << i;
    EXPECT_LT(*std::max_element(rendered.depth_m.begin<float>(), rendered.depth_m.end<float>()),
              20);
  }
}

TEST(Painters, NoSkyShowsWhereACornerLiesOnAnothersEdge) {
  // A floor of strips, each of tiles as long as no other strip's.
  World world;
  world.ambient = 1;
  world.textures = {{"grey", cv::Mat(64, 64, CV_8UC3, kGrey)}};
  std::vector<Triangle> tiles;
  for (int strip = 0; strip < 40; ++strip) {
    const int count = 7 + 5 * (strip % 9);
    const double y_m = 0.1 * strip - 2;
    for (int i = 0; i < count; ++i) {
      const double from_m = -2 + 4.0 * i / count;
      const double to_m = -2 + 4.0 * (i + 1) / count;
      const Corner a{{from_m, y_m, 0}, {0, 0}};
      const Corner b{{to_m, y_m, 0}, {1, 0}};
      const Corner c{{to_m, y_m + 0.1, 0}, {1, 1}};
      const Corner d{{from_m, y_m + 0.1, 0}, {0, 1}};
      tiles.push_back({{a, b, c}, 0});
      tiles.push_back({{a, c, d}, 0});
    }
  }
  world.objects = {{"floor", {}, tiles}};
  Renderer renderer(world);
  Rng rng(4);
  for (int i = 0; i < 60; ++i) {
    const Vec3 eye(rng.uniform() - 0.5, rng.uniform() - 0.5, 0.3 + 0.3 * rng.uniform());
    const View view{pinhole(320, 240, deg_to_rad(60)),
                    mounted_camera(eye, 6.3 * rng.uniform(), deg_to_rad(70))};
    const RenderedImage rendered = renderer.draw(view, {.instance = true});
    EXPECT_EQ(cv::countNonZero(rendered.instance == 0), 0) << i;
  }
}

TEST(Painters, PicturesOfAnySizeArePartsOfTheSame) {
  const World world = crowded_room();
  Renderer renderer(world);
  View whole{pinhole(160, 120, deg_to_rad(80)), mounted_camera({0, 0, 0.5}, 1, 0.1)};
  const RenderOutputs all{.floor_label = true, .depth = true, .instance = true};
  const RenderedImage big = renderer.draw(whole, all);
  for (const cv::Rect part : {cv::Rect(0, 0, 160, 120), cv::Rect(37, 11, 1, 1),
                              cv::Rect(8, 16, 9, 7), cv::Rect(101, 40, 59, 80)}) {
    View view = whole;
    view.intrinsics.width_px = part.width;
    view.intrinsics.height_px = part.height;
    view.intrinsics.cx_px -= part.x;
    view.intrinsics.cy_px -= part.y;
    const RenderedImage small = renderer.draw(view, all);
    EXPECT_LT(share_differing(small.bgr, big.bgr(part), 1), 0.001) << part;
    EXPECT_LT(share_differing(small.instance, big.instance(part), 0), 0.001) << part;
    EXPECT_EQ(small.depth_m.size(), part.size());
    EXPECT_EQ(small.floor_label.size(), part.size());
  }
}

TEST(Painters, NarrowVectorsDrawTheSameBits) {
  const World world = crowded_room();
  RendererOptions narrow;
  narrow.narrow_vectors = true;
  Renderer one(world);
  Renderer other(world, narrow);
  for (int i = 0; i < 5; ++i) {
    const View view{pinhole(203, 151, deg_to_rad(90)), mounted_camera({0, 0, 0.5}, i, 0.1)};
    const RenderOutputs all{.floor_label = true, .depth = true, .instance = true};
    const RenderedImage a = one.draw(view, all);
    const RenderedImage b = other.draw(view, all);
    EXPECT_EQ(cv::norm(a.bgr, b.bgr, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(a.floor_label, b.floor_label, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(1 / a.depth_m, 1 / b.depth_m, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(a.instance, b.instance, cv::NORM_INF), 0);
  }
}

}  // namespace
}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/texture_arrays.h"

#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace panoptes::sim {
namespace {

cv::Mat stripes(int width_px, int height_px) {
  cv::Mat bgr(height_px, width_px, CV_8UC3, cv::Scalar(10, 20, 30));
  bgr.colRange(0, width_px / 2).setTo(cv::Scalar(200, 100, 50));
  return bgr;
}

World world_of(const std::vector<cv::Mat>& pictures) {
  World world;
  for (const cv::Mat& bgr : pictures) {
    world.textures.push_back({"", bgr});
  }
  return world;
}

TEST(TextureArrays, PicturesOfOneSizeShareOne) {
  const TextureArrays sorted =
      sort_textures(world_of({stripes(64, 64), stripes(500, 300), stripes(60, 40)}));
  ASSERT_EQ(sorted.arrays.size(), 2U);
  EXPECT_EQ(sorted.arrays[0].width_px, 64);
  EXPECT_EQ(sorted.arrays[0].textures, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(sorted.arrays[1].width_px, 512);
  EXPECT_EQ(sorted.arrays[1].height_px, 512);
  EXPECT_EQ(sorted.places[2].array, 0U);
  EXPECT_EQ(sorted.places[2].layer, 1);
  EXPECT_FALSE(sorted.places[2].uv);
}

TEST(TextureArrays, PlainColoursShareALayerAndKeepTheirColour) {
  World world;
  for (int i = 0; i < 20000; ++i) {
    world.textures.push_back({"", cv::Mat(3, 5, CV_8UC3, cv::Scalar(i % 256, i / 256 % 256, 7))});
  }
  const TextureArrays sorted = sort_textures(world);
  ASSERT_EQ(sorted.arrays.size(), 1U);
  EXPECT_EQ(sorted.arrays[0].palettes.size(), 2U);
  for (const int i : {0, 1, 255, 256, 16383, 16384, 19999}) {
    const TexturePlace& place = sorted.places[static_cast<std::size_t>(i)];
    ASSERT_TRUE(place.uv);
    const cv::Mat layer =
        detail_levels(world, sorted.arrays[0], static_cast<std::size_t>(place.layer))[0];
    const Vec2 px = *place.uv * layer.cols - Vec2(0.5, 0.5);
    // The four pixels that are looked at.
    for (const int dx : {0, 1}) {
      for (const int dy : {0, 1}) {
        const auto seen =
            layer.at<cv::Vec4b>(static_cast<int>(px.y()) + dy, static_cast<int>(px.x()) + dx);
        EXPECT_EQ(seen, cv::Vec4b(static_cast<std::uint8_t>(i % 256),
                                  static_cast<std::uint8_t>(i / 256 % 256), 7, 255));
      }
    }
  }
}

TEST(TextureArrays, LargePicturesGiveWayToTheMemoryThereIs) {
  const World world = world_of({stripes(4096, 2048), stripes(1024, 1024), stripes(16, 16)});
  EXPECT_EQ(sort_textures(world).arrays[0].width_px, 1024);
  EXPECT_EQ(sort_textures(world).arrays[0].textures.size(), 2U);
  const TextureArrays sorted = sort_textures(world, 1024, 3 << 20);
  std::size_t bytes = 0;
  for (const TextureArray& array : sorted.arrays) {
    bytes +=
        array.textures.size() * static_cast<std::size_t>(array.width_px * array.height_px) * 16 / 3;
  }
  EXPECT_LE(bytes, 3U << 20U);
}

TEST(TextureArrays, LevelsOfDetailAreMeansDownToOnePixel) {
  const World world = world_of({stripes(8, 4)});
  const std::vector<cv::Mat> levels = detail_levels(world, sort_textures(world).arrays[0], 0);
  ASSERT_EQ(levels.size(), 4U);
  EXPECT_EQ(levels[1].size(), cv::Size(4, 2));
  EXPECT_EQ(levels[3].size(), cv::Size(1, 1));
  EXPECT_EQ(levels[3].at<cv::Vec4b>(0, 0), cv::Vec4b(105, 60, 40, 255));
}

TEST(TextureArrays, OddSizesAreShrunkByAreaAndGrownBetweenPixels) {
  cv::Mat bgr(1, 3, CV_8UC3, cv::Scalar(0, 0, 0));
  bgr.at<cv::Vec3b>(0, 2) = {90, 90, 90};
  TextureArray array;
  array.width_px = 2;
  array.textures = {0};
  World world = world_of({bgr});
  EXPECT_EQ(detail_levels(world, array, 0)[0].at<cv::Vec4b>(0, 1)[0], 60);  // a third and a whole
  array.width_px = 6;
  const cv::Mat grown = detail_levels(world, array, 0)[0];
  EXPECT_EQ(grown.at<cv::Vec4b>(0, 5)[0], 90);
  EXPECT_NEAR(grown.at<cv::Vec4b>(0, 4)[0], 68, 1);  // three quarters
}

}  // namespace
}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "sim/world/world.h"

namespace panoptes::sim {

/// Pictures of one size, one upon another.
struct TextureArray {
  int width_px = 1;  ///< powers of two
  int height_px = 1;
  std::vector<std::size_t> textures;  ///< in World::textures, a layer each
  std::vector<cv::Mat> palettes;      ///< further layers, of plain colours
};

/// Where a texture of the world is found.
struct TexturePlace {
  std::size_t array = 0;
  int layer = 0;
  std::optional<Vec2> uv;  ///< of a plain colour: the one place to look at
};

struct TextureArrays {
  std::vector<TextureArray> arrays;  ///< the ones with most layers first
  std::vector<TexturePlace> places;  ///< of each texture of the world
};

/// Sorts the textures of a world by size, each side rounded up to a power of two up to
/// `most_side_px`, and to less where they would take more than `most_bytes`. Plain colours share
/// layers.
TextureArrays sort_textures(const World& world, int most_side_px = 1024,
                            std::size_t most_bytes = std::size_t{256} << 20U);

/// A layer with its levels of detail, 8-bit BGRA, the finest first.
std::vector<cv::Mat> detail_levels(const World& world, const TextureArray& array,
                                   std::size_t layer);

}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/texture_arrays.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

constexpr int kPaletteSide_px = 512;
constexpr int kPatch_px = 4;  // of one colour: looked at in its middle, it knows no neighbours
constexpr int kPatches = kPaletteSide_px / kPatch_px;
constexpr std::size_t kMostLayers = 1024;  // OpenGL 4.5 takes 2048

using Size = std::pair<int, int>;

int power_of_two(int size_px, int most_px) {
  int side_px = 1;
  while (side_px < most_px && side_px < size_px) {
    side_px *= 2;
  }
  return side_px;
}

bool is_plain(const cv::Mat& bgr) {
  const auto first = bgr.at<cv::Vec3b>(0, 0);
  for (int row = 0; row < bgr.rows; ++row) {
    const auto* pixels = bgr.ptr<cv::Vec3b>(row);
    for (int column = 0; column < bgr.cols; ++column) {
      if (pixels[column] != first) {
        return false;
      }
    }
  }
  return true;
}

/// Half as large, the mean of each four pixels (of two where one side is 1 already).
cv::Mat halved(const cv::Mat& bgra) {
  cv::Mat half(std::max(1, bgra.rows / 2), std::max(1, bgra.cols / 2), CV_8UC4);
  const int down = bgra.rows > 1 ? 1 : 0;
  const std::ptrdiff_t right = bgra.cols > 1 ? 4 : 0;
  for (int row = 0; row < half.rows; ++row) {
    const auto* upper = bgra.ptr<std::uint8_t>(row << down);
    const auto* lower = bgra.ptr<std::uint8_t>((row << down) + down);
    auto* out = half.ptr<std::uint8_t>(row);
    for (int column = 0; column < half.cols; ++column) {
      const std::ptrdiff_t at = column * (4 + right);
      for (std::ptrdiff_t c = at; c < at + 4; ++c) {
        *out++ = static_cast<std::uint8_t>(
            (upper[c] + upper[c + right] + lower[c] + lower[c + right] + 2) / 4);
      }
    }
  }
  return half;
}

/// Which pixels of a line of `from` make up each pixel of one of `to`, and with what share: their
/// mean where it shrinks, between the nearest two where it grows.
std::vector<std::vector<std::pair<int, double>>> shares(int from, int to) {
  std::vector<std::vector<std::pair<int, double>>> all(static_cast<std::size_t>(to));
  const double scale = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    auto& parts = all[static_cast<std::size_t>(i)];
    if (from > to) {
      const double low = i * scale;
      const double high = std::min((i + 1) * scale, 1.0 * from);
      for (int k = static_cast<int>(low); k < from && k < high; ++k) {
        parts.emplace_back(k, (std::min(high, k + 1.0) - std::max(low, 1.0 * k)) / (high - low));
      }
    } else {
      const double at = std::clamp((i + 0.5) * scale - 0.5, 0.0, from - 1.0);
      const int k = std::min(static_cast<int>(at), std::max(from - 2, 0));
      parts.emplace_back(k, 1 - (at - k));
      parts.emplace_back(std::min(k + 1, from - 1), at - k);
    }
  }
  return all;
}

/// In arithmetic that is the same on every processor, which OpenCV's is not.
cv::Mat scaled_bgra(const cv::Mat& bgr, int width_px, int height_px) {
  cv::Mat out(height_px, width_px, CV_8UC4);
  if (bgr.cols == width_px && bgr.rows == height_px) {
    for (int row = 0; row < height_px; ++row) {
      const auto* in = bgr.ptr<std::uint8_t>(row);
      auto* pixels = out.ptr<std::uint8_t>(row);
      for (int column = 0; column < width_px; ++column, in += 3, pixels += 4) {
        pixels[0] = in[0];
        pixels[1] = in[1];
        pixels[2] = in[2];
        pixels[3] = 255;
      }
    }
    return out;
  }
  const auto across = shares(bgr.cols, width_px);
  const auto down = shares(bgr.rows, height_px);
  std::vector<double> wide(static_cast<std::size_t>(bgr.rows) * static_cast<std::size_t>(width_px) *
                           3);
  std::size_t at = 0;
  for (int row = 0; row < bgr.rows; ++row) {
    const auto* in = bgr.ptr<std::uint8_t>(row);
    for (const auto& parts : across) {
      for (std::ptrdiff_t c = 0; c < 3; ++c) {
        for (const auto& [k, share] : parts) {
          wide[at] += share * in[3 * static_cast<std::ptrdiff_t>(k) + c];
        }
        ++at;
      }
    }
  }
  for (int row = 0; row < height_px; ++row) {
    auto* pixels = out.ptr<std::uint8_t>(row);
    for (std::size_t column = 0; column < across.size(); ++column) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (const auto& [k, share] : down[static_cast<std::size_t>(row)]) {
          sum += share * wide[(static_cast<std::size_t>(k) * across.size() + column) * 3 + c];
        }
        *pixels++ = static_cast<std::uint8_t>(std::lround(sum));
      }
      *pixels++ = 255;
    }
  }
  return out;
}

std::size_t bytes_of(const std::map<Size, std::vector<std::size_t>>& by_size) {
  std::size_t bytes = 0;
  for (const auto& [size, textures] : by_size) {
    bytes += textures.size() * static_cast<std::size_t>(size.first) *
             static_cast<std::size_t>(size.second) * 4 * 4 / 3;
  }
  return bytes;
}

}  // namespace

TextureArrays sort_textures(const World& world, int most_side_px, std::size_t most_bytes) {
  TextureArrays sorted;
  sorted.places.resize(world.textures.size());
  std::vector<std::size_t> plain;
  std::vector<std::size_t> pictures;
  for (std::size_t t = 0; t < world.textures.size(); ++t) {
    const cv::Mat& bgr = world.textures[t].bgr;
    PANOPTES_CHECK(bgr.type() == CV_8UC3 && !bgr.empty(), "textures are 8-bit BGR");
    (is_plain(bgr) ? plain : pictures).push_back(t);
  }
  std::map<Size, std::vector<std::size_t>> by_size;
  do {
    by_size.clear();
    for (const std::size_t t : pictures) {
      const cv::Mat& bgr = world.textures[t].bgr;
      by_size[{power_of_two(bgr.cols, most_side_px), power_of_two(bgr.rows, most_side_px)}]
          .push_back(t);
    }
    most_side_px /= 2;
  } while (bytes_of(by_size) > most_bytes && most_side_px >= 1);

  for (const auto& [size, textures] : by_size) {
    for (std::size_t first = 0; first < textures.size(); first += kMostLayers) {
      TextureArray& array = sorted.arrays.emplace_back();
      array.width_px = size.first;
      array.height_px = size.second;
      const std::size_t end = std::min(first + kMostLayers, textures.size());
      array.textures.assign(textures.begin() + static_cast<std::ptrdiff_t>(first),
                            textures.begin() + static_cast<std::ptrdiff_t>(end));
    }
  }
  std::stable_sort(sorted.arrays.begin(), sorted.arrays.end(),
                   [](const TextureArray& a, const TextureArray& b) {
                     return a.textures.size() > b.textures.size();
                   });
  // Colours go with the most used pictures that are large enough, so that one call draws both.
  std::size_t with_palette = 0;
  while (with_palette < sorted.arrays.size() &&
         (sorted.arrays[with_palette].width_px != kPaletteSide_px ||
          sorted.arrays[with_palette].height_px != kPaletteSide_px)) {
    ++with_palette;
  }
  if (with_palette == sorted.arrays.size() && (!plain.empty() || sorted.arrays.empty())) {
    sorted.arrays.push_back({kPaletteSide_px, kPaletteSide_px, {}, {}});
  }
  for (std::size_t a = 0; a < sorted.arrays.size(); ++a) {
    for (std::size_t l = 0; l < sorted.arrays[a].textures.size(); ++l) {
      sorted.places[sorted.arrays[a].textures[l]] = {a, static_cast<int>(l), std::nullopt};
    }
  }
  for (std::size_t i = 0; i < plain.size(); ++i) {
    TextureArray& array = sorted.arrays[with_palette];
    const int patch = static_cast<int>(i % (kPatches * kPatches));
    if (patch == 0) {
      array.palettes.push_back(cv::Mat::zeros(kPaletteSide_px, kPaletteSide_px, CV_8UC3));
    }
    const cv::Rect place(patch % kPatches * kPatch_px, patch / kPatches * kPatch_px, kPatch_px,
                         kPatch_px);
    array.palettes.back()(place).setTo(world.textures[plain[i]].bgr.at<cv::Vec3b>(0, 0));
    sorted.places[plain[i]] = {
        with_palette, static_cast<int>(array.textures.size() + array.palettes.size()) - 1,
        Vec2(place.x + kPatch_px / 2.0, place.y + kPatch_px / 2.0) / kPaletteSide_px};
  }
  return sorted;
}

std::vector<cv::Mat> detail_levels(const World& world, const TextureArray& array,
                                   std::size_t layer) {
  const cv::Mat& bgr = layer < array.textures.size()
                           ? world.textures[array.textures[layer]].bgr
                           : array.palettes[layer - array.textures.size()];
  std::vector<cv::Mat> levels{scaled_bgra(bgr, array.width_px, array.height_px)};
  while (levels.back().cols > 1 || levels.back().rows > 1) {
    levels.push_back(halved(levels.back()));
  }
  return levels;
}

}  // namespace panoptes::sim

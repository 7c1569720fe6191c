// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/local_features.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/vision/grey.h"

namespace panoptes {
namespace {

constexpr float kPyramidStep = 1.2F;
constexpr int kBorder_px = 10;      // nearer to the edge the descriptor sees mostly reflection
constexpr int kPatch_px = 15;       // radius over which a corner's direction is judged
constexpr int kApart_px = 3;        // a corner found again on another level is the same corner
constexpr float kElsewhere_px = 5;  // a second-best match this near is the same thing seen twice
constexpr int kWords = 4;           // of 64 bits
using Descriptor = std::array<std::uint64_t, kWords>;

struct Corner {
  cv::KeyPoint keypoint;
  int cell = 0;
  int rank = 0;  // in its cell
};

bool stronger(const Corner& a, const Corner& b) {
  if (a.keypoint.response != b.keypoint.response) {
    return a.keypoint.response > b.keypoint.response;
  }
  if (a.keypoint.octave != b.keypoint.octave) {
    return a.keypoint.octave < b.keypoint.octave;
  }
  if (a.keypoint.pt.y != b.keypoint.pt.y) {
    return a.keypoint.pt.y < b.keypoint.pt.y;
  }
  return a.keypoint.pt.x < b.keypoint.pt.x;
}

float scale_of(int level) { return std::pow(kPyramidStep, static_cast<float>(level)); }

cv::Size size_of(int level, cv::Size whole) {
  const float scale = scale_of(level);
  return {cvRound(static_cast<float>(whole.width) / scale),
          cvRound(static_cast<float>(whole.height) / scale)};
}

/// Where the picture shows what a level of its pyramid has at a pixel: the pixels of both meet at
/// the picture's edges, not in the middle of the first one, as ORB counts.
Eigen::Vector2f px_of(const cv::KeyPoint& keypoint, cv::Size whole) {
  const float scale = scale_of(keypoint.octave);
  const cv::Size level = size_of(keypoint.octave, whole);
  const auto at = [](float level_px, int size, int level_size) {
    return (level_px + 0.5F) * static_cast<float>(size) / static_cast<float>(level_size) - 0.5F;
  };
  return {at(keypoint.pt.x / scale, whole.width, level.width),
          at(keypoint.pt.y / scale, whole.height, level.height)};
}

std::vector<cv::Mat> pyramid_of(const cv::Mat& grey, int levels) {
  std::vector<cv::Mat> pyramid{grey};
  for (int level = 1; level < levels; ++level) {
    pyramid.emplace_back();
    cv::resize(grey, pyramid.back(), size_of(level, grey.size()), 0, 0, cv::INTER_AREA);
  }
  return pyramid;
}

// Degrees from the picture's x axis, as ORB takes them.
float centroid_direction_deg(const cv::Mat& level, const cv::Point2f& level_px) {
  const int column = cvRound(level_px.x);
  const int row = cvRound(level_px.y);
  const int radius =
      std::min({kPatch_px, column, row, level.cols - 1 - column, level.rows - 1 - row});
  int along_x = 0;
  int along_y = 0;
  for (int v = -radius; v <= radius; ++v) {
    const std::uint8_t* pixels = level.ptr<std::uint8_t>(row + v) + column;
    for (int u = -radius; u <= radius; ++u) {
      if (u * u + v * v <= radius * radius) {
        along_x += u * pixels[u];
        along_y += v * pixels[u];
      }
    }
  }
  return cv::fastAtan2(static_cast<float>(along_y), static_cast<float>(along_x));
}

std::vector<Corner> find_corners(const FeatureOptions& options,
                                 const std::vector<cv::Mat>& pyramid) {
  std::vector<Corner> corners;
  const cv::Mat& grey = pyramid[0];
  const int cells_across = (grey.cols + options.cell_px - 1) / options.cell_px;
  for (int level = 0; level < options.levels; ++level) {
    const float scale = scale_of(level);
    std::vector<cv::KeyPoint> found;
    cv::FAST(pyramid[level], found, options.fast_threshold_grey, true);
    for (cv::KeyPoint& keypoint : found) {
      keypoint.pt *= scale;
      keypoint.octave = level;
      keypoint.angle = 0;
      const auto x = static_cast<int>(keypoint.pt.x);
      const auto y = static_cast<int>(keypoint.pt.y);
      if (x < kBorder_px || y < kBorder_px || x >= grey.cols - kBorder_px ||
          y >= grey.rows - kBorder_px) {
        continue;
      }
      corners.push_back({keypoint, y / options.cell_px * cells_across + x / options.cell_px, 0});
    }
  }
  return corners;
}

// The strongest of each cell first, then the second of each, and so on.
std::vector<cv::KeyPoint> spread(const FeatureOptions& options, std::vector<Corner> corners,
                                 cv::Size size) {
  std::sort(corners.begin(), corners.end(), stronger);
  cv::Mat taken = cv::Mat::zeros(size, CV_8U);
  const int cells_across = (size.width + options.cell_px - 1) / options.cell_px;
  const int cells_down = (size.height + options.cell_px - 1) / options.cell_px;
  std::vector<int> in_cell(static_cast<std::size_t>(cells_across) * cells_down, 0);
  std::vector<Corner> kept;
  for (Corner& corner : corners) {
    const auto x = static_cast<int>(corner.keypoint.pt.x);
    const auto y = static_cast<int>(corner.keypoint.pt.y);
    if (taken.at<std::uint8_t>(y, x) != 0) {
      continue;
    }
    const cv::Rect around(x - kApart_px, y - kApart_px, 2 * kApart_px + 1, 2 * kApart_px + 1);
    taken(around).setTo(1);
    corner.rank = in_cell[corner.cell]++;
    kept.push_back(corner);
  }
  std::stable_sort(kept.begin(), kept.end(),
                   [](const Corner& a, const Corner& b) { return a.rank < b.rank; });
  kept.resize(std::min<std::size_t>(kept.size(), options.max_count));
  // ORB wants them level by level
  std::stable_sort(kept.begin(), kept.end(), [](const Corner& a, const Corner& b) {
    return a.keypoint.octave < b.keypoint.octave;
  });
  std::vector<cv::KeyPoint> keypoints;
  keypoints.reserve(kept.size());
  for (const Corner& corner : kept) {
    keypoints.push_back(corner.keypoint);
  }
  return keypoints;
}

std::vector<Descriptor> words_of(const cv::Mat& descriptors) {
  std::vector<Descriptor> words(descriptors.rows);
  for (int row = 0; row < descriptors.rows; ++row) {
    std::memcpy(words[row].data(), descriptors.ptr(row), sizeof(Descriptor));
  }
  return words;
}

[[gnu::always_inline]] inline void fill_distances(const std::vector<Descriptor>& a,
                                                  const std::vector<Descriptor>& b,
                                                  std::int16_t* bits) {
  for (const Descriptor& one : a) {
    for (const Descriptor& other : b) {
      int apart = 0;
      for (int word = 0; word < kWords; ++word) {
        apart += std::popcount(one[word] ^ other[word]);
      }
      *bits++ = static_cast<std::int16_t>(apart);
    }
  }
}

#if defined(__x86_64__)
// The same function where the processor counts bits in one instruction.
[[gnu::target("popcnt")]] void fill_distances_fast(const std::vector<Descriptor>& a,
                                                   const std::vector<Descriptor>& b,
                                                   std::int16_t* bits) {
  fill_distances(a, b, bits);
}
#endif

// Takes `a` for each point that it is nearer to than any before. In 16 bits and without branches:
// eight points at a time.
void keep_nearest(const std::int16_t* __restrict bits, int count, std::int16_t a,
                  std::int16_t* __restrict best_bits, std::int16_t* __restrict best_a) {
  for (int j = 0; j < count; ++j) {
    const bool nearer = bits[j] < best_bits[j];
    best_a[j] = nearer ? a : best_a[j];
    best_bits[j] = nearer ? bits[j] : best_bits[j];
  }
}

}  // namespace

void bind(Fields& f, FeatureOptions& o) {
  f("max_count", o.max_count, between(50, 5000));
  f("fast_threshold_grey", o.fast_threshold_grey, between(1, 100));
  f("levels", o.levels, between(1, 8));
  f("cell_px", o.cell_px, at_least(8));
  f("max_distance_bits", o.max_distance_bits, between(1, 256));
  f("ratio", o.ratio, between(0.1, 1.0));
}

LocalFeatures local_features(const FeatureOptions& options, const cv::Mat& picture,
                             DescriptorPose pose) {
  const cv::Mat grey = grey_of(picture);
  const std::vector<cv::Mat> pyramid = pyramid_of(grey, options.levels);
  std::vector<cv::KeyPoint> keypoints =
      spread(options, find_corners(options, pyramid), grey.size());
  for (cv::KeyPoint& keypoint : keypoints) {
    if (pose == DescriptorPose::kTurned) {
      keypoint.angle =
          centroid_direction_deg(pyramid[keypoint.octave], keypoint.pt / scale_of(keypoint.octave));
    }
  }
  LocalFeatures features;
  if (keypoints.empty()) {
    return features;
  }
  const cv::Ptr<cv::ORB> orb =
      cv::ORB::create(options.max_count, kPyramidStep, options.levels, kBorder_px - 1);
  orb->compute(grey, keypoints, features.descriptors);
  features.px.reserve(keypoints.size());
  for (const cv::KeyPoint& keypoint : keypoints) {
    features.px.push_back(px_of(keypoint, grey.size()));
  }
  PANOPTES_CHECK(features.descriptors.rows == static_cast<int>(features.px.size()),
                 "a descriptor for each point");
  return features;
}

std::vector<std::int16_t> descriptor_distances_bits(const cv::Mat& a, const cv::Mat& b) {
  const std::vector<Descriptor> all_a = words_of(a);
  const std::vector<Descriptor> all_b = words_of(b);
  std::vector<std::int16_t> bits(all_a.size() * all_b.size());
#if defined(__x86_64__)
  if (__builtin_cpu_supports("popcnt")) {
    fill_distances_fast(all_a, all_b, bits.data());
    return bits;
  }
#endif
  fill_distances(all_a, all_b, bits.data());
  return bits;
}

std::vector<FeatureMatch> match_features(const FeatureOptions& options, const LocalFeatures& a,
                                         const LocalFeatures& b) {
  std::vector<FeatureMatch> matches;
  const int count_a = a.descriptors.rows;
  const int count_b = b.descriptors.rows;
  if (count_a == 0 || count_b == 0) {
    return matches;
  }
  PANOPTES_CHECK(count_a <= std::numeric_limits<std::int16_t>::max(), "points count in 16 bits");
  const std::vector<std::int16_t> bits = descriptor_distances_bits(a.descriptors, b.descriptors);
  std::vector<std::int16_t> best_a_of(count_b, 0);
  std::vector<std::int16_t> best_bits_of(count_b, std::numeric_limits<std::int16_t>::max());
  for (int i = 0; i < count_a; ++i) {
    const std::int16_t* row = &bits[static_cast<std::size_t>(i) * count_b];
    keep_nearest(row, count_b, static_cast<std::int16_t>(i), best_bits_of.data(), best_a_of.data());
  }
  for (int i = 0; i < count_a; ++i) {
    const std::int16_t* row = &bits[static_cast<std::size_t>(i) * count_b];
    std::int16_t least = row[0];
    for (int j = 1; j < count_b; ++j) {
      least = std::min(least, row[j]);
    }
    if (least > options.max_distance_bits) {
      continue;
    }
    const int best = static_cast<int>(std::find(row, row + count_b, least) - row);
    if (best_a_of[best] != i) {
      continue;
    }
    const auto clearly = static_cast<std::int16_t>(least / options.ratio);
    int as_near = 0;  // itself among them
    for (int j = 0; j < count_b; ++j) {
      as_near += row[j] <= clearly ? 1 : 0;
    }
    bool unique = true;
    for (int j = 0; j < count_b && unique && as_near > 1; ++j) {
      unique = row[j] > clearly || j == best || (b.px[j] - b.px[best]).norm() < kElsewhere_px;
    }
    if (unique) {
      matches.push_back({i, best});
    }
  }
  return matches;
}

}  // namespace panoptes

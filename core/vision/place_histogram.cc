// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/check.h"
#include "core/vision/grey.h"

namespace panoptes {
namespace {

constexpr int kBins = 64;  // in one dimension
constexpr int kGrey_per_bin = 256 / kBins;
constexpr int kChannels = 3;
constexpr int kSide = 16;  // bins along each of two dimensions
constexpr int kGrey_per_side_bin = 256 / kSide;
constexpr int kGradient_per_side_bin = kBins / kSide;

using Counts = std::vector<std::int64_t>;

struct Direction {
  int grey;
  int gradient;
};
// About 22.5 degrees apart, along each of which cells fall on whole numbers.
constexpr std::array<Direction, 8> kDirections{
    {{1, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 1}, {-1, 2}, {-1, 1}, {-2, 1}}};

int bins_of(HistogramKind kind) {
  switch (kind) {
    case HistogramKind::kGrey:
    case HistogramKind::kGradient:
      return kBins;
    case HistogramKind::kColour:
      return kChannels * kBins;
    case HistogramKind::kTwoDimensional:
      return kSide * kSide;
  }
  return 0;
}

void count_colours(const cv::Mat& bgr, Counts& count) {
  for (int v = 0; v < bgr.rows; ++v) {
    const std::uint8_t* row = bgr.ptr<std::uint8_t>(v);
    for (int u = 0; u < bgr.cols; ++u) {
      for (int channel = 0; channel < kChannels; ++channel) {
        ++count[channel * kBins + row[kChannels * u + channel] / kGrey_per_bin];
      }
    }
  }
}

// Pixels at the border have no gradient and are left out.
void count_greys_and_gradients(HistogramKind kind, const cv::Mat& bgr, Counts& count) {
  const cv::Mat grey = grey_of(bgr);
  for (int v = 1; v + 1 < grey.rows; ++v) {
    const std::uint8_t* above = grey.ptr<std::uint8_t>(v - 1);
    const std::uint8_t* row = grey.ptr<std::uint8_t>(v);
    const std::uint8_t* below = grey.ptr<std::uint8_t>(v + 1);
    for (int u = 1; u + 1 < grey.cols; ++u) {
      if (kind == HistogramKind::kGrey) {
        ++count[row[u] / kGrey_per_bin];
        continue;
      }
      const int across = row[u + 1] - row[u - 1];  // over two pixels
      const int down = below[u] - above[u];
      const auto steep =
          static_cast<int>(std::sqrt(static_cast<float>(across * across + down * down)) / 2);
      const int gradient = std::min(steep, kBins - 1);
      if (kind == HistogramKind::kGradient) {
        ++count[gradient];
      } else {
        ++count[row[u] / kGrey_per_side_bin * kSide + gradient / kGradient_per_side_bin];
      }
    }
  }
}

// What `count` bins in a row hold up to the end of each, times `scale`.
void accumulate(const float* shares, int count, double scale, std::vector<float>& into) {
  double up_to = 0;
  for (int bin = 0; bin < count; ++bin) {
    up_to += shares[bin];
    into.push_back(static_cast<float>(scale * up_to));
  }
}

std::vector<float> cumulative_of(HistogramKind kind, const std::vector<float>& shares) {
  std::vector<float> all;
  if (kind != HistogramKind::kTwoDimensional) {  // of colour each channel holds a third
    for (std::size_t from = 0; from < shares.size(); from += kBins) {
      accumulate(shares.data() + from, kBins, 1, all);
    }
    return all;
  }
  for (const Direction& d : kDirections) {
    const int first = std::min(d.grey, 0) * (kSide - 1);
    const int positions = (std::abs(d.grey) + d.gradient) * (kSide - 1) + 1;
    std::vector<float> along(static_cast<std::size_t>(positions));
    for (int grey = 0; grey < kSide; ++grey) {
      for (int gradient = 0; gradient < kSide; ++gradient) {
        const int cell = grey * kSide + gradient;
        along[static_cast<std::size_t>(d.grey * grey + d.gradient * gradient - first)] +=
            shares[static_cast<std::size_t>(cell)];
      }
    }
    // cells a whole number apart along the direction are so much nearer on the plane
    const double length = std::hypot(d.grey, d.gradient);
    accumulate(along.data(), positions, 1 / (length * kDirections.size()), all);
  }
  return all;
}

// Eight sums side by side: their order is fixed, and yet they run in vector registers.
template <class Term>
float sum_over(const std::vector<float>& a, const std::vector<float>& b, const Term& term) {
  constexpr std::size_t kLanes = 8;
  std::array<float, kLanes> sums{};
  const std::size_t whole = a.size() / kLanes * kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      sums[lane] += term(a[i + lane], b[i + lane]);
    }
  }
  float total = 0;
  for (const float sum : sums) {
    total += sum;
  }
  for (std::size_t i = whole; i < a.size(); ++i) {
    total += term(a[i], b[i]);
  }
  return total;
}

}  // namespace

PlaceHistogram place_histogram(HistogramKind kind, const std::vector<cv::Mat>& pictures_bgr) {
  Counts count(static_cast<std::size_t>(bins_of(kind)), 0);
  for (const cv::Mat& bgr : pictures_bgr) {
    PANOPTES_CHECK(bgr.type() == CV_8UC3 && bgr.rows >= 3 && bgr.cols >= 3, "8-bit BGR");
    if (kind == HistogramKind::kColour) {
      count_colours(bgr, count);
    } else {
      count_greys_and_gradients(kind, bgr, count);
    }
  }
  std::int64_t total = 0;
  for (const std::int64_t of_bin : count) {
    total += of_bin;
  }
  PANOPTES_CHECK(total > 0, "at least one picture");
  PlaceHistogram histogram;
  for (const std::int64_t of_bin : count) {
    histogram.shares.push_back(
        static_cast<float>(static_cast<double>(of_bin) / static_cast<double>(total)));
  }
  histogram.cumulative = cumulative_of(kind, histogram.shares);
  return histogram;
}

double histogram_distance(HistogramDistance distance, const PlaceHistogram& a,
                          const PlaceHistogram& b) {
  PANOPTES_CHECK(a.shares.size() == b.shares.size(), "two histograms of a kind");
  switch (distance) {
    case HistogramDistance::kEmd:
      return sum_over(a.cumulative, b.cumulative, [](float x, float y) { return std::abs(x - y); });
    case HistogramDistance::kChiSquare: {
      constexpr float kNothing = 1e-20F;  // keeps two empty bins from being 0 / 0
      return 0.5 * sum_over(a.shares, b.shares, [](float x, float y) {
               return (x - y) * (x - y) / (x + y + kNothing);
             });
    }
    case HistogramDistance::kIntersection:
      // the same as 1 - sum of min(a, b) where both sum to 1, and 0 of two equal ones to the bit
      return 0.5 * sum_over(a.shares, b.shares, [](float x, float y) { return std::abs(x - y); });
    case HistogramDistance::kL2:
      return std::sqrt(
          sum_over(a.shares, b.shares, [](float x, float y) { return (x - y) * (x - y); }));
  }
  return 0;
}

}  // namespace panoptes

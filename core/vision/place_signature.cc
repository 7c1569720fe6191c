// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_signature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/check.h"
#include "core/vision/grey.h"

namespace panoptes {
namespace {

constexpr int kLevels = 256;
constexpr double kMiddle_grey = 128;  // where the mean is moved to
constexpr int kColumns = 4;           // of a grid's cells in a picture,
constexpr int kRows = 2;
constexpr int kCells = kColumns * kRows;
constexpr int kBins = 16;
constexpr int kShares = kCells * kBins;  // of a picture

using Counts = std::array<std::int64_t, kLevels>;

void count_greys(const cv::Mat& grey, Counts& count) {
  for (int row = 0; row < grey.rows; ++row) {
    const std::uint8_t* pixels = grey.ptr<std::uint8_t>(row);
    for (int column = 0; column < grey.cols; ++column) {
      ++count[pixels[column]];
    }
  }
}

cv::Mat cell_of(const cv::Mat& picture, int cell) {
  const int column = cell % kColumns;
  const int row = cell / kColumns;
  return picture(
      cv::Range(row * picture.rows / kRows, (row + 1) * picture.rows / kRows),
      cv::Range(column * picture.cols / kColumns, (column + 1) * picture.cols / kColumns));
}

// The cumulative shares of `bins` bins of equal width, every grey moved up by `shift`.
void accumulate(const Counts& count, double shift, int bins, float* cumulative) {
  std::int64_t total = 0;
  for (const std::int64_t of_level : count) {
    total += of_level;
  }
  std::array<double, kLevels> share{};
  const double width = static_cast<double>(kLevels) / bins;
  for (int grey = 0; grey < kLevels; ++grey) {
    // a fraction of a bin is split between two
    const double at = std::clamp((grey + shift + 0.5) / width - 0.5, 0.0, bins - 1.0);
    const int below = static_cast<int>(std::floor(at));
    const double above_share = at - below;
    const double mass = static_cast<double>(count[grey]) / static_cast<double>(total);
    share[below] += mass * (1 - above_share);
    share[std::min(below + 1, bins - 1)] += mass * above_share;
  }
  double up_to = 0;
  for (int bin = 0; bin < bins; ++bin) {
    up_to += share[bin];
    cumulative[bin] = static_cast<float>(up_to);
  }
}

}  // namespace

void bind(Fields& f, SignatureOptions& o) {
  f.word("method", o.method,
         {{"grid", SignatureMethod::kGrid}, {"mosaic", SignatureMethod::kMosaic}});
  f("subtract_mean", o.subtract_mean);
}

std::size_t signature_shares(bool grid, std::size_t pictures) {
  return grid ? kShares * pictures : kLevels;
}

PlaceSignature place_signature(const SignatureOptions& options,
                               const std::vector<cv::Mat>& pictures) {
  PANOPTES_CHECK(!pictures.empty(), "a picture");
  PlaceSignature signature;
  signature.grid = options.method == SignatureMethod::kGrid;
  std::vector<Counts> of_cell;
  Counts of_all{};
  for (const cv::Mat& picture : pictures) {
    const cv::Mat grey = grey_of(picture);
    PANOPTES_CHECK(grey.cols >= kColumns && grey.rows >= kRows, "a picture has cells");
    for (int cell = 0; cell < kCells; ++cell) {
      of_cell.emplace_back();
      count_greys(cell_of(grey, cell), of_cell.back());
      for (int level = 0; level < kLevels; ++level) {
        of_all[level] += of_cell.back()[level];
      }
    }
  }
  std::int64_t total = 0;
  std::int64_t sum = 0;
  for (int level = 0; level < kLevels; ++level) {
    total += of_all[level];
    sum += level * of_all[level];
  }
  const double shift = options.subtract_mean
                           ? kMiddle_grey - static_cast<double>(sum) / static_cast<double>(total)
                           : 0;
  if (!signature.grid) {
    signature.cumulative.resize(signature_shares(false, pictures.size()));
    accumulate(of_all, shift, kLevels, signature.cumulative.data());
    return signature;
  }
  signature.cumulative.resize(signature_shares(true, pictures.size()));
  for (std::size_t cell = 0; cell < of_cell.size(); ++cell) {
    accumulate(of_cell[cell], shift, kBins, signature.cumulative.data() + cell * kBins);
  }
  return signature;
}

namespace {

// Eight sums side by side, so that the order is fixed and yet runs in vector registers.
float l1(const float* a, const float* b, int count) {
  std::array<float, 8> sums{};
  for (int i = 0; i < count; i += 8) {
    for (int lane = 0; lane < 8; ++lane) {
      sums[lane] += std::abs(a[i + lane] - b[i + lane]);
    }
  }
  float total = 0;
  for (const float sum : sums) {
    total += sum;
  }
  return total;
}

float l1_of_pooled_cells(const float* a, const float* b) {
  float total = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    float apart = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      apart += a[cell * kBins + bin] - b[cell * kBins + bin];
    }
    total += std::abs(apart);
  }
  return total;
}

// A bin is this many levels wide, and each cell counts as much as any other.
double in_levels(float l1_of_shares, std::size_t pictures) {
  constexpr double kBin_grey = static_cast<double>(kLevels) / kBins;
  return l1_of_shares * kBin_grey / (static_cast<double>(kCells) * static_cast<double>(pictures));
}

}  // namespace

double emd_grey(const PlaceSignature& a, const PlaceSignature& b) {
  PANOPTES_CHECK(a.cumulative.size() == b.cumulative.size(), "pictures of the same cameras");
  const float apart =
      l1(a.cumulative.data(), b.cumulative.data(), static_cast<int>(a.cumulative.size()));
  return a.grid ? in_levels(apart, a.cumulative.size() / kShares) : apart;
}

double emd_grey(const PlaceSignature& a, const PlaceSignature& b, const Facing& facing) {
  if (!a.grid) {
    return emd_grey(a, b);
  }
  float apart = 0;
  for (const CameraPair& pair : facing.pairs) {
    const float* of_a = a.cumulative.data() + static_cast<std::ptrdiff_t>(pair.a) * kShares;
    const float* of_b = b.cumulative.data() + static_cast<std::ptrdiff_t>(pair.b) * kShares;
    apart += pair.turned ? l1_of_pooled_cells(of_a, of_b) : l1(of_a, of_b, kShares);
  }
  return in_levels(apart, facing.pairs.size());
}

}  // namespace panoptes
